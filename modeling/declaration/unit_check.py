"""Check the units of the equation of motion: every term must be a force, or a torque."""

from collections.abc import Collection, Iterable, Mapping

import sympy

from axisid.modeling.quantities import (
    ConstantSymbol,
    Coordinate,
    Parameter,
    Signal,
    State,
    Unit,
    UnitReader,
    UnitsError,
    parse_unit,
)
from axisid.support.errors import ModelError


def checked_terms(
    force: sympy.Expr,
    coordinate: Coordinate,
    parameters: Collection[Parameter],
    signals: Iterable[Signal | State],
) -> tuple[str, ...]:
    """Check the unit of every term, and return the terms that could not be checked.

    The factors 1, 2 and 1/2 are dimensionless. A term with another plain number is correct if its
    unit is right with a dimensionless number. If not, the number may stand for a quantity with a
    unit: the term is then returned as text, with the unit that this quantity must have. In a known
    load, which is a term without parameters and constants, any number may have a unit.

    Parameters
    ----------
    force : sympy.Expr
        The equation of motion.
    coordinate : Coordinate
    parameters : collection of Parameter
    signals : iterable of Signal or State
        Further quantities in the equation of motion.

    Raises
    ------
    ModelError
        A term has another unit than the drive's force; the message names the term and both units.
    """
    units = unit_table(coordinate, (*parameters, *signals))
    unknown = {p.symbol for p in parameters}
    kind = "linear" if coordinate.unit == "m" else "rotary"
    rest = (
        f" ({{inside}}), but the drive of a {kind} axis gives {coordinate.force_unit}. All terms "
        "must have this unit. Correct a unit or the term"
    )
    unchecked = []
    for term in sympy.Add.make_args(force):
        is_load = not term.free_symbols & unknown and not term.atoms(ConstantSymbol)
        excused = check_unit(
            term, coordinate.force_unit, units, f"the term {term}", rest, of_numbers=is_load
        )
        if excused:
            missing = ", ".join(dict.fromkeys(map(str, excused)))
            unchecked.append(f"{term} (correct if its plain numbers have the unit {missing})")
    return tuple(unchecked)


def check_states(
    states: Collection[State], coordinate: Coordinate, parameters: Iterable[Parameter]
) -> None:
    """Refuse a state whose parts, rate, limit or start value do not have the expected unit.

    The rate must have the unit of the state per second. The limit, if there is one, and the start
    value must have the unit of the state. A part must have the unit that the part declares.

    Raises
    ------
    ModelError
        A unit is not the expected unit; the message names both units.
    """
    units = unit_table(coordinate, (*parameters, *states))
    # A state has two symbols with one unit. `state.symbol`, in the table already, contains the
    # differential equation and is used by the equation of motion and by other states. `state.own`
    # is the plain symbol, which the state uses in its own equation.
    units |= {state.own: parse_unit(state.unit) for state in states}
    for part in (part for state in states for part in state.parts):
        check_unit(part.value, parse_unit(part.unit), units, f"{part.what}, {part.value},")
    for state in states:
        unit = parse_unit(state.unit)
        rate, *others = state.values  # the others are the limit, if there is one, and the start
        for value, wanted in ((rate, unit / parse_unit("s")), *((v, unit) for v in others)):
            check_unit(
                value, wanted, units, f"{value} of the state {state.name}, which is in {unit},"
            )


def check_unit(
    value: sympy.Expr,
    wanted: Unit,
    units: Mapping[sympy.Symbol, Unit],
    what: str,
    rest: str = ". Give {wanted}",
    *,
    of_numbers: bool = False,
) -> list[Unit]:
    """Check the unit of an expression, and return the units that its plain numbers must have.

    The list is empty if the unit is right with dimensionless numbers. An expression whose unit is
    wrong in any case is refused.

    Parameters
    ----------
    value : expression
    wanted : Unit
        Unit that the expression must have.
    units : mapping of sympy.Symbol to Unit
        Units of its symbols.
    what : str
        Description of the expression, for messages.
    rest : str
        End of the message, with ``{wanted}``, the unit, and ``{inside}``, the units of its symbols.
    of_numbers : bool
        Whether the expression contains no parameters and constants; see `UnitReader`.

    Raises
    ------
    ModelError
        The unit is not the wanted unit; the message names both units.
    """
    reader = UnitReader(units, loose_numbers=True, of_numbers=of_numbers)
    try:
        fits = value == 0 or reader.fits(value, wanted)
    except UnitsError as error:
        raise ModelError(f"the units in {what} do not fit: {error}") from error
    if not fits:
        table = {str(s): u for s, u in units.items() if s in value.free_symbols}
        table |= {s.name: s.unit for s in value.atoms(ConstantSymbol)}
        inside = ", ".join(f"{name} in {table[name]}" for name in sorted(table))
        raise ModelError(
            f"{what} is in {reader.unit(value)}{rest.format(inside=inside, wanted=wanted)}."
        )
    return reader.excused


def unit_table(
    coordinate: Coordinate, others: Iterable[Parameter | Signal | State]
) -> dict[sympy.Symbol, Unit]:
    """Return the units of the motion and of further quantities, by symbol."""
    motion = (coordinate.symbol, coordinate.velocity, coordinate.acceleration)
    table = {
        symbol: parse_unit(coordinate.unit + over)
        for symbol, over in zip(motion, ("", "/s", "/s^2"), strict=True)
    }
    return {**table, **{each.symbol: parse_unit(each.unit) for each in others}}
