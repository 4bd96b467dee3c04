"""What an energy may depend on, and that an inertia is positive."""

import math
from collections.abc import Iterable, Mapping, Sequence

import sympy

from axisid.modeling.algebra import CANNOT, slope, value_at, vanishes
from axisid.modeling.quantities import Coordinate, Parameter, signals_in, with_numbers
from axisid.support.errors import ModelError

_PLACES = (0, 1, -1, 2, -3, 5)  # of the coordinate where an inertia is looked at
_SIZES = ((1, 1), (1, 7), (7, 1), (1, 100), (100, 1))  # of the parameters, in turn


def check_potential(energy: sympy.Expr, coordinate: Coordinate) -> None:
    """Refuse a potential energy of the velocity or the acceleration.

    Raises
    ------
    ModelError
        It depends on one.
    """
    q = coordinate
    beside = _beside(energy, (q.velocity, q.acceleration))
    if beside:
        raise ModelError(
            f"the potential energy {energy} depends on {beside}; it may depend on the position "
            f"{q.symbol} alone. Put an inertia into the kinetic energy, as in "
            f"m*{q.velocity}**2/2, and friction into the dissipation function."
        )


def check_dissipation(function: sympy.Expr, coordinate: Coordinate) -> None:
    """Refuse a dissipation function of the acceleration.

    Raises
    ------
    ModelError
        It depends on it.
    """
    q = coordinate
    if q.acceleration in function.free_symbols:
        raise ModelError(
            f"the dissipation function {function} depends on {q.acceleration}; it may depend on "
            f"the position {q.symbol} and the velocity {q.velocity} alone. Put an inertia into "
            f"the kinetic energy, as in m*{q.velocity}**2/2."
        )


def check_kinetic(
    energy: sympy.Expr, coordinate: Coordinate, parameters: Sequence[Parameter]
) -> None:
    """Refuse a kinetic energy that is not half an inertia times the square of the velocity.

    Raises
    ------
    ModelError
        It depends on the acceleration, or otherwise on the velocity, or is negative.
    """
    q = coordinate
    if recorded := signals_in(energy):
        raise ModelError(
            f"the kinetic energy {energy} has the signal {min(map(str, recorded))} in it, whose "
            "rate of change would make a force too, and is not recorded. Declare the axis with "
            "newton.",
            code="signal-in-inertia",
        )
    if q.acceleration in energy.free_symbols:
        raise ModelError(
            f"the kinetic energy {energy} depends on {q.acceleration}; it may depend on the "
            f"position {q.symbol} and the square of the velocity alone, as m*{q.velocity}**2/2 "
            "does. Lagrange's equation makes the acceleration of it."
        )
    momentum = slope(energy, q.velocity, "the kinetic energy")
    inertia = slope(momentum, q.velocity, "the momentum")
    square = with_numbers(energy - inertia * q.velocity**2 / 2)
    if not vanishes(with_numbers(inertia).diff(q.velocity)) or not vanishes(square):
        raise ModelError(
            f"the kinetic energy {energy} is not a square of the velocity {q.velocity}: write an "
            f"inertia times {q.velocity}**2/2. What is there at rest is a potential energy, with "
            "the other sign."
        )
    check_inertia(inertia, coordinate, parameters)


def check_inertia(
    inertia: sympy.Expr, coordinate: Coordinate, parameters: Sequence[Parameter]
) -> None:
    """Refuse an inertia that is negative wherever it is looked at.

    With the nominal values, if there are any; else with positive ones, as far as the bounds let.

    Raises
    ------
    ModelError
        It is negative.
    """
    if signals_in(inertia):
        return  # whatever its signals are
    found = {p: p.nominal if p.known is None else p.known for p in parameters}
    inside = {p: value for p, value in found.items() if p.symbol in inertia.free_symbols}
    nominal = all(inside.values())
    points = [{p.symbol: v for p, v in inside.items()}] if nominal else _positive(inside)
    values = [
        _value(with_numbers(inertia), {**point, coordinate.symbol: place})
        for point in points
        for place in _PLACES
    ]
    real = [value for value in values if not math.isnan(value)]
    if real and all(value < 0 for value in real):
        what = "with the nominal values" if nominal else "if its parameters are positive"
        raise ModelError(
            f"the inertia {inertia} is negative {what}; so would be the kinetic energy. Correct "
            "its sign, or a nominal value."
        )


def _beside(energy: sympy.Expr, others: Iterable[sympy.Symbol]) -> str:
    return " and ".join(str(s) for s in others if s in energy.free_symbols)


def _positive(parameters: Iterable[Parameter]) -> list[dict[sympy.Symbol, float]]:
    """Positive numbers of several sizes, or the bound where it is lower."""
    return [
        {p.symbol: min(max(sizes[i % 2], p.lower), p.upper) for i, p in enumerate(parameters)}
        for sizes in _SIZES
    ]


def _value(inertia: sympy.Expr, point: Mapping[sympy.Symbol, float]) -> float:
    """An inertia at a point; NaN where it has none."""
    try:
        return float(value_at(inertia, point))
    except CANNOT:
        return math.nan
