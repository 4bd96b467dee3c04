"""Missing excitation and standstill of a motion are found."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid.estimation.signals.motion import motion_lacks, one_direction, resting
from axisid.estimation.signals.signals import Signals

PERIOD = 1e-3


def signals(velocity: np.ndarray) -> Signals:
    zero = np.zeros_like(velocity)
    return Signals(
        position=PERIOD * np.cumsum(velocity),
        velocity=velocity,
        acceleration=np.gradient(velocity, PERIOD),
        force=zero,
        direction=np.sign(velocity),
    )


def strokes(*speeds: float, rest: int = 0) -> np.ndarray:
    """Each speed held for 200 samples after a ramp of 20, and then a rest."""
    ramp, pieces = np.linspace(0, 1, 20), []
    for speed in speeds:
        pieces += [speed * ramp, np.full(200, speed), speed * ramp[::-1], np.zeros(rest)]
    return np.concatenate(pieces)


@given(size=st.floats(1e-6, 1e6), sign=st.sampled_from([-1, 1]))
@pytest.mark.parametrize(
    ("speeds", "lacks"),
    [
        ((0.1, -0.1, 0.4, -0.4), ()),
        ((0.1, 0.4), ("sign",)),
        ((0.3, -0.3), ("one cruising speed",)),
        ((0.3, 0.3), ("sign", "one cruising speed")),
        ((0.3, -0.31), ("one cruising speed",)),
        ((0.3, -0.36), ()),
    ],
)
def test_what_is_lacking_is_the_same_for_any_size_and_either_sign(
    speeds: tuple[float, ...], lacks: tuple[str, ...], size: float, sign: int
) -> None:
    told = motion_lacks(signals(sign * size * strokes(*speeds)))
    assert len(told) == len(lacks)
    assert all(lack in words for lack, words in zip(lacks, told, strict=True))


def test_a_velocity_that_changes_its_sign_in_few_samples_hardly_ever_does() -> None:
    velocity = strokes(0.1, 0.4, 0.1)
    velocity[300:303] = -0.4
    assert "hardly ever" in one_direction(signals(velocity))
    assert "never" in one_direction(signals(strokes(0.1, 0.4)))
    velocity[300:320] = -0.4
    assert one_direction(signals(velocity)) == ""


@pytest.mark.parametrize("rest", [0, 100, 300])
def test_rest_is_the_part_of_the_fits_samples_without_motion(rest: int) -> None:
    velocity = strokes(0.3, -0.3, rest=rest)
    all_, n = np.ones(len(velocity), dtype=bool), len(velocity)
    found = resting(signals(velocity), all_)
    assert found == pytest.approx(2 * rest / n, abs=0.02)
    moving = np.abs(velocity) > 0
    assert resting(signals(velocity), moving) < 0.03
    assert resting(signals(velocity), ~all_) == 0.0


def test_creeping_and_reversing_are_no_rests() -> None:
    fast = strokes(0.3)
    creeping = np.concatenate([fast, np.full(400, 0.002), fast])
    reversing = np.concatenate([fast, 0.01 * np.sin(np.linspace(0, 40, 400)), fast])
    for velocity in (creeping, reversing):
        n = len(velocity)
        assert resting(signals(velocity), np.ones(n, dtype=bool)) < 0.1
