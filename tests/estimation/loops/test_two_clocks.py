"""A law whose clock is not the log's is simulated as it runs and sampled as the log is."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, newton, simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.codegen.lowering.loop_settings import LoopStart
from axisid.control import BALANCED, ControlLaw, cascade_pd_averaged
from axisid.elements import Drive, coulomb, offset, viscous
from axisid.estimation import check_law
from axisid.estimation.loops.law_run import two_clocks
from axisid.estimation.regression.simulated_rows import simulated_loops
from axisid.estimation.simulation import LoopInputs, simulate_loop
from axisid.estimation.simulation.inputs import TwoClocks
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration.experiment import Move, back_and_forth
from axisid.support.errors import Missing
from tests.axes.simulated import F0, Fc, Fv, M, q
from tests.estimation.simulation.test_loop_start import THETA, p_pi

MOVES = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=2)
SHORT = back_and_forth(speeds=(0.04, 0.12), acceleration=0.8, seconds=0.5, repeat=1)
LOG = 1e-3


def stage(law: ControlLaw) -> GeneratedAxis:
    axis = newton(
        "stage",
        coordinate=q,
        parameters=(M, Fv, Fc, F0),
        inertia=M,
        resistance=(viscous(Fv, q), coulomb(Fc, q), offset(F0)),
        drive=Drive(gain=35.15, limit=100.0),
        control=law,
    )
    return build(axis)


def cascade(period: float) -> ControlLaw:
    return cascade_pd_averaged(kp=160.18, kv=243.45, period=period)


def cascade_p_pi(period: float) -> ControlLaw:
    return replace(p_pi(BALANCED), period=period)


def logged(
    axis: GeneratedAxis,
    period: float,
    noise: float = 0.0,
    late: int = 0,
    moves: tuple[Move, ...] = MOVES,
) -> Record:
    """The axis's loop with its set point made at every evaluation, as a log of another period."""
    law = axis.axis.control
    reference = trajectory(moves, law.period)
    rng = np.random.default_rng(1)
    errors = noise * rng.normal(size=len(reference))
    loop = simulate(axis, THETA, reference, law.period, position_noise=errors)
    time = period * np.arange(late, int((len(reference) - 2) * law.period / period))
    last = np.floor(time / law.period + 1e-6).astype(int)
    clocks = TwoClocks(samples=len(time) + late, log_period=period, law_period=law.period)
    inputs = LoopInputs(
        reference=np.interp(time, law.period * np.arange(len(reference)), reference),
        period=period,
        start=LoopStart(position=float(reference[0])),
    )
    of_law = inputs.at_law(axis, replace(clocks, samples=len(time)))
    between = simulate_loop(axis, np.array(THETA), of_law)
    exact = np.allclose(last * law.period, time)
    return Record(
        time=time,
        position=loop.measured_position[last] if exact else between.position,
        reference=np.interp(time, law.period * np.arange(len(reference)), reference),
        control=loop.control[last] if exact else between.control,
        sample_period=period,
    )


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_reference_runs_between_samples_as_declared(between: str) -> None:
    clocks = TwoClocks(samples=3, log_period=1.0, law_period=0.5, between=between)
    expected = [0.0, 0.5, 1.0, 2.0, 3.0, 3.0] if between == "linear" else [0, 0, 1, 1, 3, 3]
    assert clocks.reference(np.array([0.0, 1.0, 3.0])).tolist() == expected


def test_a_reference_is_smooth_between_samples_where_nothing_else_is_said() -> None:
    clocks = TwoClocks(samples=6, log_period=1.0, law_period=0.5)
    assert clocks.reference(np.arange(6.0) ** 3) == pytest.approx(clocks.times.clip(max=5.0) ** 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "log"),
    [
        (cascade(0.25e-3), 1e-3),
        (cascade_p_pi(1 / 16e3), 1e-3),
        (cascade_p_pi(0.4e-3), 1e-3),
        (cascade(1e-3), 0.25e-3),
        (cascade_p_pi(1e-3), 0.4e-3),
    ],
    ids=["4 kHz at 1 kHz", "P-PI of 16 kHz at 1 kHz", "2.5 times", "slower", "0.4 times"],
)
def test_instruments_are_within_a_fifth_of_a_percent(law: ControlLaw, log: float) -> None:
    axis = stage(law)
    record = logged(axis, log)
    estimate = identify(axis, record, methods=["idm-iv"])["idm-iv"]
    assert estimate.physical == pytest.approx(THETA, rel=2e-3)
    check = check_law(axis, record)
    assert check.passed
    assert check.residual_percent < 0.1
    (loop,) = simulated_loops(axis, record, THETA)
    assert np.abs(loop.position - record.position).max() < 1e-5


@pytest.mark.slow
def test_the_law_check_says_what_the_log_leaves_open_and_finds_a_wrong_law() -> None:
    law = cascade_p_pi(1 / 16e3)
    axis = stage(law)
    check = check_law(axis, logged(axis, 1e-3, noise=1e-8))
    assert check.passed
    assert "what it reads between the samples leaves 0." in check.meaning
    blurred = check_law(axis, logged(axis, 1e-3, noise=1e-6))
    assert isinstance(blurred, Missing)
    assert "of its control open" in blurred.reason
    record = logged(axis, 1e-3, noise=1e-8, moves=SHORT)
    for name in ("kp", "kv"):
        wrong = replace(law, gains={**law.gains, name: 1.1 * law.gains[name]})
        assert not check_law(stage(wrong), record).passed


@pytest.mark.slow
@pytest.mark.parametrize("late", range(4))
def test_a_faster_log_tells_when_its_law_is_evaluated(late: int) -> None:
    axis = stage(cascade(1e-3))
    record = logged(axis, 0.25e-3)
    part = Record(
        **{role: values[late:] for role, values in record.channels().items()},
        sample_period=0.25e-3,
    )
    clocks = two_clocks(axis, part, (0, len(part)))
    assert clocks.first == pytest.approx(-late * 0.25e-3)
    check = check_law(axis, part)
    assert check.passed
    assert check.delay == 0
