"""Units as logs write them: a whitelist, its factors to SI, and names with a unit.

Inside the program every number is SI; this is the edge. `nm` is a nanometre and `Nm` a newton
metre; what is not on the list is refused, not guessed.
"""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from axisid.modeling.quantities import Unit, parse_unit
from axisid.support.errors import ModelError

from .table import numbered

#: Of an archive of NumPy's arrays: units by name, as JSON.
UNITS_ENTRY = "axisid.units"

_TURN = 2 * math.pi
_DEGREE = math.pi / 180
_LARGEST_POWER = 10**12  # of ten, below a factor that is a decimal number
_MOST_PARTS = 1_000_000  # of a turn or of a minute


#: Factor to SI, and the coherent unit, by symbol.
_FACTORS: Mapping[str, tuple[float, str]] = {
    **{
        s: (f, "s") for s, f in (("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))
    },
    **{s: (f, "s") for s, f in (("min", 60.0), ("h", 3600.0))},
    **{
        s: (f, "m") for s, f in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9))
    },
    **{s: (f, "m") for s, f in (("inch", 0.0254), ("km", 1e3))},
    **{s: (f, "rad") for s, f in (("rad", 1.0), ("mrad", 1e-3), ("urad", 1e-6))},
    **{s: (f * _DEGREE, "rad") for s, f in (("deg", 1.0), ("mdeg", 1e-3), ("°", 1.0))},
    **{s: (f * _DEGREE, "rad") for s, f in (("arcmin", 1 / 60), ("arcsec", 1 / 3600))},
    **dict.fromkeys(("rev", "turn", "turns"), (_TURN, "rad")),
    **{s: (f, "N") for s, f in (("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("daN", 10.0))},
    **{s: (f, "N m") for s, f in (("Nm", 1.0), ("mNm", 1e-3), ("Ncm", 1e-2), ("kNm", 1e3))},
    **{s: (f, "N m") for s, f in (("Nmm", 1e-3), ("uNm", 1e-6))},
    **{s: (f, "A") for s, f in (("A", 1.0), ("mA", 1e-3), ("uA", 1e-6), ("kA", 1e3))},
    **{s: (f, "V") for s, f in (("V", 1.0), ("mV", 1e-3), ("uV", 1e-6), ("kV", 1e3))},
    **{s: (f, "m/s") for s, f in (("mm/s", 1e-3), ("m/min", 1 / 60), ("mm/min", 1e-3 / 60))},
    **{s: (f, "m/s") for s, f in (("cm/s", 1e-2), ("um/s", 1e-6))},
    **{s: (f * _DEGREE, "rad/s") for s, f in (("deg/s", 1.0), ("°/s", 1.0))},
    **{s: (f, "rad/s") for s, f in (("rpm", _TURN / 60), ("rev/s", _TURN), ("1/min", _TURN / 60))},
    **{s: (f, "rad/s") for s, f in (("mrad/s", 1e-3), ("krpm", 1e3 * _TURN / 60))},
    **{s: (f, "m/s^2") for s, f in (("mm/s^2", 1e-3), ("cm/s^2", 1e-2), ("g", 9.80665))},
    **{s: (f * _DEGREE, "rad/s^2") for s, f in (("deg/s^2", 1.0), ("°/s^2", 1.0))},
    **{s: (f, "rad/s^2") for s, f in (("mrad/s^2", 1e-3), ("rev/s^2", _TURN))},
    **{s: (f, "Pa") for s, f in (("Pa", 1.0), ("hPa", 1e2), ("kPa", 1e3), ("MPa", 1e6))},
    **{s: (f, "Pa") for s, f in (("mbar", 1e2), ("bar", 1e5), ("psi", 6894.757293))},
    "%": (1e-2, "1"),
}


_SPELT = {"\u00b5": "u", "\u03bc": "u", "\u00ba": "\u00b0", "\u00b7": " ", "\u00b2": "^2"}


_NAMES = {
    "meter": "m",
    "metre": "m",
    "meters": "m",
    "metres": "m",
    "millimeter": "mm",
    "millimeters": "mm",
    "millimetre": "mm",
    "millimetres": "mm",
    "micrometer": "um",
    "micrometre": "um",
    "micron": "um",
    "microns": "um",
    "degree": "deg",
    "degrees": "deg",
    "radian": "rad",
    "radians": "rad",
    "second": "s",
    "seconds": "s",
    "milliseconds": "ms",
    "volt": "V",
    "volts": "V",
    "amp": "A",
    "amps": "A",
    "ampere": "A",
    "amperes": "A",
    "newton": "N",
    "newtons": "N",
    "N m": "Nm",
    "mN m": "mNm",
    "N cm": "Ncm",
    "N mm": "Nmm",
    "kN m": "kNm",
    "r/min": "rpm",
    "U/min": "rpm",
    "rev/min": "rpm",
    **{
        f"{length}/s2": f"{length}/s^2" for length in ("m", "mm", "cm", "rad", "mrad", "deg", "rev")
    },
}


#: What encoders count; no unit until it is scaled.
COUNTS = frozenset(
    "count counts ct cts digit digits inc incr increment increments ink inkremente lsb pulse "
    "pulses step steps tick ticks".split()
)


_NO_UNIT = frozenset(("-", "--", "none"))


def label_unit(text: str) -> tuple[float, Unit] | None:
    """Factor to SI and coherent unit of a text such as ``mm`` or ``N m``; None if unknown."""
    plain = text.strip()
    for letter, other in _SPELT.items():
        plain = plain.replace(letter, other)
    if "**" not in plain:
        plain = plain.replace("*", " ")
    plain = _NAMES.get(plain, _NAMES.get(plain.lower(), plain))
    if plain in _FACTORS:
        factor, coherent = _FACTORS[plain]
        return factor, parse_unit(coherent)
    try:
        return 1.0, parse_unit(plain)
    except ModelError:
        return None


class ExactUnit(NamedTuple):
    """A unit's factor to SI, a fraction times a power of pi, and its coherent unit."""

    factor: Fraction
    turns: int
    unit: Unit


def exact_unit(text: str) -> ExactUnit | None:
    """What `label_unit` gives, before it is rounded."""
    found = label_unit(text)
    if found is None:
        return None
    factor, unit = found
    decimal = Fraction(repr(factor))
    if _LARGEST_POWER % decimal.denominator == 0:
        return ExactUnit(decimal, 0, unit)
    for turns in (1, 0):  # parts of a turn, and of a minute
        part = Fraction(factor / math.pi**turns).limit_denominator(_MOST_PARTS)
        if math.isclose(float(part) * math.pi**turns, factor, rel_tol=1e-15):
            return ExactUnit(part, turns, unit)
    return ExactUnit(Fraction(factor), 0, unit)


def is_unit(text: str) -> bool:
    """Whether a text is surely a unit: one that is known, or what encoders count."""
    return label_unit(text) is not None or text.strip().lower() in COUNTS


LABEL_WITH_UNIT = re.compile(r"(.+?)(\s*)(?:\[([^\[\]]+)\]|\(([^()]+)\)|/\s*([^\s/]+))")


def split_label(label: str) -> tuple[str, str]:
    """Name and unit of a header such as ``position [mm]`` or ``vel (rad/s)``; no unit, no cut.

    What stands in square brackets is a unit, known or not, unless it is a number (``q[1]``).
    In parentheses or after a slash it is one if it is known, or if encoders count in it.
    """
    match = LABEL_WITH_UNIT.fullmatch(label)
    if match is None:
        return label, ""
    name, blank, square, round_, below = match.groups()
    unit = (square or round_ or below).strip()
    sure = (square is not None or is_unit(unit)) and not unit.isdecimal()
    if below is not None and not blank:  # `axis/s` may be a path
        sure = False
    if not sure:
        return label, ""
    return name, "" if unit.lower() in _NO_UNIT else unit


def split_labels(labels: Sequence[str]) -> list[tuple[str, str]]:
    """Names and units of all headers, each name once.

    Names that differ by their units only stay as written, those that occur twice are numbered.
    """
    split = [split_label(label) for label in labels]
    times = Counter(name for name, _ in split)
    names = [
        name if times[name] == 1 else label for label, (name, _) in zip(labels, split, strict=True)
    ]
    return [(name, unit) for name, (_, unit) in zip(numbered(names), split, strict=True)]
