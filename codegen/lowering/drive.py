"""The drive as programs: the force of a control, its inverse, and the response to a command.

With a lag the force is ``target + (tau - target) exp(-t/lag)`` after a time t. A Runge-Kutta step
evaluates the force four times. If the lag is much shorter than the step, four samples of this
exponential would give a wrong integral. Instead the step uses the force at its start and three
forces that are computed so that the single, double and triple integral of the force over the step
are exact. These integrals enter velocity, position and damping.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy

from axisid.modeling.declaration import Axis, Response
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import CONTROL, DIRECTION, FORCE, number

from .expressions import Arguments, Lowering
from .program import Builder, Program


def drive_force(axis: Axis, *, directed: bool = False, by_gain: bool = False) -> Program:
    """Return the program of the drive's force for a control and a motion.

    Parameters
    ----------
    axis : Axis
    directed : bool
        True if the friction direction is an argument too, after the velocity. Otherwise the
        direction is the sign of the velocity, which is wrong at rest.
    by_gain : bool
        True if the result is the derivative of the force by the logarithm of the gain.
    """
    q, drive = axis.coordinate, axis.drive
    direction = (DIRECTION,) if directed else ()
    arguments = Arguments().scalars(CONTROL, q.symbol, q.velocity, *direction, *axis.signal_symbols)
    value = drive.force_by_gain if by_gain else drive.force
    arguments.output("tau", [[_lowered(arguments, axis, value)]])
    about = "Force that the drive produces for a control within its limit."
    return arguments.program("drive_force", about)


def drive_control(model: AxisModel) -> Program:
    """Return the program of the control with which the drive produces a given force."""
    q, drive = model.axis.coordinate, model.axis.drive
    arguments = Arguments().scalars(FORCE, q.symbol, q.velocity, *model.axis.signal_symbols)
    arguments.output("control", [[_lowered(arguments, model.axis, drive.inverse)]])
    return arguments.program(
        "drive_control", "Control for which the drive produces a force, ignoring its limit."
    )


def acting_control(
    builder: Builder, model: AxisModel, command: int, last: int | None
) -> tuple[int, tuple[int, ...]]:
    """Return the control that acts for a command, and the controls that the drive stores.

    All are indices of operations. Rate limit, quantisation and dead band are applied in this order.
    With a rate limit the drive stores the control before quantisation; otherwise it stores nothing.

    Parameters
    ----------
    builder : Builder
    model : AxisModel
    command : int
        Index of the command, which is within the drive's limit.
    last : int or None
        Index of the control that was stored at the sample before; None if there is none.
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
    """Return the operation that clips a value at plus and minus a limit.

    Without a limit, which is infinite, the value is returned unchanged.
    """
    if limit == float("inf"):
        return value
    # Selections instead of min and max, which would replace a control that is NaN by the limit.
    upper, lower = builder.constant(limit), builder.constant(-limit)
    value = builder.apply("select", builder.apply("lt", upper, value), upper, value)
    return builder.apply("select", builder.apply("lt", value, lower), lower, value)


def _lowered(arguments: Arguments, axis: Axis, value: sympy.Expr) -> int:
    """Return the operation of an expression of the drive.

    If the friction direction is not among the arguments, the sign of the velocity is used.
    """
    values, drive = arguments.values, axis.drive
    for symbol, here in drive.along(axis.coordinate).items():
        values[symbol] = values[here]
    if DIRECTION not in values and value.has(DIRECTION):
        values[DIRECTION] = arguments.apply("sign", values[axis.coordinate.velocity])
    name = type(drive).__name__
    constants = {
        symbol: arguments.constant(number(given, f"the constant {symbol} of the drive {name}"))
        for symbol, given in drive.constants.items()
    }
    return Lowering(arguments, {**values, **constants})(value)


# Below `_SMALL` the means of an exponential are computed by a series with `_TERMS` terms, because
# the formula would lose digits there.
_SMALL, _TERMS = 1.0, 18


def drive_response(response: Response) -> Program:
    """Return the program of the response of a drive whose force changes between samples.

    Its results are the force after a time span, and the time from a sample at which a command
    begins to act.
    """
    builder = Builder()
    tau, target, span = map(builder.scalar, ("tau", "target", "span"))
    later = later_force(builder, response.lag, (tau, target), span) if response.lag else tau
    builder.output("tau_later", [[later]])
    until = builder.apply("mul", builder.constant(response.share), span)
    builder.output("until", [[until]])
    return builder.program(
        "drive_response",
        "Force of the drive some time later, and the time in a sample at which a command acts.",
    )


def later_force(builder: Builder, lag: float, held: Sequence[int], span: int) -> int:
    """Return the operation of the force after a time: ``target + (tau - target) exp(-span/lag)``.

    Parameters
    ----------
    builder : Builder
    lag : float
        Time constant, s.
    held : sequence of int
        Operations of the force now and of its final value.
    span : int
        Operation of the time, s.
    """
    build, (tau, target) = builder.apply, held
    decay = build("exp", build("neg", build("div", span, builder.constant(lag))))
    return build("add", target, build("mul", build("sub", tau, target), decay))


def forces_in_step(
    builder: Builder, lag: float, held: Sequence[int], step: int
) -> tuple[int, int, int]:
    """Return the forces of a Runge-Kutta step at its second, third and fourth evaluation.

    With x = step/lag and p0 = exp(-x), p1 = (1 - p0)/x, p2 = (1 - p1)/x, p3 = (1/2 - p2)/x the
    k-fold integral of the force over the step is ``step**k (target/k! + (tau - target) pk)``, for
    k = 1, 2 and 3. With the forces f1 to f4 of its four evaluations, a Runge-Kutta step computes
    these integrals, over ``step**k``, as (f1 + 2 f2 + 2 f3 + f4)/6, (f1 + f2 + f3)/6 and
    (f1 + f2)/12. f1 is the force now; the three equations give f2, f3 and f4.
    """
    build, number, (tau, target) = builder.apply, builder.constant, held
    x = build("div", step, number(lag))
    p3 = _third_mean(builder, x)
    p2 = build("sub", number(0.5), build("mul", x, p3))
    p1 = build("sub", number(1), build("mul", x, p2))
    six, twelve = number(6), build("mul", number(12), p3)
    shares = (
        build("sub", twelve, number(1)),
        build("sub", build("mul", six, p2), twelve),
        build("add", build("mul", six, build("sub", p1, build("mul", number(2), p2))), number(1)),
    )
    off = build("sub", tau, target)
    second, third, fourth = (build("add", target, build("mul", off, share)) for share in shares)
    return second, third, fourth


def _third_mean(builder: Builder, x: int) -> int:
    """Return the operation of ``p3 = (1/2 - (1 - (1 - exp(-x))/x)/x)/x`` for x of 0 or more.

    For x below 1 a series is used, because the formula would lose digits there.
    """
    build, number = builder.apply, builder.constant
    few, many = build("min", x, number(_SMALL)), build("max", x, number(_SMALL))
    series = number(0)
    for k in reversed(range(_TERMS)):
        term = number(1 / math.factorial(k + 3))
        series = build("sub", term, build("mul", few, series))
    rest = build("sub", number(1), build("exp", build("neg", many)))
    p1 = build("div", rest, many)
    p2 = build("div", build("sub", number(1), p1), many)
    formula = build("div", build("sub", number(0.5), p2), many)
    return build("select", build("lt", x, number(_SMALL)), series, formula)


@dataclass(frozen=True, slots=True)
class DriveInMode:
    """A drive with a given friction direction, in a program that is being built.

    Attributes
    ----------
    builder : Builder
        Builder of the program. Each int below is the index of one of its operations.
    model : AxisModel
    direction : tuple of int
        The friction direction, a tuple of one.
    signals : sequence of tuple of int
        Value of each recorded signal, each a tuple of one.
    """

    builder: Builder
    model: AxisModel
    direction: tuple[int, ...]
    signals: Sequence[tuple[int]]

    def force(self, control: int, q: int, dq: int) -> int:
        """Return the operation of the force for a control at a position and velocity."""
        directed = self.model.axis.drive.force.has(DIRECTION)
        program = drive_force(self.model.axis, directed=directed)
        mode = (self.direction,) if directed else ()
        (tau,) = self.builder.inline(program, (control,), (q,), (dq,), *mode, *self.signals)["tau"]
        return tau


def acting_from_sample(
    drive: DriveInMode,
    command: int,
    motion: tuple[int, int],
    remembered: tuple[int, ...],
    slope: Callable[[int], int],
) -> tuple[int, tuple[int, ...], tuple[int, ...]]:
    """Return the force at a sample, the values held until the next one, and the drive's next state.

    Rate limit, quantisation and dead band turn the command into the acting control. Its force is
    delayed by whole samples, then by a fraction of a sample. The lag is applied last. If the
    control is held while the force depends on the motion, controls are delayed instead of forces.

    Parameters
    ----------
    drive : DriveInMode
    command : int
        Output of the law.
    motion : (int, int)
        Position and velocity at the sample.
    remembered : tuple of int
        State of the drive, which it stored at the sample before (see `Response.remembered`).
    slope : callable
        Function that returns the acceleration at the sample for a force.
    """
    builder, response = drive.builder, drive.model.axis.response
    acting, last = acting_control(builder, drive.model, command, next(iter(remembered), None))
    if response is None:
        tau = drive.force(acting, *motion)
        return tau, (tau,), ()
    # Forces (or controls) of earlier commands, the newest first; last the acting force, if stored.
    forces = remembered[len(remembered) - len(response.forces) :]
    new = acting
    if not response.holds_control:
        if response.by_motion:
            # With a lag, the part of the force that depends on the motion is held over a sample
            # like the command. It is evaluated half a sample later, so that its mean delay is zero.
            build, half, (q, dq) = builder.apply, builder.constant(response.period / 2), motion
            sliding = build("abs", drive.direction[0])
            change = build("mul", slope(forces[-1]), sliding)
            motion = (
                build("add", q, build("mul", half, dq)),
                build("add", dq, build("mul", half, change)),
            )
        new = drive.force(acting, *motion)
    # Delayed forces (or controls), the newest first, without the acting force.
    pending = (new, *forces[: len(forces) - response.keeps_force])
    # `then` acts at the end of the sample. If the delay has a fraction of a sample, the older
    # `first` acts before `then`.
    then = pending[response.whole]
    first = pending[-1] if response.share else then
    if not response.keeps_force:
        return first, (first,), (*last, *pending[:-1])
    if response.holds_control:
        now = end = drive.force(first, *motion)
    else:
        # With a lag, the force moves from the present one (`now`) to that of the next sample.
        now = end = forces[-1]
        parts = ((first, response.share), (then, 1 - response.share))
        for target, share in parts if response.share else parts[1:]:
            span = builder.constant(share * response.period)
            end = later_force(builder, response.lag, (end, target), span)
    return now, (now, first), (*last, *pending[:-1], end)
