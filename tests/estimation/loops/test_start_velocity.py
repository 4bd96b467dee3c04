"""The noise of measured positions, by their differences."""

import numpy as np
import pytest

from axisid.estimation.loops import noise_along, position_noise


def test_noise_along_a_record_is_told_by_all_of_it(rng: np.random.Generator) -> None:
    """To 1 %, where its start tells it to 8; a few reversals and knocks do not count."""
    time = 1e-3 * np.arange(20_000)
    motion = 0.1 * np.sin(time) + 1e-4 * np.abs(np.sin(3 * time))
    motion[5000:5003] += 1e-3
    found = [noise_along(motion + 1e-6 * rng.standard_normal(len(time))) for _ in range(30)]
    start = [position_noise(motion + 1e-6 * rng.standard_normal(len(time))) for _ in range(30)]
    assert np.mean(found) == pytest.approx(1e-6, rel=0.02)
    assert np.std(found) < 0.02e-6 < 0.05e-6 < np.std(start)
    short = motion[:500] + 1e-6 * rng.standard_normal(500)
    assert noise_along(short) == position_noise(short)
