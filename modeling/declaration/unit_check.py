"""The equation of motion in its units: every term is a force, or a torque."""

from collections.abc import Iterable

import sympy

from axisid.modeling.quantities import (
    NUMBER,
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
    parameters: Iterable[Parameter],
    signals: Iterable[Signal | State],
) -> tuple[str, ...]:
    """Check the unit of every term, and return the terms that could not be checked.

    Symbols, constants, functions and factors 1, 2 and 1/2 are held to their units. A term with
    another plain number in it passes if it fits with that as a pure number; if not, the number may
    stand for something with a unit, and the term is returned with the unit that this must be. In a
    known load, a term without parameters and constants, any number may.

    Raises
    ------
    ModelError
        A term has another unit than the drive's; the term and both units are named.
    """
    parameters = tuple(parameters)
    units = unit_table(coordinate, (*parameters, *signals))
    unknown = {p.symbol for p in parameters}
    unchecked = []
    for term in sympy.Add.make_args(force):
        load = not term.free_symbols & unknown and not term.atoms(ConstantSymbol)
        reader = UnitReader(units, loose_numbers=True, of_numbers=load)
        try:
            fits = term == 0 or reader.fits(term, coordinate.force_unit)
        except UnitsError as error:
            raise ModelError(f"the units in the term {term} do not fit: {error}") from error
        if not fits:
            raise _wrong(term, reader.unit(term), coordinate, units)
        if reader.excused:
            carried = ", ".join(dict.fromkeys(map(str, reader.excused)))
            unchecked.append(f"{term} (right if its plain numbers stand for {carried})")
    return tuple(unchecked)


def check_profile(
    profile: sympy.Expr,
    coordinate: Coordinate,
    symbols: Iterable[Parameter | Signal],
    what: str = "profile",
    of: str = "the force over its nominal value",
) -> None:
    """Refuse a force profile, or what the gain is scaled by, that is not a number.

    Raises
    ------
    ModelError
        It has a unit.
    """
    reader = UnitReader(unit_table(coordinate, symbols), loose_numbers=True)
    try:
        fits = reader.fits(profile, NUMBER)
    except UnitsError as error:
        raise ModelError(f"the units in the drive's {what} do not fit: {error}") from error
    if not fits:
        raise ModelError(
            f"the drive's {what} {profile} is in {reader.unit(profile)}; give {of}, a number."
        )


def check_state_parts(
    states: Iterable[State], coordinate: Coordinate, parameters: Iterable[Parameter]
) -> None:
    """Refuse what a ready state is declared by and is not in the unit of its place.

    Raises
    ------
    ModelError
        One is not; it is named as it was declared, with both units.
    """
    table = unit_table(coordinate, parameters)
    for part in (part for state in states for part in state.parts):
        reader = UnitReader(table, loose_numbers=True)
        try:
            fits = part.value == 0 or reader.fits(part.value, parse_unit(part.unit))
        except UnitsError as error:
            raise ModelError(
                f"the units in {part.what}, {part.value}, do not fit: {error}"
            ) from error
        if not fits:
            raise ModelError(
                f"{part.what}, {part.value}, is in {reader.unit(part.value)}; give {part.unit}."
            )


def check_states(
    states: Iterable[State], coordinate: Coordinate, parameters: Iterable[Parameter]
) -> None:
    """Refuse a state whose rate, limit or start is not in its unit.

    Raises
    ------
    ModelError
        One is not; both units are named.
    """
    states = tuple(states)
    table = unit_table(coordinate, (*parameters, *states)) if states else {}
    table |= {state.own: parse_unit(state.unit) for state in states}
    for state in states:
        unit = parse_unit(state.unit)
        rate, *others = state.values
        for value, wanted in ((rate, unit / parse_unit("s")), *((v, unit) for v in others)):
            reader = UnitReader(table, loose_numbers=True)
            try:
                fits = value == 0 or reader.fits(value, wanted)
            except UnitsError as error:
                raise ModelError(f"the units in the state {state.name} do not fit: {error}") from (
                    error
                )
            if not fits:
                raise ModelError(
                    f"the state {state.name} is in {unit}, and {value} of it is in "
                    f"{reader.unit(value)}; give {wanted}."
                )


def unit_table(
    coordinate: Coordinate, others: Iterable[Parameter | Signal | State]
) -> dict[sympy.Symbol, Unit]:
    """Units of all symbols of an equation of motion."""
    motion = (coordinate.symbol, coordinate.velocity, coordinate.acceleration)
    table = {
        symbol: parse_unit(coordinate.unit + over)
        for symbol, over in zip(motion, ("", "/s", "/s^2"), strict=True)
    }
    return {**table, **{each.symbol: parse_unit(each.unit) for each in others}}


def _wrong(
    term: sympy.Expr, unit: Unit, coordinate: Coordinate, units: dict[sympy.Symbol, Unit]
) -> ModelError:
    table = {str(s): u for s, u in units.items() if s in term.free_symbols}
    table |= {s.name: s.unit for s in term.atoms(ConstantSymbol)}
    inside = ", ".join(f"{name} in {table[name]}" for name in sorted(table))
    kind = "linear" if coordinate.unit == "m" else "rotary"
    return ModelError(
        f"the term {term} is in {unit} ({inside}), but the drive of a {kind} axis gives "
        f"{coordinate.force_unit}, as every term must. Correct a unit or the term."
    )
