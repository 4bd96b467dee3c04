"""Deviations of estimates whose errors follow one another."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from scipy.stats import binom

from axisid import build, fit, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import student_interval
from axisid.estimation.noise_models import Chain
from axisid.estimation.noise_models.noise_model import AntitheticDraws
from axisid.estimation.output_error.covariance import (
    Sandwich,
    named_directions,
    unseen_directions,
)
from axisid.estimation.output_error.inference import reach_of_cut_normal
from axisid.support.arrays import Array

SLOW_SCREW = Path(__file__).parents[3] / "benchmarks" / "slow_screw.toml"


def _sandwich(J: Array, e: Array) -> Sandwich:
    return Sandwich(
        jacobian=J,
        errors=e,
        curvature=np.ones(len(e)),
        known=np.zeros((0, J.shape[1])),
        counts=np.ones(len(e)),
        spans=((slice(0, len(e)),),),
        periods=(1e-3,),
    )


@pytest.mark.parametrize(("a", "masked"), [(-0.6, False), (0.8, False), (0.9, True)])
def test_the_sandwich_is_the_scatter_of_estimates_with_coloured_errors(
    a: float, masked: bool, rng: np.random.Generator
) -> None:
    """By the covariance of all errors; half of the samples may be masked, in blocks."""
    n = 2000
    time, counted = np.arange(n) / 50, np.arange(n) // 50 % 2 >= masked
    J = np.column_stack([np.sin(time), np.sign(np.sin(0.3 * time))]) * counted[:, None]
    influence = np.linalg.pinv(J)
    whole = toeplitz(a ** np.arange(n) / (1 - a**2))
    expected = np.sqrt(np.diag(influence @ whole @ influence.T))
    errors = lfilter([1.0], [1.0, -a], rng.standard_normal((20, n)), axis=1) * counted
    every = [replace(_sandwich(J, e), counts=counted.astype(float)) for e in errors]
    claimed = np.mean([np.sqrt(np.diag(each.coloured().matrix)) for each in every], axis=0)
    np.testing.assert_allclose(claimed, expected, rtol=0.2 if masked else 0.1)
    independent = np.sqrt(np.diag(every[0].independent()))
    assert np.all((independent > 1.5 * expected) if a < 0 else (independent < 0.7 * expected))


@pytest.mark.parametrize("a", [-0.6, 0.9])
def test_coloured_errors_count_beside_what_was_known_as_they_tell_of_it(
    a: float, rng: np.random.Generator
) -> None:
    """Of a mean, its variance is (1 + a) / (1 - a) times that of independent errors."""
    e = lfilter([1.0], [1.0, -a], rng.standard_normal(20_000))
    sandwich = replace(_sandwich(np.ones((len(e), 1)), e), known=np.array([[3.0]]))
    assert sandwich.effects() == pytest.approx((1 + a) / (1 - a), rel=0.2)


def test_an_interval_at_a_bound_is_on_the_side_that_is_allowed(rng: np.random.Generator) -> None:
    """95 % of a normal distribution, of which nothing is below the bound."""
    for centre in (0.5, 0.0, -3.0):
        high = reach_of_cut_normal(0.0, centre, 1.0, -1)
        draws = rng.normal(centre, 1.0, 2_000_000)
        beyond = draws[draws > 0]
        assert np.mean(beyond <= high) == pytest.approx(0.95, abs=0.01)
        assert reach_of_cut_normal(0.0, -centre, 1.0, 1) == pytest.approx(-high)
    for beyond in (50.0, 9e3, 1.1e4, 1e9):  # the tail is an exponential there
        found = reach_of_cut_normal(0.0, -beyond, 1.0, -1)
        assert found == pytest.approx(np.log(20) / beyond, rel=2e-3)


@pytest.mark.slow
def test_what_noise_in_the_loop_moves_falling_friction_by_is_taken_off() -> None:
    axis = build(load_axis(SLOW_SCREW))
    given = axis.declared.experiment
    truth = np.array([*given.truth.values()])
    records = [twin_record(axis, seed=seed) for seed in range(100, 105)]
    found = [fit(axis, record, start=given.truth) for record in records]
    assert found[-1].believed
    before = np.array([(each.best.physical - truth) / each.deviations for each in found])
    after = np.array([(each.physical - truth) / each.deviations for each in found])
    sizes = [np.sqrt(np.mean(each**2)) for each in (before, after)]
    assert sizes[1] < min(sizes[0], 1.2)
    assert np.abs(np.mean(after, axis=0)).max() < np.abs(np.mean(before, axis=0)).max()


@pytest.mark.slow
@pytest.mark.parametrize("time", [0.0, 0.03])
def test_intervals_hold_where_the_control_that_shows_an_integral_is_noisy(time: float) -> None:
    """The position shows no constant force beside it; nor is noise of the log in the loop."""
    axis = build(load_axis("servo_joint"))
    noise, record = Chain(control=((time, 0.05),)), twin_record(axis, seed=5)
    rng = AntitheticDraws(np.random.default_rng(1))
    control = noise.logged_control(rng, np.asarray(record.control), record.period)
    found = fit(axis, replace(record, control=control), output="position")
    for name, true in axis.declared.experiment.truth.items():
        assert abs(found[name].value - true) < 2.6 * found[name].deviation, name
    assert 0.005 < found["fcp"].deviation / found["fcp"].value < 0.1


@pytest.mark.slow
def test_a_drive_that_remembers_under_a_law_that_does_not_is_fitted(
    emps2015: GeneratedAxis,
) -> None:
    declared = emps2015.declared
    axis = build(replace(declared, drive=replace(declared.drive, lag=0.8e-3)))
    found = fit(axis, twin_record(axis, seed=1), output="position")
    assert abs(found["M"].value - declared.experiment.truth["M"]) < 4 * found["M"].deviation


@pytest.mark.slow
def test_what_noise_moves_across_a_bound_is_at_it_and_from_it_is_free() -> None:
    """The others are what they are with it, as if it were held, or without it."""
    declared = load_axis(SLOW_SCREW)
    noisy = replace(declared, experiment=replace(declared.experiment, position_noise=3e-6))
    axis, record = build(declared), twin_record(build(noisy), seed=1)
    found = fit(axis, record)
    between = (found.best.physical[3] + found.physical[3]) / 2
    across = fit(axis, record, bounds={"fs": (None, between)})
    assert (across.best.at_bound.any(), across.at_bound) == (False, {"fs": "upper"})
    low, high = across["fs"].interval
    assert low < high == across["fs"].value == between
    assert across["fs"].deviation == 0.0
    held = fit(axis, record, fixed={"fs": between})
    assert np.all(np.abs(across.physical - held.physical) < 0.1 * found.deviations)
    freed = fit(axis, record, bounds={"fs": (between, None)})
    assert (np.count_nonzero(freed.best.at_bound), freed.at_bound) == (1, {})
    assert np.all(np.abs(freed.physical - found.physical) < 0.1 * found.deviations)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "pole"), [(200, 0.9), (1000, 0.98)])
def test_intervals_hold_the_truth_in_short_records_of_slow_errors(count: int, pole: float) -> None:
    """With as many degrees of freedom as there are samples a constant's hold in 83 to 86 %."""
    rng, time = np.random.default_rng(0), np.linspace(0.0, 1.0, count)
    J = np.column_stack([np.sin(10 * np.pi * time), np.ones(count)])
    found = np.linalg.pinv(J)
    draws, held = 200, np.zeros(2)
    for _ in range(draws):
        errors = lfilter([1.0], [1.0, -pole], rng.standard_normal(count + 500))[500:]
        theta = found @ errors
        sandwich = _sandwich(J, errors - J @ theta)
        told = sandwich.coloured()
        for i, variance in enumerate(np.diag(told.matrix)):
            low, high = student_interval(theta[i], np.sqrt(variance), told.freedom[i])
            held[i] += low <= 0 <= high
    assert np.all(binom.ppf(1e-3, draws, 0.95) <= held)


def test_parameters_that_only_a_sum_of_is_shown_are_named_with_it(
    rng: np.random.Generator,
) -> None:
    J = rng.standard_normal((50, 3))
    J[:, 2] = 2 * J[:, 0]
    for scale in (np.ones(3), np.array([100.0, 1.0, 0.1])):
        unseen = unseen_directions(J, scale, np.ones(3, dtype=bool))
        (direction,) = named_directions(*unseen, ("M", "Fv", "m"))
        assert direction.parameters == ("M", "m")
        assert direction.changes == pytest.approx((1.0, -0.5))
