"""The study of DIDIM beside instruments, in small: what it says of right laws and of wrong ones."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest

study: Any = import_module("output_error")


@pytest.mark.slow
def test_didim_is_unbiased_and_more_precise_than_instruments() -> None:
    shares = study.written(study.figures_of("white noise", runs=12, seed=1))
    iv, didim = (shares["methods"][method] for method in ("idm-iv", "didim"))
    for name in study.TRUTH:
        assert didim["sd_percent"][name] < 0.75 * iv["sd_percent"][name]
        assert abs(didim["bias_percent"][name]) < 3 * didim["sd_percent"][name] / 12**0.5
        assert didim["held"][name] >= 0.9
    assert "fail" not in shares["method"]


@pytest.mark.slow
def test_a_wrong_law_moves_didim_and_not_instruments(
    figures: Callable[..., dict[str, Any]],
) -> None:
    written = figures("output_error", "--runs", "3", "--only", "kp +5 %")
    shares = written["cases"]["kp +5 %"]
    iv, didim = (shares["methods"][method]["bias_percent"] for method in ("idm-iv", "didim"))
    assert didim["Fv"] > 1.0 > 0.6 > abs(iv["Fv"])
    assert shares["control_law"] == {"fail": 3}
    assert "pass" not in shares["method"]
    assert shares["believed"] == {"idm-iv": 3}
    assert set(written["seconds"]) == {"idm-iv", "didim"}
