"""Several records: what is known of each, what each makes of the parameters, their filters.

The drive's gain, and where loops start, found with the parameters of the model.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Axis, Record, build, fit, fix, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import CONTROL, DRIVE_GAIN, formula_drive, voltage_drive
from axisid.estimation.model_validation import validate_fit
from axisid.estimation.output_residuals import ClosedLoopResiduals
from axisid.estimation.regression import InverseForm
from axisid.estimation.unknowns import ExtendedForm
from axisid.estimation.unknowns.joint_parameters import joint_form_of, perturbed_joint_forms
from axisid.estimation.unknowns.known_values import known_of
from axisid.modeling.quantities import Constant
from axisid.support.arrays import Array
from tests.axes.bodies import rod
from tests.axes.leaning import leaning
from tests.axes.stage import generated, stage
from tests.estimation.output_error.fits import TRUTH, looped, off
from tests.refusals import refuses


def test_two_angles_tell_a_weight_from_an_offset() -> None:
    axis = leaning()
    found = joint_form_of(axis, 2, known_of({"angle": [0.0, 0.5]}, 2), (), commanded=True)
    assert [p.name for p in found.parameters] == ["m", "w", "f0"]
    theta = np.array([2.0, 10.0, 1.0])
    assert found.own(theta, 0)[-1] == pytest.approx(1.0)
    # The base parameter of the second is w + f0/sin(0.5).
    constant = found.own(theta, 1)[-1] * np.sin(0.5)
    assert constant == pytest.approx(1.0 + 10.0 * np.sin(0.5))
    alike = joint_form_of(axis, 2, known_of({"angle": [0.5, 0.5]}, 2), (), commanded=True)
    assert len(alike.parameters) == 2


def _bounded() -> GeneratedAxis:
    parameters = [replace(p, lower=0.0) if p.name == "M" else p for p in stage().parameters]
    return build(replace(stage(), parameters=parameters))


@pytest.mark.parametrize(
    ("axis", "known", "local", "said"),
    [
        (generated, {"nothing": [0.0, 1.0]}, (), "known values are given for 'nothing'"),
        (generated, {}, ("nothing",), "no parameter 'nothing'"),
        (generated, {"tau0": [0.0, 1.0]}, ("tau0",), "'tau0' is local"),
        (_bounded, {"M": [90.0, (-90.0, 0.01)]}, ("tau0",), r"90, -90 \+- 0.01"),
        (leaning, {}, ("f0",), "enters nonlinearly"),
        (
            lambda: build(fix(stage(), M=(100.0, 1.0))),
            {},
            ("tau0",),
            r"known=.*\"M\": \[\(100.0, 1.0\)",
        ),
    ],
)
def test_what_records_cannot_share_is_refused_with_what_to_say(
    axis: Callable[[], GeneratedAxis],
    known: dict[str, list[Any]],
    local: tuple[str, ...],
    said: str,
) -> None:
    with refuses("parameters", said):
        joint_form_of(axis(), 2, known_of(known, 2), local, commanded=True)


@pytest.mark.parametrize("values", [[0.0], [0.0, 1.0, 2.0], [0.0, (1.0, -1.0)], [0.0, (1, 2, 3)]])
def test_what_is_no_value_of_each_record_is_refused(values: Any) -> None:
    with refuses("parameters", "Give"):
        known_of({"m": values}, 2)


OFF = 1.03
BEGIN = 300  # where the axis is moving


def _off(axis: Axis, factor: float = OFF) -> GeneratedAxis:
    """Declared with another gain."""
    return build(replace(axis, drive=replace(axis.drive, gain=factor * axis.drive.gain)))


AXES = {
    "emps2015": lambda: load_axis("emps2015"),
    "linear motor": lambda: load_axis("linear_motor"),
    "pendulum": lambda: load_axis("pendulum"),
    "on a voltage": lambda: _on_voltage("emps2015", 1.0),
    "with a gear that loses": lambda: _on_voltage("emps2015", 0.7),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_loop_by_another_gain_is_that_of_the_drive_declared_so(name: str, output: str) -> None:
    """The axis is generated with either gain; what both simulate is the same to rounding."""
    declared = build(AXES[name]())
    other, record = _off(declared.axis), twin_record(declared)
    truth = np.array([*record.provenance.truth.values()])
    form = ExtendedForm(
        declared, of_model=InverseForm(declared), axes=(declared,)
    ).with_drive_gain()
    by_gain = ClosedLoopResiduals(form, [declared], [record], output)
    alone = ClosedLoopResiduals(InverseForm(other), [other], [record], output)
    found = by_gain(np.append(truth, other.axis.drive.gain)[None, :]).errors
    size = float(np.abs(by_gain.measured).max())
    np.testing.assert_allclose(found, alone(truth[None, :]).errors, atol=1e-9 * size)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position", "open-loop"])
def test_a_gain_that_is_declared_wrong_is_found_where_a_parameter_is_held(
    emps2015: GeneratedAxis, twin: Record, output: str
) -> None:
    truth = {**twin.provenance.truth, "drive_gain": emps2015.axis.drive.gain}
    found = fit(_off(emps2015.axis), twin, output, free="gain", fixed={"M": truth["M"]})
    assert found.names == (*TRUTH, "drive_gain")
    assert found["drive_gain"].unit == "N/V"
    assert np.abs(off(found, {name: truth[name] for name in found.names[1:]})).max() < 3.5
    assert found["drive_gain"].deviation < 0.02 * (OFF - 1) * emps2015.axis.drive.gain
    assert found.believed


@pytest.mark.slow
def test_what_the_drive_declares_of_its_gain_was_known_before(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    drive = replace(emps2015.axis.drive, relative_sd=0.01)
    axis = build(replace(emps2015.axis, drive=drive))
    found, alone = fit(axis, twin, free="gain"), fit(emps2015, twin)
    relative, own = (each.deviations / each.physical for each in (found, alone))
    np.testing.assert_allclose(relative, np.hypot([*own, 0.0], 0.01), rtol=0.02)
    assert found.believed
    asked = fit(axis, twin, free="drive_gain", prior={"drive_gain": (36.0, 0.01)})
    assert asked["drive_gain"].value == pytest.approx(36.0, abs=1e-3)


def _on_voltage(name: str, efficiency: float) -> Axis:
    axis = load_axis(name)
    drive = voltage_drive(
        kt=float(axis.drive.gain),
        ke=2.0,
        resistance=1.0,
        efficiency=efficiency,
        limit=axis.drive.limit,
    )
    return replace(axis, drive=drive)


def _braked(axis: Axis) -> Axis:
    """Its drive's force is no multiple of the gain."""
    brake = Constant(5.0, "N/(m/s)", "brake")
    force = DRIVE_GAIN * CONTROL - brake * axis.coordinate.velocity
    return replace(axis, drive=formula_drive(force, gain=35.15, unit="V", limit=10.0))


def _with_rotor(axis: Axis) -> Axis:
    """A number that the data sheet has, and that is no parameter."""
    return replace(axis, force=axis.force + Constant(20.0, "kg") * axis.coordinate.acceleration)


@pytest.mark.parametrize(
    ("made", "output", "says"),
    [
        (_braked, "control", "is not proportional to the gain"),
        (_with_rotor, "control", "a force without parameters"),
        (lambda axis: axis, "force", "force column"),
    ],
)
def test_a_gain_that_cannot_be_searched_is_refused_with_the_reason(
    emps2015: GeneratedAxis, twin: Record, made: Callable[[Axis], Axis], output: str, says: str
) -> None:
    record = replace(twin, force=np.asarray(twin.control) * emps2015.axis.drive.gain)
    with refuses("free", says=f"cannot be free.*{says}"):
        fit(made(emps2015.axis), record, output, free="gain")


def _moving(axis: GeneratedAxis, seed: int) -> tuple[Record, Array]:
    """A record that begins in motion, with the position and the velocity there."""
    theta, reference = [*TRUTH.values()], np.asarray(twin_record(axis).reference)
    record, loop = looped(axis, theta, reference, 3.8e-6, seed=seed, first=BEGIN)
    return record, np.array([loop.position[BEGIN], loop.velocity[BEGIN]])


@pytest.mark.slow
def test_a_start_in_motion_is_found_with_the_parameters(emps2015: GeneratedAxis) -> None:
    record, begun = _moving(emps2015, 1)
    found = fit(emps2015, record, free="start")
    assert found.names == (*TRUTH, "start_position", "start_velocity")
    assert [found[name].unit for name in found.names[3:]] == ["m", "m/s"]
    truth = {**TRUTH, "start_position": begun[0], "start_velocity": begun[1]}
    assert np.abs(off(found, truth)).max() < 3
    assert found["start_position"].deviation < 3.8e-6
    assert abs(begun[1]) > 50 * found["start_velocity"].deviation
    assert found.believed
    assert "start_velocity" in found.summary()
    # It is a little less than what the start of the record leaves.
    assert found.error < fit(emps2015, record).error


@pytest.mark.parametrize("name", ["M", "m_add", "M_plus_m_add"])
def test_each_record_has_a_sum_of_its_own_by_any_that_is_in_it(name: str) -> None:
    joint = joint_form_of(generated(), 2, {}, [name], commanded=False)
    (own,) = joint.local.values()
    said = dict(zip((p.name for p in joint.parameters), joint.expressions, strict=True))
    assert [{"M", "m_add"} <= {*re.findall(r"\w+", said[each])} for each in own] == [True, True]
    assert len(joint.parameters) == len(generated().axis.parameters) + 1


def test_a_sum_is_each_records_own_without_what_else_its_parts_are_in() -> None:
    axis = build(rod())
    named = [p.name for p in axis.axis.parameters if p.name.startswith("J_plus")]
    forms = [joint_form_of(axis, 2, {}, local, commanded=False) for local in (named, ["J"])]
    assert forms[0].parameters == forms[1].parameters
    assert len(forms[0].parameters) == len(axis.axis.parameters) + 1


def test_a_value_known_with_a_deviation_leaves_local_what_is_so_in_products_alone() -> None:
    axis, known = build(rod()), known_of({"J": [0.02, (0.03, 0.001)]}, 2)
    joint = joint_form_of(axis, 2, known, ["m"], commanded=False)
    (perturbed,) = perturbed_joint_forms(axis, joint)
    assert [p.name for p in perturbed.parameters] == [p.name for p in joint.parameters]
    assert joint.local == {"m": ("", "")}
    assert perturbed.known == {"J": ((0.02, 0.0), (0.03 + 0.001, 0.001))}


def test_equal_values_with_equal_deviations_are_one_that_is_larger_in_all_of_its_records() -> None:
    axis = build(rod())
    known = known_of({"J": [0.02, (0.03, 0.001), (0.03, 0.001), (0.03, 0.002)]}, 4)
    joint = joint_form_of(axis, 4, known, ["m"], commanded=False)
    larger = [[v for v, _ in each.known["J"]] for each in perturbed_joint_forms(axis, joint)]
    assert larger == [[0.02, 0.03 + 0.001, 0.03 + 0.001, 0.03], [0.02, 0.03, 0.03, 0.03 + 0.002]]


@pytest.mark.slow
def test_each_record_has_a_start_of_its_own(emps2015: GeneratedAxis, twin: Record) -> None:
    record, begun = _moving(emps2015, 2)
    found = fit(emps2015, [twin, record], free="start", bounds={"start_position": (0, 1)})
    names = [f"start_{what}_{i}" for i in (1, 2) for what in ("position", "velocity")]
    assert [*found.names[3:]] == names
    assert found.local["start_velocity"] == ("start_velocity_1", "start_velocity_2")
    assert found.bounds["start_position_2"] == (0.0, 1.0)
    assert abs(found["start_position_2"].value - begun[0]) < 4e-6
    assert abs(found["start_velocity_2"].value - begun[1]) < 3 * found["start_velocity_2"].deviation
    cut = replace(twin, segments=((0, 3000), (3000, len(twin))))
    pieces = fit(emps2015, cut, free="start", fixed={"start_velocity_1": 0.0})
    assert [*pieces.names[3:]] == names
    assert pieces.fixed == {"start_velocity_1": 0.0}
    # A record that is held against it starts where it is.
    assert validate_fit(found, record).percent == pytest.approx(
        found.of_records[1].percent, rel=0.02
    )
