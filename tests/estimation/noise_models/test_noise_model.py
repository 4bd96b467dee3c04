"""Noise that is drawn is what its chain says, and twins are the loops of records with it."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.special import stdtrit

from axisid import (
    Prefilter,
    Record,
    build,
    fit,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import degrees_of_freedom_of
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.methods import METHODS
from axisid.estimation.noise_models import Chain, Twins, measured_noise, pair_freedom
from axisid.estimation.noise_models.noise_estimation import control_step, likeliest_variances
from axisid.estimation.noise_models.noise_model import (
    CORRELATION_TIMES,
    AntitheticDraws,
    MeasuredChain,
    spectrum,
)
from axisid.estimation.noise_models.twins import twin_of, twins_of
from axisid.estimation.records import sensor_steps
from axisid.estimation.regression import InverseForm
from axisid.estimation.regression.simulated_instruments import loop_equations
from axisid.estimation.signals import FilteredRecord
from benchmarks.machines import Machine, autoregressive, white
from tests.axes.bodies import body, force_law
from tests.refusals import refuses
from tests.unjudged import identify

PERIOD = 1e-3


@pytest.mark.parametrize("time", CORRELATION_TIMES)
def test_a_spectrum_is_of_variance_one_and_of_its_correlation(time: float) -> None:
    samples = 1 << 15
    correlation = np.fft.irfft(spectrum(time / PERIOD, samples), samples)
    assert correlation[0] == pytest.approx(1.0, rel=1e-9)
    one_later = np.exp(-PERIOD / time) if time else 0.0
    assert correlation[1] == pytest.approx(one_later, abs=1e-9)


def test_a_disturbance_is_the_sum_of_its_autoregressions() -> None:
    chain = Chain(disturbances=((0.0, 2.0), (0.05, 1.0)))
    rng = AntitheticDraws(np.random.default_rng(1))
    noise = np.array([chain.drawn_disturbance(rng, 4000, PERIOD) for _ in range(40)])
    lag = 20
    assert np.mean(noise**2) == pytest.approx(4.0 + 1.0, rel=0.03)
    later = np.mean(noise[:, lag:] * noise[:, :-lag])
    assert later == pytest.approx(np.exp(-lag * PERIOD / 0.05), abs=0.06)
    # One end is no neighbour of the other.
    assert abs(np.mean(noise[:, 0] * noise[:, -1])) < 2.5


def test_twins_of_a_measured_chain_have_any_of_its_disturbances_and_opposite_ones_the_same() -> (
    None
):
    sizes = (1.0, 10.0, 100.0)
    chain = MeasuredChain(disturbances=((0.0, 1.0),), drawn=tuple(((0.0, sd),) for sd in sizes))
    assert chain.likeliest == Chain(disturbances=((0.0, 1.0),))
    found = set()
    for seed in range(30):
        noise, opposite = (
            chain.drawn_disturbance(
                AntitheticDraws(np.random.default_rng(seed), sign), 4000, PERIOD
            )
            for sign in (1.0, -1.0)
        )
        np.testing.assert_array_equal(noise, -opposite)
        found.add(round(float(noise.std()), -int(np.log10(noise.std()))))
    assert found == set(sizes)
    assert not replace(chain, disturbances=()).is_silent


@pytest.mark.parametrize("time", [0.02, 1.0, 1e5])
def test_noise_is_stationary_from_the_first_sample_however_long_it_lasts(time: float) -> None:
    chain, rng, apart = (
        Chain(disturbances=((time, 0.5),)),
        AntitheticDraws(np.random.default_rng(2)),
        400,
    )
    noise = np.array([chain.drawn_disturbance(rng, 1000, PERIOD) for _ in range(400)])
    assert noise[:, [0, -1]].std(axis=0) == pytest.approx(0.5, rel=0.15)
    moved = np.std(noise[:, apart:] - noise[:, :-apart])
    assert moved == pytest.approx(0.5 * np.sqrt(-2 * np.expm1(-apart * PERIOD / time)), rel=0.15)


def test_noise_of_the_control_is_in_the_log_beside_its_steps() -> None:
    control, rng = np.zeros(4000), AntitheticDraws(np.random.default_rng(3))
    logged = Chain(control=((0.0, 0.3), (0.01, 0.4))).logged_control(rng, control, PERIOD)
    assert logged.std() == pytest.approx(0.5, rel=0.1)
    rounded = Chain(control_step=0.1).logged_control(rng, logged, PERIOD)
    assert np.unique(np.round(rounded % 0.1, 9) % 0.1).size <= 2
    assert np.abs(rounded - logged).max() <= 0.05 + 1e-12


@pytest.mark.parametrize(
    "given",
    [
        {"position": -1.0},
        {"control": 0.1},
        {"control": ((-0.1, 1.0),)},
        {"disturbances": ((0.1, 1.0, 2.0),)},
        {"jitter": None},
        {"velocity": np.inf},
    ],
)
def test_noise_that_makes_no_sense_is_refused(given: dict[str, Any]) -> None:
    with refuses("noise"):
        Chain(**given)


TRUTH = np.array([100.2, 236.9, 24.8])
NOISE = Chain(position=4e-6, disturbances=((0.01, 0.03),))


@pytest.fixture(scope="module")
def problem(emps2015: GeneratedAxis, twin: Record) -> Problem:
    return identify(emps2015, twin, methods="idm-iv").problem


@pytest.fixture(scope="module")
def data(problem: Problem) -> FilteredRecord:
    return problem.data[0]


def test_a_twin_without_noise_is_the_loop(problem: Problem, data: FilteredRecord) -> None:
    silent = twin_of(data, TRUTH, Chain(), AntitheticDraws(np.random.default_rng(0)))
    loops = problem.loops(METHODS["idm-iv"].fit(problem).form, TRUTH)
    np.testing.assert_allclose(silent.record.position, loops[0].position, atol=1e-9)
    assert not [*twins_of(data, TRUTH, Chain(), 3)]


def test_what_disturbs_a_twin_is_not_in_its_log_but_in_its_motion(data: FilteredRecord) -> None:
    chain = Chain(disturbances=((0.1, 0.05),))
    rng = np.random.default_rng(5)
    rng.uniform()  # where the encoder stands, which has no steps
    rng.standard_normal(len(data))  # of the position, of no size
    noise = chain.drawn_disturbance(AntitheticDraws(rng), len(data), data.period)
    silent = twin_of(data, TRUTH, Chain(), AntitheticDraws(np.random.default_rng(5))).record
    record = twin_of(data, TRUTH, chain, AntitheticDraws(np.random.default_rng(5))).record
    # The law answers what it sees: the control opposes what acts beside it, where the axis is slow.
    answer = record.control - silent.control
    assert np.corrcoef(answer, noise)[0, 1] < -0.8
    assert np.abs(record.position - silent.position).max() > 1e-6


def test_steps_of_an_encoder_are_those_of_the_twin(data: FilteredRecord) -> None:
    record = twin_of(
        data, TRUTH, Chain(position_step=1e-5), AntitheticDraws(np.random.default_rng(2))
    ).record
    whole = record.position / 1e-5
    np.testing.assert_allclose(whole - np.round(whole - whole[0]) - whole[0], 0.0, atol=1e-6)


@pytest.mark.parametrize("count", [8, 16, 32])
@pytest.mark.parametrize("even", [0.0, 0.3])
def test_intervals_by_pairs_of_opposite_noise_hold_the_truth(count: int, even: float) -> None:
    """Whether the noise moves estimates in proportion alone, or by its square too."""
    rng = np.random.default_rng(count)
    noise = rng.normal(size=(4000, count // 2))
    drawn = np.stack([noise, -noise], axis=2).reshape(4000, count)
    estimates, new = (each + even * each**2 for each in (drawn, rng.normal(size=4000)))
    reach = stdtrit(pair_freedom(count), 0.975) * estimates.std(axis=1, ddof=1)
    held = np.mean(np.abs(new - estimates.mean(axis=1)) <= reach)
    assert held == pytest.approx(0.95, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 16])
def test_intervals_have_half_as_many_degrees_of_freedom_as_twins(
    emps2015: GeneratedAxis, twin: Record, count: int
) -> None:
    judged = identify(emps2015, twin, methods=["didim"], bootstrap=count).preferred
    fitted = fit(emps2015, twin, output=["position"], bootstrap=count)
    for values in (judged.parameters, fitted.parameters):
        assert [degrees_of_freedom_of(each) for each in values.values()] == pytest.approx(
            [count / 2] * len(values), rel=1e-6
        )


@pytest.mark.slow
def test_one_step_from_the_estimate_is_a_whole_estimate(
    emps2015: GeneratedAxis, problem: Problem, data: FilteredRecord
) -> None:
    for method in ("idm-iv", "didim"):
        fit = METHODS[method].fit(problem)
        twins = Twins(problem=problem, form=fit.form, at=TRUTH, chains=(NOISE,), count=6)
        steps = np.array([each.theta for each in twins.solutions(fit.form, fit.solver)])
        whole = [
            identify(emps2015, each.record, methods=method)[method].physical
            for each in twins_of(data, TRUTH, NOISE, 6, paired=True)
        ]
        np.testing.assert_allclose(
            steps.mean(axis=0), np.mean(whole, axis=0), atol=0.3 * steps.std(axis=0).max()
        )
        assert np.all(np.abs(steps - whole) < 0.6 * steps.std(axis=0))


@pytest.mark.slow
def test_twins_of_records_do_not_hang_on_their_order(emps2015: GeneratedAxis, twin: Record) -> None:
    other = replace(twin, position=twin.position + 1e-6)
    by_order = [
        identify(emps2015, records, methods="idm-iv", bootstrap=8)["idm-iv"]
        for records in ([twin, other], [other, twin])
    ]
    one, two = (each.parameters for each in by_order)
    for name in emps2015.names:
        assert one[name].interval == pytest.approx(two[name].interval, rel=1e-9)


field: Any = import_module("field")


def chain_of(axis: Any, record: Record) -> Chain:
    """As it is measured at the output error of the force."""
    problem = identify(axis, record, methods="didim").problem
    fit = METHODS["didim"].fit(problem)
    return measured_noise(problem.data[0], fit.form.physical(fit.solution.theta)[0], fit.loops)


def test_variances_are_those_that_the_powers_are_made_of() -> None:
    bands = np.linspace(0.1, 3.0, 20)
    units = np.array([np.ones(20), 1 / (1 + bands**2), bands**2])
    truth, known = np.array([2.0, 5.0, 0.0]), 0.3 / bands
    found = likeliest_variances(truth @ units + known, units, known, np.full(20, 30.0))
    np.testing.assert_allclose(found @ units, truth @ units, rtol=0.03)
    np.testing.assert_allclose(found[:2], truth[:2], rtol=0.1)
    assert found[2] < 0.05
    # Nothing is measured where nothing is.
    none = likeliest_variances(np.zeros(20), units, np.zeros(20), np.ones(20))
    np.testing.assert_array_equal(none, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("chain", "slack"),
    [
        (Chain(position=4e-6), 0.05),
        (Chain(position_step=5e-6), 0.05),
        (Chain(position=1.5e-6, position_step=5e-6), 0.05),
        (Chain(position=2e-6, jitter=6e-5), 0.1),
        (Chain(position_step=1e-6, disturbances=((0.0, 0.05),)), 0.15),
        (Chain(position_step=1e-6, disturbances=((0.03, 0.05),)), 0.3),
    ],
    ids=["noise", "steps", "dithered steps", "jitter", "white force", "coloured force"],
)
def test_the_chain_of_a_twin_is_its_chain(
    emps2015: GeneratedAxis, data: FilteredRecord, chain: Chain, slack: float
) -> None:
    truth = np.array([100.0, 237.0, 25.0])
    twin = twin_of(data, truth, chain, AntitheticDraws(np.random.default_rng(3)))
    found = chain_of(emps2015, twin.record)
    assert found.position_step == pytest.approx(chain.position_step, rel=1e-6)
    assert found.position == pytest.approx(chain.position, rel=slack, abs=3e-7)
    assert found.jitter == pytest.approx(chain.jitter, rel=slack, abs=3e-6)
    sizes = [np.sqrt(sum(sd**2 for _, sd in each.disturbances)) for each in (found, chain)]
    assert sizes[0] == pytest.approx(sizes[1], rel=slack, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("control", [(), ((0.0, 0.05),), ((0.03, 0.05),)])
@pytest.mark.parametrize(("law", "force"), [({}, 0.0), ({"kp": 1.03}, 0.05), ({"kv": 0.97}, 0.05)])
def test_noise_of_a_logged_control_is_told_from_forces_and_from_another_law(
    control: tuple[tuple[float, float], ...], law: dict[str, float], force: float
) -> None:
    axis = build(load_axis("servo_joint"))
    truth = np.array([*axis.declared.experiment.truth.values()])
    gains = axis.axis.control.gains
    other = axis.with_gains({name: times * float(gains[name]) for name, times in law.items()})
    (plain,) = identify(other, twin_record(other), methods="didim").problem.data
    chain = Chain(position=2e-6, control=control, disturbances=((0.03, force),))
    twin = twin_of(plain, truth, chain, AntitheticDraws(np.random.default_rng(3)))
    found = chain_of(axis, twin.record)
    for parts, others in ((found.control, control), (found.disturbances, chain.disturbances)):
        sizes = [float(np.sqrt(sum(sd**2 for _, sd in each))) for each in (parts, others)]
        assert sizes[0] == pytest.approx(sizes[1], rel=0.3, abs=0.01)


@pytest.mark.slow
def test_a_record_without_reference_has_no_noise_of_the_control() -> None:
    axis = build(load_axis("servo_joint"))
    result = identify(axis, replace(twin_record(axis), reference=None), methods="idm-ls")
    assert np.all(np.isfinite(result["idm-ls"].covariance))


@pytest.mark.slow
def test_the_chain_of_a_machine_that_is_simulated_apart_is_measured() -> None:
    machine = Machine(
        position_noise=white(4e-6), force_noise=autoregressive(1.5, 0.1, 1e-3), clock_jitter=0.04
    )
    case = field.Case(machine=machine, declared=machine)
    (record,) = case.records(1, 7)
    found = chain_of(case.axis, record)
    assert found.position_step == 0
    assert found.position == pytest.approx(4e-6, rel=0.05)
    assert found.jitter == pytest.approx(4e-5, rel=0.1)
    slow = [(time, sd) for time, sd in found.disturbances if time >= 0.03]
    assert np.sqrt(sum(sd**2 for _, sd in slow)) * 35.15 == pytest.approx(1.5, rel=0.35)


@pytest.mark.slow
@pytest.mark.parametrize("number", [7, 8])
def test_a_force_beside_louder_encoder_steps_is_in_the_chain_by_how_it_changes_the_hunting(
    number: int,
) -> None:
    """The steps make many times the power that the force makes in the rows."""
    (case,) = (case for name, case in field.drawn(53, 14).items() if f"drawn {number}:" in name)
    disturbing = case.machine.force_noise
    assert disturbing is not None
    truth = np.std(disturbing(np.random.default_rng(1), 1, 100_000))
    chains = [chain_of(case.axis, record) for record in case.records(6, 1054)]
    forces = [np.sqrt(sum(sd**2 for _, sd in each.disturbances)) for each in chains]
    shares = case.machine.gain * np.array(forces) / truth
    assert np.all((shares > 0.25) & (shares < 3.0))
    assert 0.6 < np.median(shares) < 1.6


def test_a_short_record_has_a_chain_too(emps2015: GeneratedAxis, twin: Record) -> None:
    filtering = Prefilter(cutoff=60.0, decimate=4)
    short = twin.windowed((0.3, 0.9))
    result = identify(emps2015, short, filtering, "idm-ls", bootstrap=8)["idm-ls"]
    assert np.all(np.isfinite(np.sqrt(np.diag(result.covariance))))


def test_noise_of_the_position_that_is_not_white_has_no_chain(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """All of it at half the sampling rate: rows behind a filter have nothing of it."""
    shaken = replace(twin, position=twin.position + 1e-4 * (-1.0) ** np.arange(len(twin)))
    result = identify(emps2015, shaken, methods="didim")
    assert result["didim"].inference.chains == ()
    assert "not white" in result["didim"].covariance_notes["hac"].no_replicas
    for name, value in result["didim"].parameters.items():
        assert abs(value.corrected - twin.provenance.truth[name]) < 3 * value.deviation


@pytest.fixture(scope="module")
def quiet(emps2015: GeneratedAxis) -> Record:
    """A sensor whose noise does not carry the control from one step to the next."""
    return twin_record(emps2015, position_noise=1e-8)


def _rounded(record: Record, bits: int) -> Record:
    control = np.asarray(record.control)
    step = float(np.ptp(control)) / 2**bits
    return replace(record, control=step * np.round(control / step))


@pytest.mark.slow
@pytest.mark.parametrize("bits", [6, 7, 14])
def test_deviations_hold_what_a_control_of_few_steps_moves(
    emps2015: GeneratedAxis, quiet: Record, bits: int
) -> None:
    found = identify(emps2015, _rounded(quiet, bits)).preferred
    for name, value in found.parameters.items():  # 3.3 and more by neighbouring rows alone
        assert abs(value.corrected - quiet.provenance.truth[name]) < 2.5 * value.deviation
    (chain,) = found.inference.chains
    assert chain.control_step > 0


@pytest.mark.slow
def test_noise_that_averages_the_steps_adds_nothing(emps2015: GeneratedAxis, twin: Record) -> None:
    fine, coarse = (
        [
            v.deviation
            for v in identify(emps2015, each, methods="idm-iv").preferred.parameters.values()
        ]
        for each in (twin, _rounded(twin, 8))
    )
    assert coarse == pytest.approx(fine, rel=0.3)


def test_a_relay_has_no_steps_that_round_anything(quiet: Record) -> None:
    control = np.asarray(quiet.control)
    assert not control_step(replace(quiet, control=np.sign(control)))
    assert control_step(_rounded(quiet, 6)) == pytest.approx(np.ptp(control) / 64)


STEP = 5e-6


def stepped(axis: GeneratedAxis, twin: Record, place: float, step: float = STEP) -> Record:
    """A record with an encoder of a step, whose steps begin elsewhere each time."""
    away = place * step
    noise = np.full(len(twin), away)
    loop = simulate(
        axis, TRUTH, twin.reference + away, twin.period, position_noise=noise, resolution=step
    )
    return replace(twin, position=loop.measured_position - away, control=loop.control)


def test_steps_are_found_in_the_record(emps2015: GeneratedAxis, twin: Record) -> None:
    coarse = stepped(emps2015, twin, 0.3)
    assert sensor_steps(emps2015, coarse)[0] == pytest.approx(STEP, rel=1e-6)
    lawless = build(replace(emps2015.declared, control=None, experiment=None), native=False)
    assert sensor_steps(lawless, coarse)[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(("method", "step"), [("idm-iv", STEP), ("didim", 10 * STEP)])
def test_intervals_hold_the_mass_that_steps_bias(
    emps2015: GeneratedAxis, twin: Record, method: str, step: float
) -> None:
    places, held = (0.04, 0.18, 0.31, 0.47, 0.62, 0.73, 0.86, 0.95), 0
    for place in places:
        record = stepped(emps2015, twin, place, step)
        estimate = identify(emps2015, record, methods=method)[method]
        assert estimate.inference.chains[0].position_step == pytest.approx(step, rel=1e-6)
        mass = estimate.parameters["M"]
        held += mass.interval[0] < TRUTH[0] < mass.interval[1]
    assert held >= len(places) - 1


def test_a_velocity_in_coarse_steps_is_reckoned_with_unless_its_noise_averages_them(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    velocity = np.asarray(twin_record(emps2015, velocity_noise=0.0).velocity)
    step = 0.02 * float(np.sqrt(np.mean(velocity**2)))
    noise = np.random.default_rng(1).normal(0, 1.5 * step, len(velocity))
    coarse = replace(twin, velocity=step * np.round(velocity / step))
    assert sensor_steps(emps2015, coarse)[1] == pytest.approx(step, rel=1e-6)
    noisy = replace(twin, velocity=step * np.round((velocity + noise) / step))
    assert sensor_steps(emps2015, noisy)[1] == 0
    estimate = identify(emps2015, coarse, methods="idm-iv")["idm-iv"]
    (chain,) = estimate.inference.chains
    assert chain.velocity_step == pytest.approx(step, rel=1e-6)
    for value, true in zip(estimate.parameters.values(), TRUTH, strict=True):
        assert value.interval[0] < true < value.interval[1]


def test_a_held_force_moves_a_free_mass_by_the_mean_of_both_its_sides(
    rng: np.random.Generator,
) -> None:
    axis = build(body(control=force_law(PERIOD)), native=False)
    force = rng.normal(size=30)
    loop = simulate(axis, [2.0], force, PERIOD, start=0.0)
    rows = loop_equations(InverseForm(axis), loop, np.array([2.0]), "zoh")
    central = (loop.velocity[2:] - loop.velocity[:-2]) / (2 * PERIOD)
    np.testing.assert_allclose(rows.regressor[1:-1, 0], central, rtol=0, atol=1e-11)
    np.testing.assert_allclose(rows.left[1:], (force[1:] + force[:-1]) / 2, rtol=1e-12)
