"""Wording of values in messages: numbers, ranges, quoted values and lists of names.

This module is imported without NumPy.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import is_dataclass
from typing import TypeVar

Chosen = TypeVar("Chosen")

#: Number of a thousand or more in exponent form, ``1e+03``, except in a word, a name or a formula.
_RAISED = re.compile(r"""(?<![\w.^*/)'"+-])([+-]?)(\d(?:\.\d+)?)e\+0([1-5])(?![\w^*/'"]|\.\w)""")
_PLAIN = 1e5  # largest number that is written out in a sentence


def range_text(low: float, high: float, between: str = " .. ", *, digits: int = 4) -> str:
    """Return two bounds with enough digits to differ: ``10.98 .. 11.04``, never ``11 .. 11``.

    Parameters
    ----------
    low, high : float
    between : str
        Text between the bounds.
    digits : int
        Least number of significant digits.
    """
    width, most = abs(high - low), max(abs(low), abs(high))
    if 0 < width < math.inf:
        needed = math.floor(math.log10(most)) - math.floor(math.log10(width)) + 2
        digits = max(digits, min(needed, 15))
    return f"{low:.{digits}g}{between}{high:.{digits}g}"


def or_dash(value: float | None, form: str) -> str:
    """Return a number in a format, such as ``.4g``; a dash for None."""
    return "-" if value is None else format(value, form)


def plain_numbers(text: str) -> str:
    """Return a sentence with numbers up to 1e5 written out: ``100 N``, never ``1e+02 N``."""
    return _RAISED.sub(_written_out, text) if "e+0" in text else text


def _written_out(found: re.Match[str]) -> str:
    """Return a match of `_RAISED` without exponent if its size is 1e5 at most, else unchanged."""
    sign, figures, exponent = found.groups()
    value = float(f"{figures}e{exponent}")
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    return f"{sign}{value:.{places}f}" if value <= _PLAIN else found[0]


_SHORT = 60  # characters of the longest repr that is shown
_DIGITS_OF_A_BIT = 0.30103


def quoted(value: object) -> str:
    """Return the repr of a value, or ``a TYPE`` if the value is a dataclass or its repr is long.

    A long whole number is named by its number of digits.
    """
    if isinstance(value, int) and value.bit_length() * _DIGITS_OF_A_BIT > _SHORT:
        # Python refuses to write numbers of some thousand digits.
        return f"a whole number of {value.bit_length() * _DIGITS_OF_A_BIT:.0f} digits"
    # The repr of a dataclass is too long to be part of a sentence.
    written = "" if is_dataclass(value) else repr(value)
    if written and len(written) <= _SHORT and "\n" not in written:
        return written
    kind = type(value).__name__
    return f"{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"


def first_of(names: Sequence[str], most: int = 3) -> str:
    """Return the first `most` names as ``a, b, c``, followed by the number of further names."""
    left = len(names) - most
    more = f" and {left} more" if left > 0 else ""
    return ", ".join(names[:most]) + more


def listed(names: Sequence[str]) -> str:
    """Return all names as a list in a sentence: ``a, b and c``; empty without names."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def first_case(*cases: tuple[object, Chosen]) -> Chosen:
    """Return the value of the first case whose condition is true.

    Parameters
    ----------
    *cases : (object, value)
        Condition and value; at least one condition is true. A case that is the cause of another
        case comes before it.
    """
    return next(value for is_true, value in cases if is_true)
