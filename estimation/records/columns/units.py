"""Units of the roles: what each may be in, and its values in SI."""

import math
from collections.abc import Mapping

import numpy as np

from axisid.estimation.tables import COUNTS, LABEL_WITH_UNIT, known_unit
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Unit, parse_unit
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.remedy import Remedy, Setting


def expected_units(role: str, axis: Axis | None, injected_at: str | None = None) -> tuple[str, ...]:
    """Coherent units that a role may have: one if the axis is known.

    A test signal has that of what it is added to.
    """
    role = injected_at or "control" if role == "injected" else role
    if role == "time":
        return ("s",)
    if axis is None:
        return {"force": ("N", "N m"), "control": ()}.get(role, ("m", "rad"))
    if role == "control":
        return (axis.drive.unit,)
    return (str(axis.coordinate.force_unit) if role == "force" else axis.coordinate.unit,)


def to_si(
    role: str,
    values: Array,
    unit: str,
    axis: Axis | None,
    *,
    requested: bool,
    source: str,
    injected_at: str | None = None,
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
    requested : bool
        Whether the user gave the unit, for the error.
    source : str
        File name.
    injected_at : str, optional
        What a test signal is added to.

    Raises
    ------
    UsageError, DataError
        The unit is unknown, or measures something else than the role does.
    """
    wrong = UsageError if requested else DataError
    wanted = expected_units(role, axis, injected_at)
    found = known_unit(unit)
    named = Setting("columns", f"{role}=NAME:UNIT")
    if found is None:
        counts = "encoder counts: scale them first. Else " if unit.lower() in COUNTS else ""
        raise wrong(
            f"{source}: the {role} has the unit {unit!r}, which is not known; {counts}",
            Remedy.of(
                "give the unit that it is in with ",
                named,
                " (mm, deg, rev, ms, mA, Ncm, ...), or "
                f"NAME:{(wanted or ('V',))[0]} where it is SI.",
            ),
            code="unknown-unit",
        )
    factor, coherent = found
    if wanted and not any(_measures(coherent, unit_) for unit_ in wanted):
        of_axis = f" of axis {axis.name!r}" if axis is not None else ""
        raise wrong(
            f"{source}: the {role} has the unit {unit!r}, but the {role}{of_axis} is measured in "
            f"{' or '.join(wanted)}. ",
            Remedy.of("Check the column, or give its unit with ", named, "."),
            code="other-unit",
        )
    if factor == 1.0:
        return values, ""
    return values * factor, f"{role}: {unit} -> {coherent}"


def _measures(unit: Unit, wanted: str) -> bool:
    """Whether the units agree in kind: an angle is a number, but no angle is a length."""
    return unit.same_dimension(parse_unit(wanted))


def assumed_units_text(
    roles: Mapping[str, str], axis: Axis | None, *, injected_at: str | None = None
) -> str:
    """What is said of columns, by role, whose unit nobody gave."""
    if not roles:
        return ""
    named = []
    for role, name in roles.items():
        wanted = expected_units(role, axis, injected_at)
        unit = " or ".join(wanted) if wanted else "as the drive has it"
        label = LABEL_WITH_UNIT.fullmatch(name)
        passed = label[4] if label is not None else None
        unknown = passed and not passed.isdecimal()
        named.append(f"{role} {unit}" + (f" ({passed!r} is no unit known)" if unknown else ""))
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
    array, _ = to_si(
        "position", np.array([value]), unit, axis, requested=True, source="the modulus"
    )
    return float(array[0])
