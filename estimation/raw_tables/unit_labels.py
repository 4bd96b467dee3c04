"""Units in logs: the known units, their factors to SI, and headers with a name and a unit.

Inside the program every number is in SI. `nm` is a nanometre and `Nm` a newton metre; an unknown
unit is refused, not guessed.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from axisid.modeling.quantities import Unit, angle_power, parse_unit
from axisid.support.errors import ModelError

from .table import numbered

#: Entry of a NumPy archive that has the units of its columns: a JSON object by name.
UNITS_ENTRY = "axisid.units"

#: By symbol of a unit: factor to SI without pi, power of pi in the factor, and coherent unit.
_FACTORS: Mapping[str, tuple[str, int, str]] = {
    **{
        s: (f, 0, "s")
        for s, f in (("s", "1"), ("sec", "1"), ("ms", "1e-3"), ("us", "1e-6"), ("ns", "1e-9"))
    },
    **{s: (f, 0, "s") for s, f in (("min", "60"), ("h", "3600"))},
    **{s: (f, 0, "m") for s, f in (("m", "1"), ("cm", "1e-2"), ("mm", "1e-3"), ("um", "1e-6"))},
    **{s: (f, 0, "m") for s, f in (("nm", "1e-9"), ("inch", "0.0254"), ("km", "1e3"))},
    **{s: (f, 0, "rad") for s, f in (("rad", "1"), ("mrad", "1e-3"), ("urad", "1e-6"))},
    **{s: (f, 1, "rad") for s, f in (("deg", "1/180"), ("mdeg", "1/180000"), ("°", "1/180"))},
    **{s: (f, 1, "rad") for s, f in (("arcmin", "1/10800"), ("arcsec", "1/648000"))},
    **dict.fromkeys(("rev", "turn", "turns"), ("2", 1, "rad")),
    **{s: (f, 0, "N") for s, f in (("N", "1"), ("mN", "1e-3"), ("kN", "1e3"), ("daN", "10"))},
    **{s: (f, 0, "N m") for s, f in (("Nm", "1"), ("mNm", "1e-3"), ("Ncm", "1e-2"))},
    **{s: (f, 0, "N m") for s, f in (("kNm", "1e3"), ("Nmm", "1e-3"), ("uNm", "1e-6"))},
    **{s: (f, 0, "A") for s, f in (("A", "1"), ("mA", "1e-3"), ("uA", "1e-6"), ("kA", "1e3"))},
    **{s: (f, 0, "V") for s, f in (("V", "1"), ("mV", "1e-3"), ("uV", "1e-6"), ("kV", "1e3"))},
    **{s: (f, 0, "m/s") for s, f in (("mm/s", "1e-3"), ("m/min", "1/60"), ("mm/min", "1/60000"))},
    **{s: (f, 0, "m/s") for s, f in (("cm/s", "1e-2"), ("um/s", "1e-6"))},
    **{s: (f, 1, "rad/s") for s, f in (("deg/s", "1/180"), ("°/s", "1/180"))},
    **{s: (f, 1, "rad/s") for s, f in (("rpm", "1/30"), ("rev/s", "2"), ("1/min", "1/30"))},
    "mrad/s": ("1e-3", 0, "rad/s"),
    "krpm": ("100/3", 1, "rad/s"),
    **{s: (f, 0, "m/s^2") for s, f in (("mm/s^2", "1e-3"), ("cm/s^2", "1e-2"), ("g", "9.80665"))},
    **{s: (f, 1, "rad/s^2") for s, f in (("deg/s^2", "1/180"), ("°/s^2", "1/180"))},
    "mrad/s^2": ("1e-3", 0, "rad/s^2"),
    "rev/s^2": ("2", 1, "rad/s^2"),
    **{s: (f, 0, "Pa") for s, f in (("Pa", "1"), ("hPa", "1e2"), ("kPa", "1e3"), ("MPa", "1e6"))},
    **{s: (f, 0, "Pa") for s, f in (("mbar", "1e2"), ("bar", "1e5"), ("psi", "6894.757293"))},
    "%": ("1e-2", 0, "1"),
}


#: Characters of units and their usual spelling here: two signs for micro, degree, dot, square.
_SPELT = str.maketrans(
    {"\u00b5": "u", "\u03bc": "u", "\u00ba": "\u00b0", "\u00b7": " ", "\u00b2": "^2"}
)


#: Names of units and other spellings, with the symbol.
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


#: Names of encoder counts; they have no unit until they are scaled.
COUNTS = frozenset(
    "count counts ct cts digit digits inc incr increment increments ink inkremente lsb pulse "
    "pulses step steps tick ticks".split()
)


#: Pi to forty digits.
_PI = Fraction(31415926535897932384626433832795028841971, 10**40)


@dataclass(frozen=True, slots=True)
class UnitQuantity:
    """A number with its unit.

    Attributes
    ----------
    value : Fraction
        Value in the coherent unit, with pi to forty digits.
    unit : Unit or None
        Coherent unit; None for a plain number.
    is_count : bool
        True for encoder counts.
    angle : Fraction or int
        Power of the radian, which `unit` does not contain, as an angle is dimensionless in SI.
    """

    value: Fraction
    unit: Unit | None = None
    is_count: bool = False
    angle: Fraction | int = 0

    def __mul__(self, other: "UnitQuantity") -> "UnitQuantity":
        """Return the product; it is one of encoder counts if this quantity is."""
        unit = self.unit * other.unit if self.unit and other.unit else self.unit or other.unit
        return UnitQuantity(self.value * other.value, unit, self.is_count, self.angle + other.angle)

    def __truediv__(self, other: "UnitQuantity") -> "UnitQuantity":
        """Return the quotient; it is one of encoder counts if this quantity is."""
        unit = other.unit and other.unit**-1
        return self * UnitQuantity(1 / other.value, unit, angle=-other.angle)

    def __float__(self) -> float:
        """Return the value in the coherent unit."""
        return float(self.value)


def exact_unit(text: str) -> UnitQuantity | None:
    """Return the quantity of one unit such as ``mm`` or ``N m``; None for an unknown unit."""
    plain = text.strip().translate(_SPELT)
    if "**" not in plain:
        plain = plain.replace("*", " ")
    plain = _NAMES.get(plain, _NAMES.get(plain.lower(), plain))
    factor, turns, coherent = _FACTORS.get(plain, ("1", 0, plain))
    try:
        unit = parse_unit(coherent)
    except ModelError:
        return None
    return UnitQuantity(Fraction(factor) * _PI**turns, unit, angle=angle_power(unit))


def is_unit(text: str) -> bool:
    """Return True if a text is a known unit, or a name of encoder counts."""
    return exact_unit(text) is not None or text.strip().lower() in COUNTS


#: Header with a unit. Groups: name, blanks, and unit in square brackets, parentheses or after `/`.
LABEL_WITH_UNIT = re.compile(r"(.+?)(\s*)(?:\[([^\[\]]+)\]|\(([^()]+)\)|/\s*([^\s/]+))")


def split_label(label: str) -> tuple[str, str]:
    """Return name and unit of a header such as ``position [mm]`` or ``vel (rad/s)``.

    A text in square brackets is a unit, known or not, unless it is a number (``q[1]``). A text in
    parentheses or after a slash is a unit only if it is a known unit or encoder counts. A header
    without a unit is a name as a whole, with an empty unit.
    """
    match = LABEL_WITH_UNIT.fullmatch(label)
    if match is None:
        return label, ""
    name, blank, square, round_, after_slash = match.groups()
    unit = (square or round_ or after_slash).strip()
    is_path = after_slash is not None and not blank  # `axis/s` may be a path
    if is_path or unit.isdecimal() or not (square is not None or is_unit(unit)):
        return label, ""
    return name, "" if unit.lower() in ("-", "--", "none") else unit


def split_labels(labels: Sequence[str]) -> list[tuple[str, str]]:
    """Return names and units of all headers, with unique names.

    A name of several columns is replaced by the whole header, which contains the unit. Headers that
    are repeated are numbered.
    """
    split = [split_label(label) for label in labels]
    times = Counter(name for name, _ in split)
    names = [
        name if times[name] == 1 else label for label, (name, _) in zip(labels, split, strict=True)
    ]
    return [(name, unit) for name, (_, unit) in zip(numbered(names), split, strict=True)]
