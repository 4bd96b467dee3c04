"""How a drive's force follows held commands, as operations: what it is later, and in a step.

With a lag it is ``target + (tau - target) exp(-t/lag)`` some time t on. A Runge-Kutta step sees a
force at its start, its middle and its end. Of an exponential that is much shorter than the step
these would say little: taken are the ones at the start and two of which the step makes exactly the
force's integral and that integral's own, as they enter velocity and position. What moves with the
motion beside the force is then as accurate as in any step.
"""

from collections.abc import Sequence

from axisid.modeling.declaration import Response

from .lower import Arguments
from .program import Builder, Program

# Below it the mean of an exponential is a series, above it a formula, which would lose digits.
_SMALL, _TERMS = 0.5, 14


def drive_response(response: Response) -> Program:
    """Build what the time loop asks of a drive that does not follow at once."""
    builder = Arguments().builder
    tau, target, span = map(builder.scalar, ("tau", "target", "span"))
    later = later_force(builder, response.lag, (tau, target), span) if response.lag else tau
    builder.output("tau_later", [[later]])
    until = builder.apply("mul", builder.constant(response.share), span)
    builder.output("until", [[until]])
    return builder.program(
        "drive_response",
        "The drive's force later, and when a command acts within a sample of such a length.",
    )


def later_force(builder: Builder, lag: float, held: Sequence[int], span: int) -> int:
    """The force some time on, from what is held: the force, and what it goes to."""
    build, (tau, target) = builder.apply, held
    decay = build("exp", build("neg", build("div", span, builder.constant(lag))))
    return build("add", target, build("mul", build("sub", tau, target), decay))


def forces_in_step(builder: Builder, lag: float, held: Sequence[int], step: int) -> tuple[int, int]:
    """The force that a Runge-Kutta step takes in its middle, and at its end.

    With x = step/lag and the means p1 = (1 - exp(-x))/x, p2 = (1 - p1)/x the integrals over the
    step are ``target + (tau - target) p1`` and ``target/2 + (tau - target) p2``, over its length
    and the length's square; the step makes of them (first + 4 middle + last)/6 and
    (first + 2 middle)/6.
    """
    build, number, (tau, target) = builder.apply, builder.constant, held
    x = build("div", step, number(lag))
    p2 = _second_mean(builder, x)
    p1 = build("sub", number(1), build("mul", x, p2))
    middle = build("sub", build("mul", number(3), p2), number(0.5))
    last = build("sub", p1, build("mul", number(2), p2))
    last = build("add", build("mul", number(6), last), number(1))
    off = build("sub", tau, target)
    in_middle, at_end = (build("add", target, build("mul", off, f)) for f in (middle, last))
    return in_middle, at_end


def _second_mean(builder: Builder, x: int) -> int:
    """``(exp(-x) - 1 + x)/x**2`` of a number that is not negative."""
    build, number = builder.apply, builder.constant
    few, many = build("min", x, number(_SMALL)), build("max", x, number(_SMALL))
    series, factor = number(0), 1.0
    factors = [factor := factor / (k + 2) for k in range(_TERMS)]
    for k in reversed(range(_TERMS)):
        series = build("sub", number(factors[k]), build("mul", few, series))
    rest = build("sub", build("exp", build("neg", many)), number(1))
    formula = build("div", build("add", rest, many), build("mul", many, many))
    return build("select", build("lt", x, number(_SMALL)), series, formula)
