"""A check fails where it matters: nothing does on records that are right to 0.003 %."""

from collections.abc import Sequence

import pytest

from axisid import Identification, build, identify, load_axis, twin_record
from axisid.modeling import LIBRARY

RIGHT = 0.003  # percent
#: Where the twin has whole counts, and friction that a dead time delays.
RIGHT_OF = {"servo_joint": 0.02, "valve": 0.006}


def failing(result: Identification) -> list[str]:
    return [check.name for check in result.verdict if check.status == "fail"]


def off(result: Identification) -> float:
    """Largest error of a parameter by any method, percent."""
    truth = result.record.provenance.truth
    return max(
        100 * abs(value.corrected / truth[name] - 1)
        for estimate in result.estimates.values()
        for name, value in estimate.parameters.items()
        if truth.get(name)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "methods", "share"),
    [
        *((name, None, 0.01) for name in LIBRARY),
        *((name, None, 0.0) for name in ("emps2015", "crank", "servo_joint")),
        *((name, [only], 0.01) for name in ("emps", "valve") for only in ("idm-ls", "idm-iv")),
    ],
)
def test_nothing_fails_on_a_record_that_is_right(
    name: str, methods: Sequence[str] | None, share: float
) -> None:
    """Without noise, and with a hundredth of the twin's own."""
    axis = build(load_axis(name))
    record = twin_record(axis, position_noise=share * axis.axis.experiment.position_noise)
    result = identify(axis, record, methods=methods)
    assert off(result) < RIGHT_OF.get(name, RIGHT)
    assert failing(result) == []
