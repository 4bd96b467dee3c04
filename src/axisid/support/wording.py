"""Wording of values in messages: numbers, bounds, quoted values and lists of names.

This module is imported without NumPy.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import is_dataclass
from typing import TypeVar

Chosen = TypeVar("Chosen")

#: Of a thousand and more to few digits; what is part of a word, a name or a formula stays.
_RAISED = re.compile(r"""(?<![\w.^*/)'"+-])([+-]?)(\d(?:\.\d+)?)e\+0([1-5])(?![\w^*/'"]|\.\w)""")
_PLAIN = 1e5  # up to which numbers of a sentence are written out


def range_text(low: float, high: float, between: str = " .. ", *, digits: int = 4) -> str:
    """Return two bounds with enough digits to differ: ``10.98 .. 11.04``, never ``11 .. 11``.

    Parameters
    ----------
    low, high : float
    between : str
        Text between the bounds.
    digits : int
        Number of significant digits, if these are enough.
    """
    width, most = abs(high - low), max(abs(low), abs(high))
    if 0 < width < math.inf:
        digits = max(
            digits, min(math.floor(math.log10(most)) - math.floor(math.log10(width)) + 2, 15)
        )
    return f"{low:.{digits}g}{between}{high:.{digits}g}"


def or_dash(value: float | None, form: str) -> str:
    """Return a number in a format, such as ``.4g``; a dash for None."""
    return "-" if value is None else format(value, form)


def plain_numbers(text: str) -> str:
    """Return a sentence with numbers up to 1e5 written out: ``100 N``, never ``1e+02 N``."""
    return _RAISED.sub(_written_out, text) if "e+0" in text else text


def _written_out(found: re.Match[str]) -> str:
    """Return a number with an exponent written out, if it is 1e5 at most."""
    sign, figures, exponent = found.groups()
    value = float(f"{figures}e{exponent}")
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    return f"{sign}{value:.{places}f}" if value <= _PLAIN else found[0]


_SHORT = 60  # letters of a value that is shown as it is
_DIGITS_OF_A_BIT = 0.30103


def quoted(value: object) -> str:
    """Return the repr of a value; its type if the repr is long or the value is a dataclass."""
    if isinstance(value, int) and value.bit_length() * _DIGITS_OF_A_BIT > _SHORT:
        # Python refuses to write numbers of some thousand digits.
        return f"a whole number of {value.bit_length() * _DIGITS_OF_A_BIT:.0f} digits"
    # What a dataclass says of itself reads as a sentence within another.
    written = "" if is_dataclass(value) else repr(value)
    if written and len(written) <= _SHORT and "\n" not in written:
        return written
    kind = type(value).__name__
    return f"{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"


def first_of(names: Sequence[str], most: int = 3) -> str:
    """Return the first names as a list in text, and the number of further ones."""
    left = len(names) - most
    return ", ".join(names[:most]) + (f" and {left} more" if left > 0 else "")


def first_case(*cases: tuple[object, Chosen]) -> Chosen:
    """Return the value of the first case whose condition is true.

    Cases that cause others are given first.
    """
    return next(said for holds, said in cases if holds)
