"""Rows of long records are filtered column by column: the same rows."""

import numpy as np
import pytest

from axisid import Prefilter
from axisid.estimation.signals import Sampling, sampling


@pytest.mark.parametrize("excluded", [(), ((300, 420), (900, 960))])
def test_columns_of_a_long_record_are_reduced_as_those_of_a_short_one(
    excluded: tuple[tuple[int, int], ...],
    rng: np.random.Generator,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    filtered = Sampling(
        prefilter=Prefilter(cutoff=60.0, decimate=10), samples=2000, period=1e-3, excluded=excluded
    )
    columns = rng.standard_normal((2000, 5))
    at_once = filtered.reduce(columns)
    monkeypatch.setattr(sampling, "_AT_ONCE", 100)
    assert np.array_equal(filtered.reduce(columns), at_once)
