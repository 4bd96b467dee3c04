"""Whether a drive's inverse undoes its force, and whether its slope is what another gain does."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.lowering import Program, drive_force, drive_force_by_gain, evaluate
from axisid.codegen.thresholds.generation import MAX_CONTROL_DIFFERENCE, MAX_GAIN_SLOPE_DIFFERENCE
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import CONTROL, FORCE
from axisid.support.arrays import Array
from axisid.support.errors import ModelError

# Controls as shares of the limit, position and velocity, SI; of no simple ratio to one another.
_SHARES = np.array([-0.83, -0.31, -0.07, 0.011, 0.29, 0.61, 0.97])
_POSITIONS = np.array([0.317, -0.8137, 0.0113, 2.71, -0.05, 0.2, -1.3])
_VELOCITIES = np.array([0.73, -0.21, -0.013, 3.1, 0.0, -0.4, 0.09])
_RECORDED = np.array([0.91, 1.3, 0.77, 1.9, 0.63, 1.1, 2.3])  # of every signal
_LEAST = 1e-300
_STEP = 1e-4  # of the gain


def check_drive(model: AxisModel, programs: Sequence[Program]) -> None:
    """Compare controls with those that the drive's inverse makes of their forces.

    Of a gain that has a deviation, the slope by the gain is compared too.

    Raises
    ------
    ModelError
        The inverse does not undo the force, or the slope is not what another gain changes.
    """
    axis, of_name = model.axis, {program.name: program for program in programs}
    most = axis.drive.limit if np.isfinite(axis.drive.limit) else 1.0
    controls = most * _SHARES
    motion = {axis.coordinate.name: _POSITIONS, str(axis.coordinate.velocity): _VELOCITIES}
    motion |= {signal.name: _RECORDED for signal in axis.signals}
    arguments = {**motion, str(CONTROL): controls}
    force = _result(of_name["drive_force"], arguments)
    if axis.drive.relative_sd:
        _check_slope(model, arguments, force)
    again = _result(of_name["drive_control"], {**motion, str(FORCE): force})
    size = np.abs(force)
    held = (size > _LEAST) & np.isfinite(size)  # elsewhere nothing tells the control
    wrong = held & ~(np.abs(again - controls) <= MAX_CONTROL_DIFFERENCE.value * most)
    # A force at the end of what the drive can make has many controls: any of them will do.
    remade = _result(of_name["drive_force"], {**motion, str(CONTROL): again})
    with np.errstate(invalid="ignore"):  # forces that no number holds, which are not held to it
        wrong &= ~(np.abs(remade - force) <= MAX_CONTROL_DIFFERENCE.value * size)
    if not np.any(wrong):
        return
    i, unit = int(np.argmax(wrong)), axis.drive.unit
    raise ModelError(
        f"axis {axis.name!r}: of a control of {controls[i]:.6g} {unit} the drive "
        f"{type(axis.drive).__name__} makes a force of {force[i]:.6g}, for which its inverse "
        f"gives {again[i]:.6g} {unit}; correct one of the two.",
        code="generated-code",
    )


def _check_slope(model: AxisModel, arguments: Mapping[str, Array], force: Array) -> None:
    """Compare the slope by the gain with what other gains make of the same controls."""
    axis, drive = model.axis, model.axis.drive
    more, less = (
        _result(drive_force(_with_gain(model, scale * drive.gain)), arguments)
        for scale in (1 + _STEP, 1 - _STEP)
    )
    with np.errstate(invalid="ignore"):  # forces beyond the largest number are left out below
        found = (more - less) / (2 * _STEP)
    said = _result(drive_force_by_gain(axis), arguments)
    size = np.fmax.reduce(np.abs([force, found, said]))
    held = (size > _LEAST) & np.isfinite(size)
    wrong = held & ~(np.abs(said - found) <= MAX_GAIN_SLOPE_DIFFERENCE.value * size)
    if not np.any(wrong):
        return
    i = int(np.argmax(wrong))
    raise ModelError(
        f"axis {axis.name!r}: of a control of {arguments[str(CONTROL)][i]:.6g} {drive.unit} and "
        f"per share of its gain the drive {type(drive).__name__} changes its force by "
        f"{found[i]:.6g}, its force_by_gain is {said[i]:.6g}; correct one of the two, or leave out "
        "relative_sd.",
        code="generated-code",
    )


def _with_gain(model: AxisModel, gain: float) -> AxisModel:
    return replace(model, axis=replace(model.axis, drive=replace(model.axis.drive, gain=gain)))


def _result(program: Program, elements: Mapping[str, Array]) -> Array:
    (values,) = evaluate(program, elements).values()
    return values[:, 0]
