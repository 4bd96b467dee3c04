"""Write expressions in reading order: inertia first, then friction, loads, offsets.

SymPy sorts by the alphabet, which puts ``Fc sign(dq)`` before ``M ddq`` and ``dq`` before ``fv``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy
from sympy.printing.str import StrPrinter

from .constants import ConstantSymbol, replaced
from .symbols import (
    BALANCED,
    CONTROL,
    DIRECTION,
    FORCE,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    Coordinate,
)

_DIGITS = 10
_WHOLE = 1e7  # from this size, a whole decimal keeps its exponent
_NUMBER, _PARAMETER, _CONSTANT, _MOTION = "abcd"  # first letters of substitutes, in sorting order
_DIRECTION_RANK, _LAST_RANK = 5, 7  # ranks of terms, in the order of `readable`


@dataclass(frozen=True, slots=True)
class Readable:
    """An expression prepared for a printer of SymPy, with substitute symbols.

    Attributes
    ----------
    value : sympy.Expr
        The expression with substitutes for its symbols. SymPy sorts the substitutes in reading
        order: parameters before constants, constants before the motion.
    names : dict of sympy.Symbol to sympy.Expr
        The symbol that each substitute replaces.
    ranks : dict of sympy.Symbol to int
        Rank of each substitute that decides the order of the terms of a sum: the drive and the
        motion.
    velocity : sympy.Symbol or None
        Substitute of the velocity; None if the velocity does not occur.
    """

    value: sympy.Expr
    names: Mapping[sympy.Symbol, sympy.Expr]
    ranks: Mapping[sympy.Symbol, int]
    velocity: sympy.Symbol | None

    def terms(self, total: sympy.Expr) -> list[sympy.Expr]:
        """Return the terms of a sum in reading order.

        The order is drive, reference, acceleration, velocity, its sign, position, the rest. Among
        terms of the same rank, positive terms come first. If there is a positive term at all, the
        first positive term comes first in the sum.
        """
        terms = sorted(
            total.as_ordered_terms(),
            key=lambda term: (self._rank(term), term.could_extract_minus_sign()),
        )
        first = next((t for t in terms if not t.could_extract_minus_sign()), terms[0])
        return [first, *(t for t in terms if t is not first)]

    def _rank(self, term: sympy.Expr) -> int:
        """Return the rank of a term in the order of `terms`; terms of a low rank come first."""
        smooth = term
        if self.velocity is not None:
            jumps = sympy.sign(self.velocity), sympy.Heaviside(self.velocity)
            if term.has(*jumps):
                smooth = term.xreplace(dict.fromkeys(jumps, sympy.S.One))
                if self.velocity not in smooth.free_symbols:
                    return _DIRECTION_RANK
        last = _LAST_RANK + (not term.free_symbols)
        return min((self.ranks.get(s, last) for s in smooth.free_symbols), default=last)


def readable(value: sympy.Expr, coordinate: Coordinate) -> Readable:
    """Return an expression of an axis or its control law, prepared for a printer.

    Decimals are rounded to ten digits, which removes rounding errors.
    """
    q = coordinate
    motion = (REFERENCE, q.acceleration, q.velocity, DIRECTION, q.symbol)
    order = [FORCE, *motion, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD, CONTROL, BALANCED]
    # Terms with the drive come first, then terms with the motion, the highest derivative first.
    ranks = {s: rank for rank, s in enumerate((FORCE, CONTROL, *motion))}
    stand_ins: dict[sympy.Expr, sympy.Symbol] = {}
    for s in sorted(value.free_symbols | value.atoms(sympy.NumberSymbol), key=str):
        prefix = f"{_MOTION}{order.index(s)}" if s in order else _first_letter(s)
        # Numbered, because two constants may have the same name.
        stand_ins[s] = sympy.Symbol(f"{prefix} {s} {len(stand_ins)}", **s.assumptions0)
    decimals = {x: _rounded(x) for x in value.atoms(sympy.Float)}
    return Readable(
        value=replaced(value, {**decimals, **stand_ins}, evaluate=False),
        names={stand_in: s for s, stand_in in stand_ins.items()},
        ranks={stand_in: ranks[s] for s, stand_in in stand_ins.items() if s in ranks},
        velocity=stand_ins.get(q.velocity),
    )


def _first_letter(symbol: sympy.Expr) -> str:
    """Return the first letter of a substitute: that of a number, a parameter or a constant."""
    if isinstance(symbol, sympy.NumberSymbol):
        return _NUMBER
    return _CONSTANT if isinstance(symbol, ConstantSymbol) else _PARAMETER


def _rounded(decimal: sympy.Float) -> sympy.Expr:
    """Return a decimal rounded to ten digits; as an integer if it is whole and below 1e7."""
    short = float(f"{float(decimal):.{_DIGITS}g}")
    return (
        sympy.Integer(short) if short.is_integer() and abs(short) < _WHOLE else sympy.Float(short)
    )


class InReadingOrder:
    """Mixin for a printer of SymPy: sums in reading order, substitutes shown as their symbols.

    Parameters
    ----------
    prepared : Readable
        The expression to print.
    settings : mapping
        Settings of the printer.
    *further
        Further arguments of the printer.
    """

    def __init__(self, prepared: Readable, settings: Mapping[str, Any], *further: Any) -> None:
        """Store the prepared expression."""
        super().__init__(settings, *further)  # type: ignore[call-arg]
        self.prepared = prepared

    def _as_ordered_terms(self, expr: sympy.Expr, order: Any = None) -> list[sympy.Expr]:  # noqa: ARG002
        """Return the terms of a sum in reading order."""
        return self.prepared.terms(expr)

    def _print_Symbol(self, expr: sympy.Symbol, *style: Any) -> Any:  # noqa: N802
        """Return the text of the symbol that a substitute replaces."""
        shown = self.prepared.names.get(expr, expr)
        if shown is not expr:
            return self._print(shown)  # type: ignore[attr-defined]
        return super()._print_Symbol(expr, *style)  # type: ignore[misc]


class _TextPrinter(InReadingOrder, StrPrinter):  # type: ignore[misc]
    """Printer of plain text in reading order."""


def written(value: sympy.Expr, coordinate: Coordinate) -> str:
    """Return an expression of an axis as text, in reading order."""
    prepared = readable(value, coordinate)
    return str(_TextPrinter(prepared, {"full_prec": False}).doprint(prepared.value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Formula:
    """A formula ``name = value [unit]: column``; empty parts are omitted.

    Attributes
    ----------
    name : sympy.Expr or str
        The quantity that is defined.
    value : sympy.Expr or None
        Value of the quantity; None if only the column is shown.
    unit : str
        Unit of the quantity; empty if it is not shown.
    column : sympy.Expr or None
        Factor of the quantity in a regressor; None if it has no column.
    """

    name: sympy.Expr | str
    value: sympy.Expr | None = None
    unit: str = ""
    column: sympy.Expr | None = None

    def head(self, coordinate: Coordinate) -> str:
        """Return ``name = value`` as text."""
        value = "" if self.value is None else f" = {written(self.value, coordinate)}"
        name = self.name if isinstance(self.name, str) else written(self.name, coordinate)
        return f"{name}{value}"

    def text(self, coordinate: Coordinate) -> str:
        """Return ``name = value [unit]: column`` as text."""
        unit = f" [{self.unit}]" if self.unit else ""
        column = "" if self.column is None else f": {written(self.column, coordinate)}"
        return f"{self.head(coordinate)}{unit}{column}"
