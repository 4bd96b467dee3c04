"""Coherent SI units as exponents of metre, kilogram, second, ampere and kelvin.

Inside the program every number is a plain SI float; a unit only labels it. Only listed symbols are
accepted, which avoids the ambiguities of general unit parsers: `Nm` is a newton metre, and an angle
is in radians, which SI counts as a number.
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
_Exponents = tuple[Fraction | int, ...]  # one for each unit of `_BASE`

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
# A space or a parenthesis that multiplies.
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
        """Return whether another unit has the same exponents, and so measures the same quantity."""
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
            f"the unit is {quoted(text)}. Give a text such as 'kg' or 'N/(m/s)'.", code="units"
        )
    if len(text) > _LONGEST:
        raise ModelError(
            f"the unit has {len(text)} characters. Write at most {_LONGEST} characters."
        )
    return Unit(" ".join(text.split()), _exponents(text))


def product_of_powers(powers: Iterable[tuple[str, int]]) -> Unit:
    """Return the product of powers of units; a single unit with the power 1 stays as written.

    Parameters
    ----------
    powers : iterable of (str, int)
        Each unit as text with its power; at least one.
    """
    return reduce(operator.mul, (parse_unit(text) ** power for text, power in powers))


def angle_power(unit: Unit) -> Fraction | int:
    """Return the power of the radian in a unit as written: 1 for ``rad/s``.

    The exponents of a unit do not contain it, because SI counts the radian as a number.
    """
    # Count the radian as a kelvin, and subtract the kelvins of the unit.
    with_angles = {**_SYMBOLS, "rad": _SYMBOLS["K"]}
    return _exponents(unit.text, with_angles)[-1] - unit.exponents[-1]


def _exponents(text: str, symbols: Mapping[str, _Exponents] = _SYMBOLS) -> _Exponents:
    """Return the exponents of the base units in a text, which is a product of powers of symbols.

    A space multiplies. The text is read as a Python expression, node by node.
    """
    marked = _JOINED.sub("*", text.strip()).replace("^", "**").replace("·", "*")

    def read(node: ast.AST) -> _Exponents:
        """Return the exponents of a product, a quotient, a power or a symbol."""
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
    """Return a power: a whole number of up to two digits, or a fraction of one-digit numbers.

    It is 0 for any other text.
    """
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
        """Return the product of the base units whose exponents have the given sign."""
        factors = []
        for base, exponent in zip(_BASE, exponents, strict=True):
            power = exponent * sign
            if power == 1:
                factors.append(base)
            elif power > 0 and Fraction(power).denominator == 1:
                factors.append(f"{base}^{power}")
            elif power > 0:
                factors.append(f"{base}^({power})")
        return " ".join(factors)

    above, below = text(1) or "1", text(-1)
    if not below:
        return Unit(above, exponents)
    return Unit(f"{above}/({below})" if " " in below else f"{above}/{below}", exponents)


def _malformed(text: str, where: str) -> ModelError:
    """Return the error for a unit that cannot be read.

    Parameters
    ----------
    text : str
        The whole unit.
    where : str
        The part of the text that cannot be read.
    """
    # Suggest two symbols that were written as one, such as Ns; not if m may be the prefix milli.
    pairs = ((where[:k], where[k:]) for k in range(1, len(where)))
    known = (pair for pair in pairs if _SYMBOLS.keys() >= {*pair} and pair[0] not in ("1", "m"))
    separated = " ".join(next(known, ()))
    meant = f" Did you mean {text.replace(where, separated)!r}?" if separated else ""
    return ModelError(
        f"the unit {text!r} cannot be read at {where!r}. Write a product of powers of "
        f"{', '.join(sorted(_SYMBOLS))}, such as 'N/(m/s)' or 'kg m^2'.{meant}",
        code="units",
    )
