"""The feed-forward of an identified axis: its inverse dynamics with the parameters as numbers.

It is made by the same lowering as every other function of the axis. The friction direction is the
sign of the velocity, and 0 at rest: a feed-forward gets the velocity of the reference, which is
exactly 0 at rest.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import FORCE, SignalSymbol, signals_in
from axisid.support.checks import refuse
from axisid.support.errors import ModelError, UsageError

from .axis_functions import inverse_dynamics
from .drive import drive_control, within
from .program import Builder, Program


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportedConstant:
    """A parameter as a number in exported text.

    Attributes
    ----------
    name : str
    value : float
        SI.
    comment : str
        Comment next to the number.
    """

    name: str
    value: float
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedForward:
    """The programs that a printer turns into ``NAME_feedforward`` and ``NAME_control``.

    Attributes
    ----------
    name : str
        Name of the axis.
    about : tuple of str
        Lines of the text's heading.
    constants : tuple of ExportedConstant
        The parameters, in the axis's order.
    motion : mapping of str to str
        Unit of position, velocity and acceleration, and of recorded signals, by name.
    force : Program
        Force from the motion and the parameters; its summary describes the result in one or two
        sentences.
    control : Program
        Control from ``tau``, position and velocity, with which the drive produces ``tau``, within
        its limit.
    """

    name: str
    about: tuple[str, ...]
    constants: tuple[ExportedConstant, ...]
    motion: Mapping[str, str]
    force: Program
    control: Program

    @property
    def functions(self) -> tuple[str, str]:
        """Names of the two functions."""
        return f"{self.name}_feedforward", f"{self.name}_control"


def feed_forward(
    model: AxisModel,
    parameters: Mapping[str, tuple[float, str]],
    about: tuple[str, ...] = (),
    dead_zone: float = 0.0,
) -> FeedForward:
    """Return the feed-forward of an axis, ready for a printer, with parameters as numbers.

    Parameters
    ----------
    model : AxisModel
    parameters : mapping of str to (float, str)
        Value and comment of every parameter, by name.
    about : tuple of str
        Lines of the text's heading.
    dead_zone : float
        Speed up to which the friction direction is 0, in the velocity's unit.

    Raises
    ------
    UsageError
        The dead zone is negative, or a value is not finite.
    ModelError
        The friction has internal states, so that a motion alone does not give the force.
    """
    if model.states:
        raise ModelError(
            f"axis {model.axis.name!r}: its friction has internal states, so the force depends on "
            "the past motion and not only on position, velocity and acceleration. A feed-forward "
            "is not possible. Export an axis whose friction has no internal states.",
            code="export",
        )
    refuse(
        UsageError,
        (
            not (math.isfinite(dead_zone) and dead_zone >= 0),
            f"the dead zone is {dead_zone!r}. Give a speed of 0 or more",
        ),
        *(
            (
                not math.isfinite(value),
                f"{name} is {value!r}, which cannot be exported. Give a finite value",
            )
            for name, (value, _) in parameters.items()
        ),
        code="export",
    )
    axis, q, drive = model.axis, model.axis.coordinate, model.axis.drive
    at_rest = f"up to a speed of {dead_zone!r} {q.unit}/s" if dead_zone else "at rest"
    reach = "" if math.isinf(drive.limit) else f", within {-drive.limit:g} and {drive.limit:g}"
    reach += f", over the dead band of {drive.deadband:g}" if drive.deadband else ""
    follows = drive.lag or drive.delay or drive.path.is_limited
    reach += ", once the drive has followed" if follows else ""
    return FeedForward(
        name=axis.name,
        about=about,
        constants=tuple(
            ExportedConstant(
                name=p.name, value=parameters[p.name][0], comment=parameters[p.name][1]
            )
            for p in axis.parameters
        ),
        motion={
            q.name: q.unit,
            f"{q.velocity}": f"{q.unit}/s",
            f"{q.acceleration}": f"{q.unit}/s^2",
            **{s.name: s.unit for s in axis.signals if s.symbol in _needed(model)},
        },
        force=_force(
            model,
            dead_zone,
            f"Force in {q.force_unit} that the motion needs. The friction direction is the sign of "
            f"{q.velocity}, 0 {at_rest}.",
        ),
        control=_control(model, f"Control in {axis.drive.unit} for that force{reach}."),
    )


def _force(model: AxisModel, dead_zone: float, about: str) -> Program:
    """Return the program of the force for a motion; up to `dead_zone` the direction is 0."""
    builder, q = Builder(), model.axis.coordinate
    motion = [builder.scalar(s.name) for s in (q.symbol, q.velocity, q.acceleration)]
    recorded = _recorded(builder, model)
    parameters = builder.vector("parameters", [p.name for p in model.axis.parameters])
    direction = _direction(builder, motion[1], dead_zone)
    arguments = (*((index,) for index in (*motion, direction, *recorded)), parameters)
    (tau,) = builder.inline(inverse_dynamics(model), *arguments)["tau"]
    builder.output("tau", [[tau]])
    return builder.program("feedforward", about)


def _needed(model: AxisModel) -> frozenset[SignalSymbol]:
    """Return the recorded signals on which force and control depend."""
    return signals_in(model.force, model.axis.drive.inverse)


def _recorded(builder: Builder, model: AxisModel) -> list[int]:
    """Return the operation of each recorded signal: an argument if it is needed, otherwise 0."""
    needed = _needed(model)
    return [
        builder.scalar(s.name) if s.symbol in needed else builder.constant(0.0)
        for s in model.axis.signals
    ]


def _direction(builder: Builder, velocity: int, dead_zone: float) -> int:
    """Return the operation of the friction direction: sign of the velocity, 0 in the dead zone."""
    if not dead_zone:
        return builder.apply("sign", velocity)
    upper, lower = builder.constant(dead_zone), builder.constant(-dead_zone)
    return builder.apply(
        "sub", builder.apply("lt", upper, velocity), builder.apply("lt", velocity, lower)
    )


def _control(model: AxisModel, about: str) -> Program:
    """Return the program of the control for a force, plus the dead band, within the limit."""
    drive, q = model.axis.drive, model.axis.coordinate
    builder = Builder()
    signals = [(builder.scalar(s.name),) for s in (FORCE, q.symbol, q.velocity)]
    signals += [(index,) for index in _recorded(builder, model)]
    (control,) = builder.inline(drive_control(model), *signals)["control"]
    if drive.deadband:
        band = builder.apply(
            "mul", builder.apply("sign", control), builder.constant(drive.deadband)
        )
        control = builder.apply("add", control, band)
    builder.output("control", [[within(drive.limit, builder, control)]])
    return builder.program("control", about)
