"""The study of laws in small: a right one passes, a gain that is off is named."""

from importlib import import_module
from typing import Any

import pytest

study: Any = import_module("control_laws")


@pytest.mark.slow
@pytest.mark.parametrize("log", ["exact", "rounded", "control noise"])
def test_a_right_law_passes_and_a_wrong_gain_is_named(log: str) -> None:
    figures = study.figures_of("cascade_p_pi", log, runs=1, seed=1)
    assert (figures.runs, figures.failed) == (1, 0)
    assert set(figures.named) == {f"{g} {off} %" for g in ("kp", "kv", "tn") for off in (5, 10)}
    assert figures.noticed == figures.changed
