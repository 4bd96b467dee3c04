"""A control that is recorded a little too large or small fails where it moves a parameter far."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, identify, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.verdict_checks import belief


@pytest.fixture(scope="module")
def axis() -> GeneratedAxis:
    return build(load_axis("emps2015"))


@pytest.fixture(scope="module")
def record(axis: GeneratedAxis) -> Record:
    return twin_record(axis, seed=3)


@pytest.mark.parametrize(
    ("scale", "status"), [(1.0, "pass"), (1.0099, "fail"), (0.9901, "fail"), (1.00001, "pass")]
)
def test_a_scale_within_one_percent_fails_by_what_it_moves(
    axis: GeneratedAxis, record: Record, scale: float, status: str
) -> None:
    scaled = replace(record, control=scale * np.asarray(record.control))
    result = identify(axis, scaled)
    (law,) = (check for check in result.verdict if check.name == "control law")
    assert law.status == status
    assert (belief(result.verdict) == "not believed") == (status == "fail")


def test_a_measured_force_has_nothing_of_the_scale_of_the_control(
    axis: GeneratedAxis, record: Record
) -> None:
    control = np.asarray(record.control)
    gain = axis.axis.drive.gain
    measured = replace(record, control=1.005 * control, force=gain * control)
    (law,) = (check for check in identify(axis, measured).verdict if check.name == "control law")
    assert law.status == "pass"
