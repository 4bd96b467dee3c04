"""Units of columns: a whitelist, its factors to SI, and the role that each may fill.

Inside the program every number is SI; this is the edge. `nm` is a nanometre and `Nm` a newton
metre; what is not on the list is refused, not guessed.
"""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from axisid.modeling import Axis, ModelError, UsageError
from axisid.modeling.units import Unit, parse_unit

from .arrays import Array
from .errors import DataError
from .table import numbered

_TURN = 2 * math.pi
_DEGREE = math.pi / 180

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
    **{s: (f * _DEGREE, "rad/s") for s, f in (("deg/s", 1.0), ("°/s", 1.0))},
    **{s: (f, "rad/s") for s, f in (("rpm", _TURN / 60), ("rev/s", _TURN), ("1/min", _TURN / 60))},
    "%": (1e-2, "1"),
}
_SPELT = {"\u00b5": "u", "\u03bc": "u", "\u00ba": "\u00b0", "\u00b7": " "}
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
}
#: What encoders count; no unit until it is scaled.
_COUNTS = frozenset(
    "count counts ct cts digit digits inc incr increment increments ink inkremente lsb pulse "
    "pulses step steps tick ticks".split()
)
_NO_UNIT = frozenset(("-", "--", "none"))


def known_unit(text: str) -> tuple[float, Unit] | None:
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


def is_unit(text: str) -> bool:
    """Whether a text is surely a unit: one that is known, or what encoders count."""
    return known_unit(text) is not None or text.strip().lower() in _COUNTS


_UNIT = re.compile(r"(.+?)(\s*)(?:\[([^\[\]]+)\]|\(([^()]+)\)|/\s*([^\s/]+))")


def split_label(label: str) -> tuple[str, str]:
    """Name and unit of a header such as ``position [mm]`` or ``vel (rad/s)``; no unit, no cut.

    What stands in square brackets is a unit, known or not, unless it is a number (``q[1]``).
    In parentheses or after a slash it is one if it is known, or if encoders count in it.
    """
    match = _UNIT.fullmatch(label)
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


def expected_units(role: str, axis: Axis | None) -> tuple[str, ...]:
    """Coherent units that a role may have: one if the axis is known."""
    if role == "time":
        return ("s",)
    if axis is None:
        return {"force": ("N", "N m"), "control": ()}.get(role, ("m", "rad"))
    if role == "control":
        return (axis.drive.unit,)
    return (str(axis.coordinate.force_unit) if role == "force" else axis.coordinate.unit,)


def to_si(
    role: str, values: Array, unit: str, axis: Axis | None, *, asked: bool, source: str
) -> tuple[Array, str]:
    """Convert a column to SI, and say what was done; empty where nothing was.

    Parameters
    ----------
    role : str
    values : (N,) array
        In `unit`.
    unit : str
        As the file or the user writes it.
    axis : Axis or None
        Its coordinate and drive say what a role measures.
    asked : bool
        Whether the user gave the unit, for the error.
    source : str
        File name.

    Raises
    ------
    UsageError, DataError
        The unit is unknown, or measures something else than the role does.
    """
    wrong = UsageError if asked else DataError
    wanted = expected_units(role, axis)
    found = known_unit(unit)
    if found is None:
        counts = "encoder counts: scale them first. Else " if unit.lower() in _COUNTS else ""
        raise wrong(
            f"{source}: the {role} has the unit {unit!r}, which is not known; {counts}give the "
            f"unit that it is in with --columns {role}=NAME:UNIT (mm, deg, rev, ms, mA, Ncm, "
            f"...), or {role}=NAME:{(wanted or ('V',))[0]} where it is SI."
        )
    factor, coherent = found
    if wanted and not any(_measures(coherent, unit_) for unit_ in wanted):
        of_axis = f" of axis {axis.name!r}" if axis is not None else ""
        raise wrong(
            f"{source}: the {role} has the unit {unit!r}, but the {role}{of_axis} is measured in "
            f"{' or '.join(wanted)}. Check the column, or give its unit with --columns "
            f"{role}=NAME:UNIT."
        )
    if factor == 1.0:
        return values, ""
    return values * factor, f"{role}: {unit} -> {coherent}"


def _measures(unit: Unit, wanted: str) -> bool:
    """Whether the units agree in kind: an angle is a number, but no angle is a length."""
    return unit.same_dimension(parse_unit(wanted))


def taken_as_si(roles: Mapping[str, str], axis: Axis | None) -> str:
    """What is said of columns, by role, whose unit nobody gave."""
    if not roles:
        return ""
    named = []
    for role, name in roles.items():
        wanted = expected_units(role, axis)
        unit = " or ".join(wanted) if wanted else "as the drive has it"
        unknown = _UNIT.fullmatch(name)
        passed = unknown[4] if unknown is not None else None
        told = passed and not passed.isdecimal()
        named.append(f"{role} {unit}" + (f" ({passed!r} is no unit known)" if told else ""))
    return f"no unit given, so SI: {', '.join(named)}"


def modulus_si(text: str, axis: Axis | None) -> float:
    """A modulus such as ``6.2832``, ``360:deg`` or ``1:rev`` in SI.

    Raises
    ------
    UsageError
        It is no positive number, or its unit is not the position's.
    """
    number, _, unit = text.partition(":")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise UsageError(
            f"the modulus is {text!r}; give a positive number, with a unit where it is not SI, as "
            "in 360:deg or 1:rev."
        )
    if not unit:
        return value
    array, _ = to_si("position", np.array([value]), unit, axis, asked=True, source="the modulus")
    return float(array[0])
