"""Gains that give a recorded control are found from far away."""

from dataclasses import replace

import pytest

from axisid import twin_record
from axisid.estimation.law_replay import LawReplay, law_ticks
from tests.axes.ready_laws import with_law


@pytest.mark.parametrize("times", [1 / 300, 300.0])
def test_an_integral_time_is_found_from_far_away_with_what_the_integral_is(times: float) -> None:
    axis = with_law("cascade_p_pi", 10.0)
    record = twin_record(axis).windowed((0.1, 0.6))  # the integral is under way
    ticks = law_ticks(axis, record, (0, len(record)))
    right = LawReplay.of(axis, axis.axis.control, ticks, record)
    far = replace(right, gains=right.gains * [1.0, 1.0, times])
    found = far.fitted(lambda control: control, [2])
    assert found.gains == pytest.approx(right.gains, rel=1e-6)
