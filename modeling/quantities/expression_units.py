"""Find the units of expressions from the units of their symbols.

A plain number has no unit. In a function of parameters it is dimensionless. In an equation of
motion it may stand for a quantity with a unit (``9.81 * m``, an arm of 0.25). There, a mismatch of
units that a plain number could explain is *excused*: it is recorded and reported. The numbers that
come from energies and their derivatives (1, 2, 1/2 and their negatives, however written) excuse
nothing in a term with parameters or constants, because they would hide wrong units.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from operator import mul

import sympy
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from .constants import ConstantSymbol
from .units import Unit, parse_unit

NUMBER = parse_unit("1")

_ROOT, _NEAR = 12, 1e-9  # largest denominator of a power of a unit, and its rounding error
_PURE = (0.5, 1.0, 2.0)
_JUMPS = (sympy.sign, sympy.Heaviside)
_OF_NUMBERS = (
    sympy.exp,
    sympy.log,
    sympy.sin,
    sympy.cos,
    sympy.tan,
    sympy.asin,
    sympy.acos,
    sympy.atan,
    sympy.sinh,
    sympy.cosh,
    sympy.tanh,
)


class UnitsError(ValueError):
    """Error for units that do not fit; callers add the name of the expression to the message."""


@dataclass(frozen=True, slots=True)
class _ExpressionUnit:
    """The unit of an expression.

    Attributes
    ----------
    unit : Unit
    loose : bool
        Whether a plain number in the expression may stand for a quantity with a further unit.
    """

    unit: Unit
    loose: bool = False


class UnitReader:
    """Reader of the units of expressions.

    Parameters
    ----------
    units : mapping of sympy.Symbol to Unit
        Units of the symbols.
    loose_numbers : bool
        Whether a plain number may stand for a quantity with a unit.
    of_numbers : bool
        Whether the expression has no parameters and constants. Then only plain numbers can carry
        its unit, and 1, 2 and 1/2 may do so too.

    Attributes
    ----------
    excused : list of Unit
        Units that plain numbers must have, where the units would not fit otherwise.
    """

    def __init__(
        self,
        units: Mapping[sympy.Symbol, Unit],
        *,
        loose_numbers: bool = False,
        of_numbers: bool = False,
    ) -> None:
        self._units = units
        self._loose_numbers = loose_numbers
        self._pure = _is_sign if of_numbers else _is_pure
        self.excused: list[Unit] = []

    def unit(self, expression: sympy.Expr) -> Unit:
        """Return the unit of an expression; ``1`` if it has no unit.

        Raises
        ------
        UnitsError
            Units within the expression do not fit.
        """
        return self._read(expression).unit

    def fits(self, expression: sympy.Expr, wanted: Unit) -> bool:
        """Return whether an expression has the wanted unit, or can have it by a plain number.

        Raises
        ------
        UnitsError
            Units within the expression do not fit.
        """
        if expression.is_number:  # a number alone may have any unit, also if it is 1, 2 or 1/2
            return self._is(_ExpressionUnit(NUMBER, self._loose_numbers), wanted)
        return self._is(self._read(expression), wanted)

    def _is(self, read: _ExpressionUnit, wanted: Unit) -> bool:
        """Return whether a unit is the wanted unit, or a plain number may have the missing unit.

        In the second case the missing unit is added to `excused`.
        """
        if read.unit.same_dimension(wanted):
            return True
        if read.loose:
            self.excused.append(wanted / read.unit)
        return read.loose

    def _read(self, node: sympy.Basic) -> _ExpressionUnit:
        """Return the unit of a node of an expression."""
        if isinstance(node, ConstantSymbol):
            return _ExpressionUnit(node.unit)
        if node.is_Symbol:
            return _ExpressionUnit(self._units[node])
        if node.is_number:
            return _ExpressionUnit(NUMBER, self._loose_numbers and not self._pure(node))
        if node.is_Mul:
            return self._product([self._read(factor) for factor in node.args])
        if node.is_Pow:
            return self._power(node)
        if node.is_Add or isinstance(node, (Max, Min)):
            return self._common(node, node.args, "adds" if node.is_Add else "compares")
        return self._applied(node)

    def _product(self, parts: list[_ExpressionUnit]) -> _ExpressionUnit:
        """Return the unit of a product; a single unit stays as it was written."""
        units = [p.unit for p in parts if not p.unit.same_dimension(NUMBER)]
        return _ExpressionUnit(reduce(mul, units or [NUMBER]), any(p.loose for p in parts))

    def _common(
        self, node: sympy.Basic, parts: Iterable[sympy.Basic], does: str
    ) -> _ExpressionUnit:
        """Return the unit that all terms of a sum or a comparison have.

        A plain number, such as a rest length, may stand for any unit.

        Parameters
        ----------
        node : sympy.Basic
        parts : iterable of sympy.Basic
            The terms.
        does : str
            Verb for the message: ``adds``, ``compares``.
        """
        reads = [
            _ExpressionUnit(NUMBER, self._loose_numbers) if part.is_Number else self._read(part)
            for part in parts
            if part != 0
        ]
        # Compare all parts with one of them: preferably not loose, and with a unit.
        first = min(reads, key=lambda read: (read.loose, read.unit.same_dimension(NUMBER)))
        for read in reads:
            if not self._is(read, first.unit):
                raise UnitsError(
                    f"{node} {does} {first.unit} and {read.unit}. Give both the same unit."
                )
        return first

    def _power(self, node: sympy.Pow) -> _ExpressionUnit:
        """Return the unit of a power, whose exponent must be a number.

        If the base has a unit, the exponent must be a simple fraction.
        """
        base, power = self._read(node.base), self._read(node.exp)
        if not self._is(power, NUMBER):
            raise UnitsError(
                f"the power in {node} is in {power.unit}. Give a power without a unit."
            )
        if base.unit.same_dimension(NUMBER):
            return base
        exponent = float(node.exp) if node.exp.is_Number else math.nan
        fraction = Fraction(exponent if math.isfinite(exponent) else 0).limit_denominator(_ROOT)
        if abs(float(fraction) - exponent) <= _NEAR:
            return _ExpressionUnit(base.unit**fraction, base.loose)
        if self._is(base, NUMBER):
            return _ExpressionUnit(NUMBER, loose=True)
        raise UnitsError(
            f"{node} has no unit: {base.unit} is raised to a power that is not a fraction with a "
            f"denominator up to {_ROOT}. Give such a fraction."
        )

    def _applied(self, node: sympy.Basic) -> _ExpressionUnit:
        """Return the unit of a function, and check the units of its arguments."""
        if isinstance(node, sympy.Abs):
            return self._read(node.args[0])
        if isinstance(node, _JUMPS):
            self._read(node.args[0])
            return _ExpressionUnit(NUMBER)
        if isinstance(node, sympy.atan2):
            self._common(node, node.args, "compares")
            return _ExpressionUnit(NUMBER)
        if isinstance(node, sympy.Piecewise):
            for relation in node.atoms(Relational):
                self._common(relation, relation.args, "compares")
            return self._common(node, [pair.args[0] for pair in node.args], "chooses from")
        if self._loose_numbers and not isinstance(node, _OF_NUMBERS):
            return _ExpressionUnit(NUMBER, loose=True)  # an unknown function, refused elsewhere
        argument = self._read(node.args[0])
        if not self._is(argument, NUMBER):
            raise UnitsError(
                f"{node} takes a number, not {argument.unit}. Divide the argument by a quantity in "
                f"{argument.unit}."
            )
        return _ExpressionUnit(NUMBER)


def _is_sign(number: sympy.Expr) -> bool:
    """Return whether a number is the integer 1 or -1, which SymPy uses as the sign of a term."""
    return number in (sympy.S.One, sympy.S.NegativeOne) and number.is_Integer


def _is_pure(number: sympy.Expr) -> bool:
    """Return whether a number is dimensionless: a factor of an energy, or a constant such as pi.

    The factors are compared as floats: ``0.5`` becomes ``1.0``, and not the integer 1, if a square
    is differentiated.
    """
    if number.is_Number:
        return abs(float(number)) in _PURE
    return not number.atoms(sympy.Number)
