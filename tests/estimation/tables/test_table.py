"""Samples of a column, taken with their times."""

import numpy as np

from axisid.estimation.tables import Samples

VALUES = np.array([1.0, 2.0, 4.0, 8.0])


def test_samples_are_taken_with_their_times() -> None:
    clock = 0.1 * np.arange(4)
    for rows in (np.array([1, 3]), np.array([False, True, False, True])):
        taken = Samples(values=VALUES, clock=clock).taken(rows)
        assert np.array_equal(taken.values, [2.0, 8.0])
        assert np.array_equal(taken.times, clock[[1, 3]])


def test_samples_without_a_clock_are_counted() -> None:
    samples = Samples(values=VALUES)
    assert np.array_equal(samples.times, np.arange(4.0))
    assert samples.taken(np.array([2])).clock is None
