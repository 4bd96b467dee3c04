"""Steps of an iteration: halved where they swing, whole elsewhere, never of no size."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid.estimation.methods.instrumental import StepControl
from axisid.estimation.thresholds import CONVERGED


@pytest.mark.parametrize("slope", [-0.9, -1.0, -1.5, -2.5])
def test_pace_comes_to_rest_where_whole_steps_swing(slope: float) -> None:
    """The next estimate is a line through the fixed point at 1."""
    pace, at, one = StepControl(), np.array([5.0]), np.ones(1)
    for _ in range(20):
        goal = 1.0 + slope * (at - 1.0)
        if pace.step(at, goal, one)[0] <= CONVERGED.value:
            break
        at = at + pace.share * (goal - at)
    assert at == pytest.approx(1.0, abs=2 * CONVERGED.value)


@given(scale=st.floats(1e-6, 1e6), slopes=st.lists(st.floats(-3.0, 1.0), min_size=1, max_size=3))
def test_pace_is_the_same_in_any_unit(scale: float, slopes: list[float]) -> None:
    """The pace of parameters in millimetres is that of the same in metres."""

    def shares(unit: float) -> list[float]:
        pace, slope, at = StepControl(), np.array(slopes), 5.0 * unit * np.ones(len(slopes))
        found = []
        for _ in range(8):
            goal = unit + slope * (at - unit)
            pace.step(at, goal, unit * np.ones(len(slopes)))
            at = at + pace.share * (goal - at)
            found.append(pace.share)
        return found

    assert shares(scale) == shares(1.0)
    assert all(0.125 <= share <= 1.0 for share in shares(1.0))


def test_steps_that_fall_steadily_are_known_where_they_lead_to() -> None:
    pace, at, unit = StepControl(), np.array([1.0 + 4.0, 2.0 - 0.4]), np.array([1.0, 0.1])
    for _ in range(2):
        goal = np.array([1.0, 2.0]) + 0.1 * (at - [1.0, 2.0])
        size, further = pace.step(at, goal, unit)
        at = goal
    assert size == pytest.approx(0.36)
    assert further == pytest.approx([1.0, 2.0], abs=1e-12)
