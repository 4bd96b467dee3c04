"""Plain text as it is printed: powers raised, true minus signs, numbers without an ``e``."""

import math
import re

_MINUS, _TIMES, _THIN = "\u2212", "\u00d7", "\u202f"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = (1e-3, 1e6)  # between them numbers have no power of ten
_GROUPED = 1e4  # from which thousands stand apart
# A sign or a figure that is part of a word, a name or a formula stays as it is.
_NUMBER = re.compile(r"(?<![\w.^*/)+-])([+-]?)(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w^*]|\.\w)")


def readable_unit(unit: str) -> str:
    """A unit with its powers raised: ``m/s²``."""
    return re.sub(r"(?:\^|\*\*)(-?\d+)", lambda m: m[1].translate(_RAISED), unit)


def readable_text(text: str) -> str:
    """A sentence as it is printed: ``1.2e-06 kg m^2`` gets a true power of ten."""
    numbered = _NUMBER.sub(_number, text.replace(" +-", " ±"))
    return re.sub(r"(?<=[^\W\d_])\^(-?\d+)(?![\w.])", lambda m: m[1].translate(_RAISED), numbered)


def decimals(deviation: float, digits: int = 2, least: int = 0) -> int:
    """Decimal places of a value that show so many digits of its deviation; 4 without one."""
    if not 0 < deviation < math.inf:
        return 4
    return min(max(least, digits - 1 - math.floor(math.log10(deviation))), 12)


def figure_text(value: float, digits: int = 3) -> str:
    """A number of a column to so many digits; a large one is written out, as the others are."""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < _PLAIN[1] else text


def _number(found: re.Match[str]) -> str:
    sign, figures, exponent = found.groups()
    sign = sign.replace("-", _MINUS)
    if exponent is None:
        return sign + figures
    value = float(f"{figures}e{exponent}")
    if value and not _PLAIN[0] <= value < _PLAIN[1]:
        return f"{sign}{figures} {_TIMES} 10{str(int(exponent)).translate(_RAISED)}"
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    plain = f"{value:,.{places}f}" if value >= _GROUPED else f"{value:.{places}f}"
    return sign + plain.replace(",", _THIN)
