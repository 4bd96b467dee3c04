"""Units of the roles and signals: what each may be in, and its values in SI."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.tables import COUNTS, LABEL_WITH_UNIT, is_unit, label_unit
from axisid.modeling.declaration import ROLES, Axis
from axisid.modeling.quantities import Unit, angle_power, parse_unit
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.remedy import Remedy, Setting

from .scaling import Quantity, ScalingError, read_scaling

# different whole numbers: metres or radians are whole by chance in no log, fewer are a test of a
# few rows
_MIN_COUNTS = 10

#: Of the roles that are no length or angle, where no axis says more.
_UNITS: dict[str, tuple[str, ...]] = {
    "control": (),
    "force": ("N", "N m"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
}


def expected_units(role: str, axis: Axis | None, injected_at: str | None = None) -> tuple[str, ...]:
    """Coherent units that a role may have: one if the axis is known.

    A test signal has that of what it is added to.
    """
    role = injected_at or "control" if role == "injected" else role
    if role == "time":
        return ("s",)
    if axis is not None and role not in ROLES:
        return tuple(signal.unit for signal in axis.signals if signal.name == role)
    if axis is None:
        return _UNITS.get(role, ("m", "rad"))
    q = axis.coordinate
    units = {
        "control": axis.drive.unit,
        "force": str(q.force_unit),
        "velocity": str(q.velocity_unit),
        "acceleration": str(q.acceleration_unit),
    }
    return (units.get(role, q.unit),)


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
    found = label_unit(unit)
    named = Setting("columns", f"{role}=NAME:UNIT")
    if found is None:
        counts: Remedy | None = None
        if unit.lower() in COUNTS:
            each = Setting("columns", f"{role}=NAME:{unit}*360deg/4096")
            counts = Remedy.of("say what one of these counts is, as in ", each, ". Else ")
        raise wrong(
            f"{source}: the {role} has the unit {unit!r}, which is not known; ",
            Remedy.of(
                counts,
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


def scaled(
    role: str,
    values: Array,
    text: str,
    axis: Axis | None,
    *,
    own: str,
    source: str,
    injected_at: str | None = None,
) -> tuple[Array, str]:
    """Make a column SI as a text such as ``counts*360deg/4096`` says, and say what was done.

    Parameters
    ----------
    role, values, axis, source, injected_at
        As in `to_si`.
    text : str
        See `read_scaling`.
    own : str
        Unit as the file writes it; empty where it writes none.

    Raises
    ------
    UsageError
        It is no such text, it does not say what one count is, or gives something else than the role
        measures.
    """
    wanted = expected_units(role, axis, injected_at)
    try:
        scaling = read_scaling(text, own if is_unit(own) else "")
    except ScalingError as error:
        raise UsageError(
            f"{source}: the {role} is given as {text!r}: at letter {error.letter}, {error}; ",
            Remedy.of("write it as in ", _example(role, wanted), "."),
            code="no-scaling",
        ) from error
    of = scaling.of
    if of.is_count and not scaling.is_scaled:
        raise UsageError(
            f"{source}: the {role} is given as {text!r}, which does not say what one count is; ",
            Remedy.of("give that, as in ", _example(role, wanted), "."),
            code="unscaled-counts",
        )
    if of.unit is not None and wanted and not any(_measures(of.unit, unit) for unit in wanted):
        raise UsageError(
            f"{source}: the {role} is given as {text!r}, which is {of.unit}, but the {role} is "
            f"measured in {' or '.join(wanted)}; check its units.",
            code="scaling-unit",
        )
    _check_angle(role, text, of, wanted, source)
    same = (u for u in wanted if of.unit is not None and _measures(of.unit, u))
    unit = next(same, of.unit) or (wanted[0] if len(wanted) == 1 else "SI")
    said = f"{role}: {text}, {float(of):.9g} {unit} each"
    values = values * float(of)
    if scaling.offset is not None:
        values = values + float(scaling.offset)
        said += f" {'+' if scaling.offset.value >= 0 else '-'} {abs(float(scaling.offset)):.9g}"
    return values, said


def _example(role: str, wanted: Sequence[str]) -> Setting:
    """A scaling of a role, for a message."""
    unit = next(iter(wanted), "")
    rate = unit.removeprefix("rad").removeprefix("m")
    if rate in ("/s", "/s^2") and unit != rate:
        turns = "rpm" if rate == "/s" else "rev/s^2"
        return Setting("columns", f"{role}=NAME:{turns}" + "*5mm/rev" * unit.startswith("m"))
    each = "5mm/4096" if unit == "m" else "360deg/4096/50+0.2deg"
    named = role if unit in ("m", "rad") else "position"
    return Setting("columns", f"{named}=NAME:counts*{each}")


def _check_angle(role: str, text: str, of: Quantity, wanted: Sequence[str], source: str) -> None:
    """Refuse a length that is still one times an angle, and an angle that nothing says is one.

    SI counts angles as numbers, so that ``rpm*5mm`` is a speed to it: by 2 pi another than that of
    a screw of 5 mm a turn.
    """
    if of.unit is None:
        return
    units = [parse_unit(unit) for unit in wanted]
    motions = [unit for unit in units if of.unit.same_dimension(unit) and _is_of_motion(unit)]
    if not motions or any(angle_power(unit) == of.angle for unit in motions):
        return
    unit = motions[0]
    left = of.angle - angle_power(unit)
    if angle_power(unit):
        said = "that of no angle"
        what = "say which angle it is, as in mm/5mm*1rev for a screw or mm/5mm*1rad for a radius"
    elif left > 0:
        said = f"{unit} times an angle"
        what = "say what length belongs to it, *5mm/rev for a screw or *5mm/rad for a radius"
    else:
        said = f"{unit} an angle"
        what = "say what angle it is of, as in counts*1rev/4096*5mm/rev"
    raise UsageError(
        f"{source}: the {role} is given as {text!r}, which is {said}; {what}.",
        code="scaling-angle",
    )


def _is_of_motion(unit: Unit) -> bool:
    """Whether a unit is of length or angle and time alone, such as m/s; a plain number is not."""
    mass, length, _, current, heat = unit.exponents
    return not (mass or current or heat) and bool(length or angle_power(unit))


def check_no_counts(role: str, name: str, values: Array, axis: Axis | None, *, source: str) -> None:
    """Refuse whole numbers without a unit as a position: they are what an encoder counts.

    Raises
    ------
    DataError
        They are.
    """
    finite = values[np.isfinite(values)]
    if role not in ("position", "reference") or np.any(finite != np.round(finite)):
        return
    if len(np.unique(finite)) < _MIN_COUNTS:
        return
    unit = (axis.coordinate.unit if axis is not None else "") or "rad"
    example = "5mm/4096" if unit == "m" else "360deg/4096"
    raise DataError(
        f"{source}: the {role} {name!r} has no unit, and is whole numbers alone, from "
        f"{finite.min():.9g} to {finite.max():.9g}: those are counts of an encoder; ",
        Remedy.of(
            "say what one of them is, as in ",
            Setting("columns", f"{role}={name}:counts*{example}"),
            f"; where they are {unit} indeed, say so ({name}:{unit}).",
        ),
        code="whole-numbers",
    )


def _measures(unit: Unit, wanted: str) -> bool:
    """Whether the units agree in kind: an angle is a number, but no angle is a length."""
    return unit.same_dimension(parse_unit(wanted))


def assumed_units_text(
    roles: Mapping[str, str], axis: Axis | None, *, injected_at: str | None
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
