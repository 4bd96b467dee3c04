"""A force column beside a control: what belongs together passes, what does not is named."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter, Record, identify
from axisid.codegen import GeneratedAxis
from axisid.estimation.force_check import force_checks


def test_only_a_record_with_both_is_judged(emps2015: GeneratedAxis, twin: Record) -> None:
    assert force_checks(emps2015, twin) == ()
    assert twin.control is not None
    alone = replace(twin, control=None, force=35.15 * twin.control)
    assert force_checks(emps2015, alone) == ()


@pytest.mark.parametrize(
    ("scale", "shift", "status"),
    [(1.0, 0, "pass"), (0.5, 0, "fail"), (-1.0, 0, "fail"), (1, 9, "fail")],
)
def test_scale_sign_and_time_are_seen(
    emps2015: GeneratedAxis, twin: Record, scale: float, shift: int, status: str
) -> None:
    assert twin.control is not None
    force = np.roll(scale * 35.15 * twin.control, shift)
    (check,) = force_checks(emps2015, replace(twin, force=force))
    assert check.status == status
    if status == "fail":
        assert f"{scale:.3g} times" in check.meaning or shift


def test_it_stands_in_the_verdict(emps2015: GeneratedAxis, twin: Record) -> None:
    assert twin.control is not None
    halved = replace(twin, force=0.5 * 35.15 * twin.control)
    checks = identify(emps2015, halved, Prefilter(hold="zoh"), "idm-ls").verdict
    assert [c.status for c in checks if c.name == "force against control"] == ["fail"]
