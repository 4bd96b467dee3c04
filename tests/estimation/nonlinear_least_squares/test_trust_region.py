"""The search: to the least, at bounds, from bounds, past what cannot be simulated."""

from typing import Any

import numpy as np
import pytest

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.choices import HUBER, SOFT_L1, SQUARES
from axisid.estimation.nonlinear_least_squares import (
    LOSSES,
    RESOLUTION,
    Search,
    SearchResult,
    WeightedLoss,
)
from axisid.estimation.thresholds import HUBER_TUNING
from axisid.estimation.unknowns import Unknowns
from axisid.support.arrays import Array
from tests.estimation.output_residuals.formula import Formula
from tests.refusals import refuses

TIME = np.linspace(0.0, 4.0, 400)


def _decay(a: float, b: float) -> Array:
    return np.asarray(a * np.exp(-b * TIME))


def _less(measured: Array, most: float = np.inf) -> Formula:
    """``a exp(-b t)`` less what was measured; no lane has a rate of more than it can."""
    return Formula(
        lambda p: p[:, 0] * np.exp(-np.outer(TIME, p[:, 1])) - measured[:, None], len(TIME), most
    )


def _unknowns(**changed: Any) -> Unknowns:
    whole = {
        "lower": np.zeros(2),
        "upper": np.full(2, np.inf),
        "prior": np.zeros(2),
        "prior_sd": np.full(2, np.inf),
        "fixed": np.full(2, np.nan),
        **changed,
    }
    return Unknowns(
        quantities=(Quantity(name="a", unit="m"), Quantity(name="b", unit="1/s")), **whole
    )


def _found(
    predictions: Formula,
    unknowns: Unknowns,
    start: list[float],
    loss: str = SQUARES,
    weight: float = 100.0,
    resolution: float = RESOLUTION,
) -> SearchResult:
    weighing = WeightedLoss(
        weights=np.full(len(TIME), weight),
        shares=np.ones(len(TIME)),
        loss=LOSSES[loss],
        tuning=1.0 if loss == SQUARES else HUBER_TUNING.value,
    )
    scale = np.ones(2)
    search = Search(predictions, unknowns, scale, weighing, resolution=resolution)
    return search.run(unknowns.inside(np.array(start), scale))


@pytest.mark.parametrize("start", [[1.0, 1.0], [0.0, 0.0], [5.0, 3.0]])
def test_it_ends_at_the_truth_also_from_a_bound(start: list[float]) -> None:
    found = _found(_less(_decay(2.0, 0.7)), _unknowns(), start)
    assert found.converged
    np.testing.assert_allclose(found.physical, [2.0, 0.7], rtol=1e-6)
    assert not np.any(found.at_bound)


def test_a_parameter_that_is_driven_to_a_bound_is_there_and_the_others_are_least_with_it() -> None:
    found = _found(_less(_decay(2.0, 0.7)), _unknowns(upper=np.array([np.inf, 0.5])), [1.0, 0.1])
    held = _found(_less(_decay(2.0, 0.7)), _unknowns(fixed=np.array([np.nan, 0.5])), [1.0, 0.1])
    assert [*found.at_bound] == [0, 1]
    assert found.physical[1] == 0.5
    assert found.physical[0] == pytest.approx(held.physical[0], rel=1e-7)
    assert not np.any(held.at_bound)


@pytest.mark.parametrize("weight", [1.0, 100.0])
@pytest.mark.parametrize("gap", [0.3, 1.0, 3.0])
def test_a_bound_near_the_least_is_told_apart_from_it_whatever_the_start_weighed(
    gap: float, weight: float, rng: np.random.Generator
) -> None:
    """``gap`` in deviations of the rate; weights are of the errors at the start."""
    noise = 1e-3
    measured = _decay(2.0, 0.7) + noise * rng.standard_normal(len(TIME))
    free = _found(_less(measured), _unknowns(), [1.0, 1.0], weight=weight)
    scatter = np.linalg.inv(free.jacobian.T @ free.jacobian)
    deviation = noise * np.sqrt(scatter[1, 1])
    upper = np.array([np.inf, free.physical[1] + gap * deviation])
    found = _found(_less(measured), _unknowns(upper=upper), [1.0, 0.1], weight=weight)
    assert found.converged
    assert not np.any(found.at_bound)
    assert abs(found.physical[1] - free.physical[1]) < 0.05 * deviation


@pytest.mark.parametrize("loss", [*LOSSES])
def test_a_search_ends_where_its_steps_are_below_the_resolution(
    loss: str, rng: np.random.Generator
) -> None:
    measured = _decay(2.0, 0.7) + 1e-3 * rng.standard_normal(len(TIME))
    exact, found, coarse = (
        _found(_less(measured), _unknowns(), [2.1, 0.8], loss, weight=1e3, resolution=each)
        for each in (1e-6, RESOLUTION, 10 * RESOLUTION)
    )
    deviations = 1e-3 * np.sqrt(np.diag(np.linalg.inv(exact.jacobian.T @ exact.jacobian)))
    off, coarse_off = (abs(each.physical - exact.physical) / deviations for each in (found, coarse))
    assert np.all(off < RESOLUTION)
    assert found.step_left < RESOLUTION
    assert np.all(coarse_off < 0.1)
    assert len(coarse.steps) <= len(found.steps) <= len(exact.steps)


def test_a_truth_on_a_bound_is_found_exactly() -> None:
    found = _found(_less(_decay(2.0, 0.0) + 0.01 * TIME), _unknowns(), [1.0, 1.0])
    assert found.physical[1] == 0.0
    assert [*found.at_bound] == [0, -1]


def test_loops_that_cannot_be_simulated_shorten_the_step_and_begin_no_search() -> None:
    found = _found(_less(_decay(2.0, 1.2), most=1.25), _unknowns(), [50.0, 0.5])
    np.testing.assert_allclose(found.physical, [2.0, 1.2], rtol=1e-5)
    with refuses("simulation", says="runs away"):
        _found(_less(_decay(2.0, 0.7), most=3.0), _unknowns(), [1.0, 4.0])


@pytest.mark.parametrize(("sd", "expected", "near"), [(1e-4, 3.0, 0.01), (10.0, 2.0, 1e-4)])
def test_what_was_known_before_pulls_by_its_deviation(
    sd: float, expected: float, near: float
) -> None:
    known = _unknowns(prior=np.array([3.0, 0.0]), prior_sd=np.array([sd, np.inf]))
    found = _found(_less(_decay(2.0, 0.7)), known, [1.0, 1.0])
    assert found.physical[0] == pytest.approx(expected, abs=near)


@pytest.mark.parametrize("loss", [SOFT_L1, HUBER])
def test_robust_losses_withstand_outliers(loss: str, rng: np.random.Generator) -> None:
    measured = _decay(2.0, 0.7) + 0.01 * rng.standard_normal(len(TIME))
    measured[rng.integers(0, len(TIME), 40)] += 3.0
    off, plain_off = (
        np.abs(_found(_less(measured), _unknowns(), [1.0, 1.0], each).physical - [2.0, 0.7])
        for each in (loss, SQUARES)
    )
    assert np.all(off < 0.02)
    assert np.all(off < 0.1 * plain_off)


@pytest.mark.parametrize("loss", [*LOSSES])
def test_losses_have_the_derivatives_that_they_say(loss: str) -> None:
    z, h = np.array([0.0, 0.3, 0.9, 1.1, 4.0, 50.0]) + 1e-3, 1e-6
    value, first, second = LOSSES[loss](z)
    more, less = LOSSES[loss](z + h), LOSSES[loss](z - h)
    np.testing.assert_allclose((more[0] - less[0]) / (2 * h), first, rtol=1e-6)
    np.testing.assert_allclose((more[1] - less[1]) / (2 * h), second, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(value[0], z[0], rtol=1e-3)


@pytest.mark.parametrize("calls", [3, 5])
def test_an_interrupt_ends_a_search_with_its_best_point(calls: int) -> None:
    truth = _decay(2.0, 0.7)
    left = [calls]

    def interrupted(p: Array) -> Array:
        left[0] -= 1
        if not left[0]:
            raise KeyboardInterrupt
        return np.asarray(p[:, 0] * np.exp(-np.outer(TIME, p[:, 1])) - truth[:, None])

    found = _found(Formula(interrupted, len(TIME)), _unknowns(), [1.0, 1.0])
    whole = _found(_less(truth), _unknowns(), [1.0, 1.0])
    assert found.interrupted
    assert not found.converged
    assert 0 < len(found.steps) < len(whole.steps)
    assert whole.cost < found.cost < np.inf


def test_an_interrupt_before_the_first_step_goes_through() -> None:
    def interrupted(_: Array) -> Array:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        _found(Formula(interrupted, len(TIME)), _unknowns(), [1.0, 1.0])
