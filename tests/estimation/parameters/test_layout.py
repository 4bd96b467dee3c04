"""Parameters of several records, and what each makes of them."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import UsageError, build, fix
from axisid.estimation.parameters.known import known_of
from axisid.estimation.parameters.layout import layout_of
from axisid.support.remedy import as_options
from tests.axes.leaning import leaning
from tests.axes.stage import generated, stage
from tests.refusals import refuses


def test_two_angles_tell_a_weight_from_an_offset() -> None:
    axis = leaning()
    known = known_of({"angle": [0.0, 0.5]}, 2)
    found = layout_of(axis, 2, known, (), commanded=True)
    assert [p.name for p in found.parameters] == ["m", "w", "f0"]
    theta = np.array([2.0, 10.0, 1.0])
    assert found.own(theta, 0)[-1] == pytest.approx(1.0)
    # The base parameter of the second is w + f0/sin(0.5).
    constant = found.own(theta, 1)[-1] * np.sin(0.5)
    assert constant == pytest.approx(1.0 + 10.0 * np.sin(0.5))
    alike = layout_of(axis, 2, known_of({"angle": [0.5, 0.5]}, 2), (), commanded=True)
    assert len(alike.parameters) == 2


@pytest.mark.parametrize(
    ("known", "local", "said"),
    [
        ({"nothing": [0.0, 1.0]}, (), "no 'nothing' to be known"),
        ({}, ("nothing",), "no parameter 'nothing'"),
        ({"tau0": [0.0, 1.0]}, ("tau0",), "leave one of the two out"),
    ],
)
def test_names_that_the_axis_has_not_are_refused(
    known: dict[str, list[float]], local: tuple[str, ...], said: str
) -> None:
    with pytest.raises(UsageError, match=said):
        layout_of(generated(), 2, known_of(known, 2), local, commanded=True)


def test_a_known_value_beyond_what_its_parameter_can_be_is_refused() -> None:
    axis = stage()
    bounded = [replace(p, lower=0.0) if p.name == "M" else p for p in axis.parameters]
    known = known_of({"M": [90.0, -90.0]}, 2)
    with refuses("records-known-beyond-bounds", "90, -90"):
        layout_of(build(replace(axis, parameters=bounded)), 2, known, ("tau0",), commanded=True)


def test_parameters_that_enter_nonlinearly_have_to_be_known() -> None:
    with refuses("nonlinear-of-several"):
        layout_of(leaning(), 2, (), ("f0",), commanded=True)  # type: ignore[arg-type]


def test_what_is_fixed_of_all_records_is_said_of_each() -> None:
    axis = build(fix(stage(), M=(100.0, 1.0)))
    with refuses("fixed-of-several") as refused:
        layout_of(axis, 2, (), ("tau0",), commanded=True)
    assert "--known M=100.0+-1.0,100.0+-1.0" in refused.value.worded(as_options)
