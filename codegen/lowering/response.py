"""How a drive's force follows held commands, as operations: what it is later, and in a step.

With a lag it is ``target + (tau - target) exp(-t/lag)`` some time t on. A Runge-Kutta step looks
at a force four times. Of an exponential that is much shorter than the step these values would say
little: taken are the one at the start and three of which the step makes exactly the force's
integral and the two integrals after that, as they enter velocity, position, and damping.
"""

import math
from collections.abc import Sequence

from axisid.modeling.declaration import Response

from .lower import Arguments
from .program import Builder, Program

# Below it the mean of an exponential is a series, above it a formula, which would lose digits.
_SMALL, _TERMS = 1.0, 18


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


def forces_in_step(
    builder: Builder, lag: float, held: Sequence[int], step: int
) -> tuple[int, int, int]:
    """The forces that a Runge-Kutta step takes where it looks a second, third and fourth time.

    With x = step/lag and p0 = exp(-x), p1 = (1 - p0)/x, p2 = (1 - p1)/x, p3 = (1/2 - p2)/x the
    force's integral, that one's own and the next are ``target/k! + (tau - target) pk`` over powers
    of the step, k = 1, 2 and 3. The step makes (f1 + 2 f2 + 2 f3 + f4)/6, (f1 + f2 + f3)/6 and
    (f1 + f2)/12 of them.
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
    """``(1/2 - (1 - (1 - exp(-x))/x)/x)/x`` of a number that is not negative."""
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
