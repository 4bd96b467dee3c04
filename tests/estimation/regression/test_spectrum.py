"""Welch's power density over rows of which some are missing."""

import numpy as np
import pytest
from scipy.signal import welch

from axisid.estimation.regression import power_density
from axisid.estimation.signals import Neighbours
from axisid.support.missing import Missing

RATE = 100.0


def test_rows_that_all_follow_each_other_are_welch_s_own(rng: np.random.Generator) -> None:
    both = rng.normal(size=(1000, 2))
    found = power_density(both, RATE, Neighbours.consecutive(1000))
    frequencies, power = welch(both, RATE, nperseg=256, axis=0)
    np.testing.assert_array_equal(found[0], frequencies[1:])
    np.testing.assert_allclose(found[1], power[1:], rtol=1e-12)


def test_missing_rows_leave_the_density_as_it_is(rng: np.random.Generator) -> None:
    """A tone of power 1/2 in noise of power 1 keeps both, though its phase is lost at each gap."""
    pieces = [Neighbours.consecutive(300) for _ in range(20)]
    time = np.arange(6000) / RATE
    values = np.sin(2 * np.pi * 20 * time) + rng.normal(size=6000)
    found = power_density(values, RATE, Neighbours.joined(pieces))
    assert not isinstance(found, Missing)
    frequencies, power = found
    step = frequencies[1] - frequencies[0]
    near = np.abs(frequencies - 20) < 3 * step
    level = float(np.median(power[~near]))
    assert level == pytest.approx(2 / RATE, rel=0.1)
    assert float(np.sum(power[near] - level)) * step == pytest.approx(0.5, rel=0.1)


def test_stretches_that_are_too_short_give_no_density() -> None:
    for length, there in ((7, False), (8, True)):
        order = Neighbours.joined([Neighbours.consecutive(length) for _ in range(30)])
        assert isinstance(power_density(np.ones(30 * length), RATE, order), Missing) is not there
