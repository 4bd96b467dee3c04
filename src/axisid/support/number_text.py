"""Numbers as text, to the digits that they need."""

import math
import re

#: Of a thousand and more to few digits; what is part of a word, a name or a formula stays.
_RAISED = re.compile(r"""(?<![\w.^*/)'"+-])([+-]?)(\d(?:\.\d+)?)e\+0([1-5])(?![\w^*/'"]|\.\w)""")
_PLAIN = 1e5  # up to which numbers of a sentence are written out


def range_text(low: float, high: float, between: str = " .. ", *, digits: int = 4) -> str:
    """Two bounds, to as many digits as tell them apart: ``10.98 .. 11.04``, never ``11 .. 11``.

    Parameters
    ----------
    low, high : float
    between : str
        What stands between them.
    digits : int
        Significant ones, if that is enough.
    """
    width, most = abs(high - low), max(abs(low), abs(high))
    if 0 < width < math.inf:
        digits = max(
            digits, min(math.floor(math.log10(most)) - math.floor(math.log10(width)) + 2, 15)
        )
    return f"{low:.{digits}g}{between}{high:.{digits}g}"


def or_dash(value: float | None, form: str) -> str:
    """A number in a format, such as ``.4g``; a dash where there is none."""
    return "-" if value is None else format(value, form)


def plain_numbers(text: str) -> str:
    """A sentence whose numbers up to 1e5 are written out: ``100 N``, never ``1e+02 N``."""
    return _RAISED.sub(_written_out, text) if "e+0" in text else text


def _written_out(found: re.Match[str]) -> str:
    sign, figures, exponent = found.groups()
    value = float(f"{figures}e{exponent}")
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    return f"{sign}{value:.{places}f}" if value <= _PLAIN else found[0]
