"""Where friction depends on the position, the band holds the truth more often than the interval."""

from importlib import import_module
from typing import Any

import pytest

study: Any = import_module("model_error")


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "motion"), [("sine of 0.2 m", "moves")])
def test_the_band_holds_what_the_interval_misses(shape: str, motion: str) -> None:
    found = study.coverage(shape, motion, runs=12, seed=1)
    assert found["hac"]["Fc"] < 0.7
    assert found["shown"]["Fc"] > 0.9
    assert found["shown"]["Fv"] > 0.9
    assert found["moves"]["Fv"] <= found["band"]["Fv"]
