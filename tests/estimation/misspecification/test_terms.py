"""Forces along a motion have the shapes that they are named for."""

from dataclasses import replace

import numpy as np
import pytest

from axisid.estimation.misspecification.terms import (
    TERMS,
    Along,
    behind_spring,
)

_PERIOD = 1e-3


def _along(frequency: float = 2.0) -> Along:
    time = _PERIOD * np.arange(3000)
    rate = 2 * np.pi * frequency
    position = 0.1 * np.sin(rate * time)
    velocity = 0.1 * rate * np.cos(rate * time)
    return Along(
        time=time,
        position=position,
        velocity=velocity,
        acceleration=-(rate**2) * position,
        direction=np.sign(velocity),
        force=5 * velocity,
        spans=[(0, 3000)],
        row_period=_PERIOD,
    )


@pytest.mark.parametrize("frequency", [6.0, 20.0])
def test_a_load_behind_a_spring_follows_a_slow_swing_a_little_too_far(frequency: float) -> None:
    """As an undamped oscillator below its resonance does: by ``1 / (1 - r^2)``, nearly."""
    s = _along(2.0)
    ratio = 2.0 / frequency
    (column,) = behind_spring(s, np.array([frequency])).T
    settled = slice(2000, None)
    expected = ratio**2 / (1 - ratio**2) * s.acceleration[settled]
    error = np.linalg.norm(column[settled] - expected) / np.linalg.norm(expected)
    assert error < 0.1 + ratio  # the rest is its damping


def test_a_load_much_faster_than_a_motion_takes_its_fourth_derivative_away() -> None:
    s = _along(2.0)
    (column,) = behind_spring(s, np.array([80.0])).T
    fourth = (2 * np.pi * 2.0) ** 4 * s.position
    held = column[2000:] @ fourth[2000:] / (fourth[2000:] @ fourth[2000:])
    assert held == pytest.approx(-1 / (2 * np.pi * 80.0) ** 2, rel=0.05)


def test_each_stretch_is_by_itself() -> None:
    s, delay = replace(_along(), spans=[(0, 1000), (1000, 2500)]), TERMS["delay"]
    jumps = replace(s, force=s.force + np.where(s.time < 1.0, 100.0, 0.0))
    found, other = (delay.columns(each, np.zeros(1))[:, 0, 0] for each in (s, jumps))
    np.testing.assert_allclose(found, other, atol=1e-8)
    assert not found[2500:].any()
    apart = replace(s, acceleration=np.where(s.time < 1.0, 1e3, s.acceleration))
    late = behind_spring(apart, np.array([20.0]))[1000:2500]
    np.testing.assert_allclose(late, behind_spring(s, np.array([20.0]))[1000:2500])


def test_waves_are_of_every_period_that_rows_can_tell() -> None:
    s = _along(0.4)
    periods = TERMS["place"].places(s)
    assert periods[0] == pytest.approx(s.travel)
    assert np.all(periods > np.median(np.abs(s.velocity)) * 4 * s.row_period)
    assert len(TERMS["place"].places(replace(s, row_period=0.1))) < len(periods)
    for true in (0.03, 0.0131, 0.051):
        at = float(periods[np.argmin(np.abs(1 / periods - 1 / true))])
        between = TERMS["place"].between
        assert np.abs(between(periods, at) / true - 1).min() < 0.02
