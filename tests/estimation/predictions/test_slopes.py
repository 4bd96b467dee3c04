"""Slopes by differences: right, within the bounds, and past lanes that fail."""

import numpy as np
import pytest

from axisid import Record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.predictions import LoopPredictions, slopes_of
from axisid.estimation.predictions.lanes import Lanes
from axisid.estimation.regression import InverseForm
from axisid.support.arrays import Array
from tests.axes.complex_loop import control_of, derivative_of

THETA = np.array([100.2, 236.9, 24.8])
INFINITE = np.full(3, np.inf)


def test_slopes_are_those_of_an_independent_derivative_through_reversals_and_rests(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    predictions = LoopPredictions(InverseForm(emps2015), [emps2015], [twin], "control")
    start = predictions.stretches[0].inputs.start
    assert start.velocity == 0.0
    reference = np.asarray(twin.reference)
    exact = control_of(THETA, reference, start.position).real
    predictions.settle(THETA)
    found = slopes_of(predictions, THETA, THETA, np.zeros(3), INFINITE)
    np.testing.assert_allclose(found.errors + twin.control, exact, atol=1e-6)
    slopes = derivative_of(THETA, reference, start.position)
    off = np.linalg.norm(found.jacobian - slopes, axis=0) / np.linalg.norm(slopes, axis=0)
    assert off.max() < 1e-5, off


class _Parabola:
    """Errors that are squares of the parameters, where these are allowed; for lanes that fail."""

    def __init__(self, fails_beyond: float = np.inf) -> None:
        self.seen: list[Array] = []
        self._limit = fails_beyond

    @property
    def spans(self) -> tuple[tuple[slice, ...], ...]:
        return ((slice(0, 2),),)

    measured = counted = np.ones(2)

    def settle(self, physical: Array) -> None:
        pass

    def __call__(self, physical: Array) -> Lanes:
        self.seen.append(physical)
        failed = {i: "it fails" for i, p in enumerate(physical) if np.any(p > self._limit)}
        errors = (physical**2 + physical).T.copy()
        errors[:, [*failed]] = np.nan
        return Lanes(errors=errors, failures=failed)


@pytest.mark.parametrize("at", [0.0, 1e-5, 0.5, 1.0])
def test_at_a_bound_the_differences_stay_inside_and_are_of_second_order(at: float) -> None:
    parabola, here = _Parabola(), np.array([at, 0.5])
    lower, upper = np.zeros(2), np.ones(2)
    found = slopes_of(parabola, here, np.ones(2), lower, upper)
    np.testing.assert_allclose(found.jacobian, np.diag(2 * here + 1), atol=1e-9)
    assert np.all((parabola.seen[0] >= lower) & (parabola.seen[0] <= upper))


def test_a_parameter_whose_lane_fails_is_stepped_less() -> None:
    parabola, here = _Parabola(fails_beyond=1.0 + 2e-5), np.array([1.0, 0.2])
    found = slopes_of(parabola, here, np.ones(2), np.zeros(2), INFINITE[:2])
    np.testing.assert_allclose(found.jacobian, np.diag(2 * here + 1), atol=1e-8)
    assert len(parabola.seen) == 2
    assert len(parabola.seen[1]) == 3  # that of the parameter alone
