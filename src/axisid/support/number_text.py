"""Numbers as text, to the digits that they need."""

import math


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
