"""The drive as programs: the force that a control makes, and the control that makes a force."""

import sympy

from axisid.modeling.declaration import Axis, Drive
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import CONTROL, DIRECTION, FORCE, number

from .lower import Arguments, Lowering
from .program import Builder, Program


def drive_force(model: AxisModel) -> Program:
    """Build the force of a control and the motion."""
    return _of_control(
        model.axis,
        model.axis.drive.force,
        "drive_force",
        "Force that the drive makes of a control within its limit.",
    )


def drive_force_in_mode(axis: Axis) -> Program:
    """The same in a friction direction, behind the velocity, which at rest no sign tells."""
    return _of_control(
        axis,
        axis.drive.force,
        "drive_force_in_mode",
        "Force that the drive makes of a control in a friction direction.",
        directed=True,
    )


def drive_force_by_gain(axis: Axis) -> Program:
    """Build the slope of that force by the logarithm of the gain.

    It is in no generated file: what a deviation of the gain does is asked seldom.
    """
    return _of_control(
        axis,
        axis.drive.force_by_gain,
        "drive_force_by_gain",
        "Slope of the drive's force by the logarithm of its gain.",
    )


def drive_control(model: AxisModel) -> Program:
    """Build the control of a force and the motion."""
    q, drive = model.axis.coordinate, model.axis.drive
    arguments = Arguments().scalars(FORCE, q.symbol, q.velocity, *model.axis.signal_symbols)
    arguments.builder.output("control", [[_lowered(arguments, model.axis, drive.inverse)]])
    return arguments.builder.program(
        "drive_control", "Control of which the drive makes a force, whatever its limit."
    )


def acting_control(
    builder: Builder, model: AxisModel, command: int, last: int | None
) -> tuple[int, tuple[int, ...]]:
    """What acts of a command, and what the drive remembers of it: nothing without a limited rate.

    Parameters
    ----------
    builder : Builder
    model : AxisModel
    command : int
        Within the drive's limit.
    last : int or None
        What it remembers of the sample before.
    """
    build, path, response = builder.apply, model.axis.drive.path, model.axis.response
    acting = command
    remembered: tuple[int, ...] = ()
    if response is not None and path.is_limited and last is not None:
        acting = build("add", last, within(response.steepest, builder, build("sub", command, last)))
        remembered = (acting,)
    if path.quantisation:
        steps = build("mul", acting, builder.constant(1 / path.quantisation))
        nearest = build("floor", build("add", steps, builder.constant(0.5)))
        acting = build("mul", nearest, builder.constant(path.quantisation))
    if path.deadband:
        acting = build("sub", acting, within(path.deadband, builder, acting))
    return acting, remembered


def within(limit: float, builder: Builder, value: int) -> int:
    """A value clipped at plus and minus a limit; infinite for none."""
    if limit == float("inf"):
        return value
    # Selected, not min and max: those would turn a control that is not a number into the limit.
    upper, lower = builder.constant(limit), builder.constant(-limit)
    value = builder.apply("select", builder.apply("lt", upper, value), upper, value)
    return builder.apply("select", builder.apply("lt", value, lower), lower, value)


def _of_control(
    axis: Axis, value: sympy.Expr, name: str, about: str, *, directed: bool = False
) -> Program:
    q = axis.coordinate
    direction = (DIRECTION,) if directed else ()
    arguments = Arguments().scalars(CONTROL, q.symbol, q.velocity, *direction, *axis.signal_symbols)
    arguments.builder.output("tau", [[_lowered(arguments, axis, value)]])
    return arguments.builder.program(name, about)


def _lowered(arguments: Arguments, axis: Axis, value: sympy.Expr) -> int:
    """An expression of the drive; without a friction direction that is the velocity's sign."""
    values, builder = arguments.values, arguments.builder
    for symbol, here in axis.drive.along(axis.coordinate).items():
        values[symbol] = values[here]
    if DIRECTION not in values and value.has(DIRECTION):
        values[DIRECTION] = builder.apply("sign", values[axis.coordinate.velocity])
    return drive_lowering(arguments, axis.drive)(value)


def drive_lowering(arguments: Arguments, drive: Drive) -> Lowering:
    """What lowers a drive's expressions."""
    builder, name = arguments.builder, type(drive).__name__
    constants = {
        symbol: builder.constant(number(value, f"the constant {symbol} of the drive {name}"))
        for symbol, value in drive.constants.items()
    }
    return Lowering(builder, {**arguments.values, **constants})
