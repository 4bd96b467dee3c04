"""Coherent SI units as exponents of metre, kilogram, second, ampere and kelvin.

Inside the program every number is a plain SI float; a unit only labels it. The whitelist closes
the traps of general unit parsers: `Nm` is a newton metre, and an angle is in radians, which SI
counts as a number.
"""

import ast
import operator
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from axisid.support.errors import ModelError
from axisid.support.wording import quoted

_BASE = ("kg", "m", "s", "A", "K")
_Exponents = tuple[Fraction | int, ...]  # of `_BASE`

_SYMBOLS: dict[str, _Exponents] = {
    "1": (0, 0, 0, 0, 0),
    "rad": (0, 0, 0, 0, 0),
    "kg": (1, 0, 0, 0, 0),
    "m": (0, 1, 0, 0, 0),
    "s": (0, 0, 1, 0, 0),
    "A": (0, 0, 0, 1, 0),
    "N": (1, 1, -2, 0, 0),
    "Nm": (1, 2, -2, 0, 0),
    "J": (1, 2, -2, 0, 0),
    "W": (1, 2, -3, 0, 0),
    "V": (1, 2, -3, -1, 0),
    "K": (0, 0, 0, 0, 1),
    "Pa": (1, -1, -2, 0, 0),
}
_NONE: _Exponents = (0, 0, 0, 0, 0)
_LONGEST = 60
_JOINED = re.compile(r"(?<=[\w)])\s+(?=[\w(])|(?<=[\w)])(?=\()|(?<=\))(?=\w)")


@dataclass(frozen=True, slots=True)
class Unit:
    """A coherent SI unit.

    Attributes
    ----------
    text : str
        Unit as written by the user, or canonical for a derived unit: ``N/(m/s)``, ``1/kg``.
    exponents : tuple of int or Fraction
        Exponents of kilogram, metre, second, ampere, kelvin.
    """

    text: str
    exponents: _Exponents

    def __str__(self) -> str:
        return self.text

    def __mul__(self, other: "Unit") -> "Unit":
        return _canonical(_combine(self.exponents, other.exponents, 1))

    def __truediv__(self, other: "Unit") -> "Unit":
        return _canonical(_combine(self.exponents, other.exponents, -1))

    def __pow__(self, power: Fraction | int) -> "Unit":
        return self if power == 1 else _canonical(_combine(_NONE, self.exponents, power))

    def same_dimension(self, other: "Unit") -> bool:
        """Return whether both measure the same kind of quantity."""
        return self.exponents == other.exponents


def parse_unit(text: str) -> Unit:
    """Return the unit that a text such as ``kg``, ``N/(m/s)``, ``N m/rad`` or ``m/s^2`` names.

    Raises
    ------
    ModelError
        A symbol is not on the whitelist, or the text is not a product of powers.
    """
    if not isinstance(text, str) or not text.strip():
        raise ModelError(
            f"a unit is a text such as 'kg' or 'N/(m/s)', not {quoted(text)}.", code="units"
        )
    if len(text) > _LONGEST:
        raise ModelError(f"a unit has at most {_LONGEST} characters, not {len(text)}.")
    return Unit(" ".join(text.split()), _exponents(text))


def product_of_powers(powers: Iterable[tuple[str, int]]) -> Unit:
    """Return the product of powers of units, of which there is at least one.

    A single unit with the power 1 stays as written.
    """
    return reduce(operator.mul, (parse_unit(text) ** power for text, power in powers))


def angle_power(unit: Unit) -> Fraction | int:
    """Return the power of the radian in a unit as written.

    The exponents of the unit itself treat the radian as a number.
    """
    turned = {**_SYMBOLS, "rad": _SYMBOLS["K"]}
    return _exponents(unit.text, turned)[-1] - unit.exponents[-1]


def _exponents(text: str, symbols: Mapping[str, _Exponents] = _SYMBOLS) -> _Exponents:
    """Return the exponents of the base units in a text, a product of powers; a space multiplies."""
    marked = _JOINED.sub("*", text.strip()).replace("^", "**").replace("·", "*")

    def read(node: ast.AST) -> _Exponents:
        match node:
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return _combine(read(left), read(right), 1)
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return _combine(read(left), read(right), -1)
            case ast.BinOp(left=left, op=ast.Pow(), right=right) if power := _power(right):
                return _combine(_NONE, read(left), power)
        name = ast.unparse(node)
        if name not in symbols:
            raise _malformed(text, name)
        return symbols[name]

    try:
        tree = ast.parse(marked, mode="eval").body
    except (SyntaxError, ValueError) as error:
        raise _malformed(text, text) from error
    return read(tree)


def _power(node: ast.AST) -> Fraction | int:
    """Return a power that is a two-digit whole number or a fraction of one-digit ones; else 0."""
    written = ast.unparse(node)
    if re.fullmatch(r"-?\d{1,2}", written):
        return int(written)
    return Fraction(written.replace(" ", "")) if re.fullmatch(r"-?\d / [1-9]", written) else 0


def _combine(left: _Exponents, right: _Exponents, power: Fraction | int) -> _Exponents:
    """Return the exponents of the left unit times a power of the right unit."""
    return tuple(x + power * y for x, y in zip(left, right, strict=True))


def _canonical(exponents: _Exponents) -> Unit:
    """Return the unit of given exponents, with its text in base units."""

    def text(sign: int) -> str:
        return " ".join(
            base
            if abs(power) == 1
            else f"{base}^{power * sign}"
            if Fraction(power).denominator == 1
            else f"{base}^({power * sign})"
            for base, power in zip(_BASE, exponents, strict=True)
            if power * sign > 0
        )

    above, below = text(1) or "1", text(-1)
    if not below:
        return Unit(above, exponents)
    return Unit(f"{above}/({below})" if " " in below else f"{above}/{below}", exponents)


def _malformed(text: str, where: str) -> ModelError:
    """Return the error for a unit that cannot be read at a part of its text."""
    # Two symbols that were written as one, such as Ns; none where m may be a prefix.
    pairs = ((where[:k], where[k:]) for k in range(1, len(where)))
    known = (pair for pair in pairs if _SYMBOLS.keys() >= {*pair} and pair[0] not in ("1", "m"))
    apart = " ".join(next(known, ()))
    meant = f" Did you mean {text.replace(where, apart)!r}?" if apart else ""
    return ModelError(
        f"the unit {text!r} cannot be read at {where!r}. Write a product of powers of "
        f"{', '.join(sorted(_SYMBOLS))}, such as 'N/(m/s)' or 'kg m^2'.{meant}",
        code="units",
    )
