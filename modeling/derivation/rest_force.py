"""The equation of motion at rest, term by term: what a motion starts from, and comes back to."""

from collections.abc import Sequence

import sympy

from axisid.modeling.algebra import float_at
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import at_start, with_numbers


def forces_at_rest(
    axis: Axis, parameters: Sequence[float], position: float, recorded: Sequence[float]
) -> tuple[tuple[str, float], ...]:
    """The terms of the equation of motion, each with its force at rest; NaN where it has none.

    Parameters
    ----------
    axis : Axis
    parameters : sequence of float
        Length p, finite.
    position : float
    recorded : sequence of float
        The recorded signals, in the axis's order.
    """
    point = motion_point(axis, parameters, (position, 0.0), recorded)
    return tuple(
        (str(term), float_at(with_numbers(at_start(term)), point))
        for term in sympy.Add.make_args(axis.force)
    )


def motion_point(
    axis: Axis, parameters: Sequence[float], motion: tuple[float, float], recorded: Sequence[float]
) -> dict[sympy.Symbol, float]:
    """Numbers for the symbols of a force that is not accelerated."""
    q = axis.coordinate
    symbols = (*(p.symbol for p in axis.parameters), *axis.signal_symbols)
    named = dict(zip(symbols, (*parameters, *recorded), strict=True))
    return {**named, q.symbol: motion[0], q.velocity: motion[1], q.acceleration: 0.0}
