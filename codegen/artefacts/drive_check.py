"""Whether a drive's inverse undoes its force."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.codegen.lowering import Program, evaluate
from axisid.codegen.thresholds.generation import MAX_CONTROL_DIFFERENCE
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


def check_drive(model: AxisModel, programs: Sequence[Program]) -> None:
    """Compare controls with those that the drive's inverse makes of their forces.

    Raises
    ------
    ModelError
        The inverse does not undo the force, or a gain that has a deviation is not in it.
    """
    axis, of_name = model.axis, {program.name: program for program in programs}
    most = axis.drive.limit if np.isfinite(axis.drive.limit) else 1.0
    controls = most * _SHARES
    motion = {axis.coordinate.name: _POSITIONS, str(axis.coordinate.velocity): _VELOCITIES}
    motion |= {signal.name: _RECORDED for signal in axis.signals}
    arguments = {**motion, str(CONTROL): controls}
    force = _result(of_name["drive_force"], arguments)
    if axis.drive.relative_sd and axis.drive.force_by_gain == 0:
        raise ModelError(
            f"axis {axis.name!r}: the gain of the drive {type(axis.drive).__name__} has a "
            "deviation and no part in its force; define force_by_gain, or leave out relative_sd.",
            code="generated-code",
        )
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


def _result(program: Program, elements: Mapping[str, Array]) -> Array:
    (values,) = evaluate(program, elements).values()
    return values[:, 0]
