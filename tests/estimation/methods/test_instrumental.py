"""The instruments' iteration: it ends at its fixed point where whole steps swing around it."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, load_axis, simulate, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.diagnose import following
from axisid.estimation.estimates import NotSimulated
from axisid.estimation.estimates.estimate import Estimate
from axisid.estimation.methods.instrumental import NEARLY_CONVERGED
from axisid.estimation.thresholds import CONVERGED
from tests.refusals import refuses

SAMPLES = 5000


def white(name: str, amplitude: float, seed: int, *, noisy: bool) -> tuple[GeneratedAxis, Record]:
    """An axis of the library under a white reference, in parts of its own travel."""
    axis = build(load_axis(name))
    experiment, law = axis.axis.experiment, axis.axis.control
    truth = [experiment.truth.get(p.name, p.nominal) for p in axis.axis.parameters]
    travel = float(np.ptp(twin_record(axis, position_noise=0.0).position))
    rng = np.random.default_rng(seed)
    reference = rng.normal(0.0, amplitude * travel, SAMPLES)
    noise = rng.normal(0.0, experiment.position_noise, SAMPLES) if noisy else None
    loop = simulate(axis, truth, reference, law.period, position_noise=noise)
    record = Record(
        time=loop.time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
    )
    return axis, record


@pytest.mark.parametrize(
    ("name", "amplitude", "seed", "noisy"),
    [
        ("emps2015", 1e-3, 1, False),
        ("rotary_table", 1e-2, 1, False),
        ("linear_motor", 1e-3, 1, True),
        ("belt_axis", 1e-3, 0, True),
        ("crank", 1e-2, 0, False),
    ],
)
def test_a_white_reference_lets_the_instruments_end(
    name: str, amplitude: float, seed: int, noisy: bool
) -> None:
    axis, record = white(name, amplitude, seed, noisy=noisy)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    last, before = (estimate.iterates[k].physical for k in (-1, -2))
    moved = np.abs(last - before) / np.sqrt(np.diag(estimate.covariances["iid"]))
    assert moved.max() <= 2 * CONVERGED.value
    assert not any("jumps with the parameters" in remark for remark in estimate.remarks)


def test_a_loop_that_jumps_ends_near_and_says_so() -> None:
    axis, record = white("rotary_table", 1e-2, 1, noisy=True)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    (told,) = (r for r in estimate.remarks if "jumps with the parameters" in r)
    assert float(told.split("ends ")[1].split()[0]) <= NEARLY_CONVERGED


@pytest.fixture(scope="module")
def fitted() -> Estimate:
    axis = load_axis("emps2015")
    return identify(axis, twin_record(axis), methods="idm-ls")["idm-ls"]


def test_an_estimate_that_cannot_be_simulated_is_an_objection(fitted: Estimate) -> None:
    lost = replace(
        fitted,
        simulated=NotSimulated("it is too stiff.", by_estimate=True),
        simulation_error_percent=None,
    )
    check = following(lost, 0.0)
    assert check.status == "fail"
    assert check.meaning.endswith("recorded can: it is too stiff")
    untried = replace(lost, simulated=NotSimulated("it has no law"))
    untried = untried.with_inference(noise_free=None)
    assert following(untried, 0.0) == untried.simulated


@pytest.mark.slow
def test_estimates_without_inertia_fail_the_simulation() -> None:
    """Least squares needs no simulation, and yet says that there can be none."""
    axis = load_axis("emps2015")
    record = twin_record(axis)
    turned = replace(record, control=-record.control)
    result = identify(axis, turned, methods="idm-ls")
    (check,) = (c for c in result.verdict if c.name == "simulation")
    assert check.status == "fail"
    assert "no positive inertia" in check.meaning
    with refuses("simulation", says="no positive inertia"):
        identify(axis, turned, methods="idm-iv")


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (2.0, "the simulated loop follows the record"),
        (46.0, "the simulated loop follows the record but for 46 %"),
        (60.0, "leaves 60 % of the force unexplained; check the law, signs and units"),
    ],
)
def test_following_says_how_closely(fitted: Estimate, error: float, said: str) -> None:
    meaning = following(replace(fitted, simulation_error_percent=error), 0.0).meaning
    assert meaning == said or said in meaning


def test_rests_are_blamed_before_the_law(fitted: Estimate) -> None:
    check = following(replace(fitted, simulation_error_percent=300.0), 0.6)
    assert "the axis rests in 60 % of the samples" in check.meaning
    assert 'reversals="leave-out"' in check.meaning
