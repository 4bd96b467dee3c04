"""Parameters of several records, and what each makes of them."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import UsageError, build, fix, load_axis
from axisid.estimation.parameters.known import known_of
from axisid.estimation.parameters.layout import GAIN, layout_of
from axisid.support.remedy import as_options
from tests.axes.leaning import leaning
from tests.axes.stage import generated, stage
from tests.refusals import refuses


def test_a_payload_is_taken_off_what_it_is_added_to_and_tells_the_gain() -> None:
    axis = generated()
    assert axis.names == ("M_plus_m_add", "Fv", "Fc", "tau0")
    found = layout_of(axis, 2, known_of({"m_add": [0.0, 20.0]}, 2), (), commanded=True)
    assert [p.name for p in found.parameters] == ["M", "Fv", "Fc", "tau0", GAIN]
    assert found.gain == 35.15
    # With the gain twice the declared one, kappa is a half and so are the scaled parameters.
    physical, _ = found.physical(np.array([50.0, 1.0, 2.0, 3.0, 0.5]))
    assert physical[-1] == pytest.approx(2 * 35.15)
    assert found.own(physical, 0) == pytest.approx([50.0, 1.0, 2.0, 3.0])
    assert found.own(physical, 1) == pytest.approx([60.0, 1.0, 2.0, 3.0])


def test_one_payload_in_all_records_does_not_tell_the_gain() -> None:
    for known in ([20.0, 20.0], [0.0, 0.0]):
        told = known_of({"m_add": known}, 2)
        assert layout_of(generated(), 2, told, (), commanded=True).gain is None
    different = known_of({"m_add": [0.0, 20.0]}, 2)
    assert layout_of(generated(), 2, different, (), commanded=False).gain is None


def test_a_local_parameter_is_one_of_each_record() -> None:
    told = known_of({"m_add": [0.0, 0.0, 0.0]}, 3)
    found = layout_of(generated(), 3, told, ("tau0",), commanded=True)
    assert found.local == {"tau0": ("tau0_1", "tau0_2", "tau0_3")}
    theta = np.array([100.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    assert [p.name for p in found.parameters][3:] == ["tau0_1", "tau0_2", "tau0_3"]
    for i in range(3):
        assert found.own(theta, i) == pytest.approx([100.0, 1.0, 2.0, 3.0 + i])


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


def test_gains_of_the_law_are_each_records_own() -> None:
    axis = build(load_axis("emps2015"))
    found = layout_of(axis, 2, known_of({"kp": [160.18, 120.0]}, 2), (), commanded=True)
    laws = [member.axis.axis.control for member in found.members]
    assert [law.gains["kp"] for law in laws if law is not None] == [160.18, 120.0]
    assert [p.name for p in found.parameters] == ["M", "Fv", "Fc"]


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
    assert 'known={"M": [(100.0, 1.0), (100.0, 1.0)]}' in str(refused.value)
    told = known_of({"M": [(100.0, 1.0), (100.0, 1.0)]}, 2)
    found = layout_of(generated(), 2, told, ("tau0",), commanded=True)
    assert found.known[0].name == "M"


def test_a_drive_that_is_no_gain_keeps_what_is_declared() -> None:
    axis = generated()
    own = replace(axis, axis=replace(axis.axis, drive=replace(axis.axis.drive, gain=10.0)))
    told = known_of({"m_add": [0.0, 20.0]}, 2)
    assert layout_of(own, 2, told, (), commanded=True).gain == 10.0
