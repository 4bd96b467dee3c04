"""Assignment of the columns of a table to roles, in SI.

The name of the column of a role is given by the user, declared by the axis, or that of the role.
"""

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import partial

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import PeriodSource, Repair, Samples, Table
from axisid.modeling.declaration import ROLES, Axis
from axisid.support.checks import refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting
from axisid.support.wording import quoted

from .units import Scale, assumed_units_text, check_no_counts, to_si

_CLOCKS = "the times of the channels in the file are used"

#: True for some samples, (N,).
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoleColumns:
    """Columns of a log by role, in SI, with assumptions and repairs.

    Attributes
    ----------
    source : str
        Name of the log, for messages.
    names : mapping of str to str
        Names of the columns in the log, by role.
    samples : mapping of str to Samples
        Values in SI by role, each with its times if the log has them.
    scales : mapping of str to Scale
        Scales from the numbers of the log to SI by role, for columns with a unit.
    notes : tuple of str
        Assumptions about the columns, for the user.
    injected_at : str or None
        Injection point of a test signal; None if it is unknown.
    repairs : tuple of Repair
        Repairs that have been made so far.
    masks : mapping of str to (N,) array of bool
        True for samples that are not measurements, by role.
    segments : tuple of (int, int)
        First sample and the one after the last of each piece without gaps, for columns with the
        same times; empty for one piece.
    period : float or None
        Sampling period of columns with the same times, s; None for the mean step.
    clock : PeriodSource
        Source of the sampling period of the motion.
    """

    source: str
    names: Mapping[str, str]
    samples: Mapping[str, Samples]
    scales: Mapping[str, Scale] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    injected_at: str | None = None
    repairs: tuple[Repair, ...] = ()
    masks: Mapping[str, Mask] = field(default_factory=dict)
    segments: tuple[tuple[int, int], ...] = ()
    period: float | None = None
    clock: PeriodSource = field(default_factory=PeriodSource)

    @property
    def motion(self) -> Samples:
        """Samples of the position, or of the velocity of a log without a position."""
        return self.samples[motion_role(self.samples)]

    def repaired(self, samples: Mapping[str, Samples], *repairs: Repair) -> "RoleColumns":
        """Return the columns with new samples of some roles, and with further repairs reported."""
        return replace(self, samples={**self.samples, **samples}, repairs=(*self.repairs, *repairs))


#: Name of a column, and its given unit.
_Chosen = tuple[str, str]


def role_columns(
    table: Table,
    axis: Axis | None,
    requested: dict[str, str],
    *,
    has_period: bool = False,
    injected_at: str | None = None,
) -> RoleColumns:
    """Return the columns of a table that have a role, in SI.

    A column that only the axis names may be missing in these cases: the time, if the period is
    given or the file has times for each column; the reference, a test signal, velocity and
    acceleration always; the position, if there is a velocity; the control, if there is a force. The
    signals that the axis declares may not be missing.

    Parameters
    ----------
    table : Table
        Columns of the log.
    axis : Axis or None
        Axis that declares names and units; None if it is unknown.
    requested : dict of str to str
        Names that the user gave, by role, each with a unit or scaling if it is given. They replace
        the names that the axis declares. The default is the name of the role.
    has_period : bool
        True if the user gave the sampling period.
    injected_at : str, optional
        Injection point that the user gave, instead of that of the axis.

    Raises
    ------
    UsageError, DataError
        A role does not exist; a column is missing, has no numbers, or has two roles; a unit does
        not suit the role; or the injection point of a test signal is unknown.
    """
    injection_point = injected_at or ("" if axis is None else axis.injected_at) or None
    chosen, without = _choose(table, axis, requested, has_period=has_period)
    notes = _injection_notes(
        table.source, chosen, axis, injection_point, requested=requested, is_given=bool(injected_at)
    )
    # Convert each column to SI; without a unit it is assumed to be in SI.
    names, samples, scales, without_unit = {}, {}, {}, {}
    for role, (name, unit) in chosen.items():
        column, conversion = table.columns[name], ""
        column_samples = column.read()
        values = column_samples.values
        if unit or column.unit:
            converted = partial(
                to_si,
                role,
                text=unit or column.unit,
                axis=axis,
                requested=role in requested and bool(unit),
                source=table.source,
                own=column.unit if unit else None,
                injected_at=injection_point,
            )
            values, conversion = converted(values)
            # The scale is that of the numbers 0 and 1.
            offset, one = converted(np.array([0.0, 1.0]))[0]
            scales[role] = Scale(factor=float(one - offset), offset=float(offset))
        else:
            check_no_counts(role, name, values, axis, source=table.source)
            without_unit[role] = name
        names[role], samples[role] = name, replace(column_samples, values=values)
        notes += [note for note in (column.note, conversion) if note and note not in notes]
    # A time column that does not belong to the motion is not used, unless the user names it.
    if "time" in samples and "time" not in requested:
        others = {role: s for role, s in samples.items() if role != "time"}
        moving, time_rows = motion_role(others), len(samples["time"].values)
        # The time column may belong to another group of channels, if all channels have their times.
        if _has_clocks(others.values()) and time_rows != len(others[moving].values):
            notes.append(
                f"the column {names.pop('time')!r} has {time_rows} rows, but the {moving} has "
                f"{len(others[moving].values)}, so {_CLOCKS}"
            )
            samples = others
            without_unit.pop("time", None)
    if without_unit:
        notes.append(assumed_units_text(without_unit, axis, injected_at=injection_point))
    return RoleColumns(
        source=table.source,
        names=names,
        samples=samples,
        scales=scales,
        notes=(*table.warnings, *table.notes, *notes, *without),
        injected_at=injection_point,
        repairs=table.repairs,
    )


def _injection_notes(
    source: str,
    chosen: dict[str, _Chosen],
    axis: Axis | None,
    injection_point: str | None,
    *,
    requested: Container[str],
    is_given: bool,
) -> list[str]:
    """Return notes on the injection point of the test signal; empty without a test signal.

    Without an injection point, the test signal is removed from the chosen columns.

    Parameters
    ----------
    source : str
        Name of the log, for messages.
    chosen : dict of str to (str, str)
        Name and given unit of the chosen columns by role, which may be changed.
    axis : Axis or None
    injection_point : str or None
        Injection point as given or as declared by the axis; None if it is unknown.
    requested : container of str
        Roles whose columns the user named.
    is_given : bool
        True if the user gave the injection point.

    Raises
    ------
    UsageError
        The column was named without an injection point, or the injection point without a column.
    """
    if "injected" not in chosen:
        if is_given:
            raise UsageError(
                f"{source}: no column has the test signal that is added to the {injection_point}. "
                f"Name the column with {_columns_setting(['injected'])}.",
                code="test-signal",
            )
        return []
    name, _ = chosen["injected"]
    if injection_point:
        return [f"the test signal {name!r} was added to the {injection_point}"]
    if "injected" in requested or (axis is not None and "injected" in axis.columns):
        raise UsageError(
            f"{source}: the injection point of the test signal {name!r} is unknown. Set "
            'injected_at = "control" or injected_at = "reference" in run.toml.',
            code="test-signal",
        )
    del chosen["injected"]
    return [f"the test signal {name!r} is not used, because its injection point is unknown"]


def _has_clocks(columns: Iterable[Samples]) -> bool:
    """Return True if the log has times for each of the columns."""
    return all(samples.clock is not None for samples in columns)


def _choose(
    table: Table, axis: Axis | None, requested: dict[str, str], *, has_period: bool
) -> tuple[dict[str, _Chosen], tuple[str, ...]]:
    """Return the name and the given unit of the column of each role, and notes on missing columns.

    The unit is empty if none is given. `requested` has the names that the user gave, by role;
    `has_period` is True if the user gave the sampling period.

    Raises
    ------
    UsageError
        A requested role does not exist.
    DataError
        A column that is needed or was requested is missing, or a column has no numbers or two
        roles.
    """
    roles = ROLES if axis is None else axis.roles
    for role, wanted in requested.items():
        refuse(
            UsageError,
            (
                role not in roles,
                f"{role!r} is not a role of a column. Choose from the roles {', '.join(roles)}",
            ),
            (
                not isinstance(wanted, str),
                f"the column for the {role} is {quoted(wanted)}. Give the name of the column, or a "
                "Column",
            ),
            code="columns",
        )
    asked = {**({} if axis is None else axis.columns), **requested}
    chosen: dict[str, _Chosen] = {}
    missing: dict[str, str] = {}
    for role in roles:
        wanted = str(asked.get(role) or role)
        name, unit = table.find(wanted), ""
        # A name with a colon that is not found may be a name with its unit.
        if name is None and ":" in wanted:
            head, _, unit = wanted.rpartition(":")
            name = table.find(head.strip())
            wanted = head if name is None else wanted
        if name is not None:
            chosen[role] = name, unit.strip()
        elif role in asked or role == "position" or role not in ROLES:
            missing[role] = wanted
    # A column that only has the name of a derivative need not be measured.
    unasked = [
        f"the column {chosen.pop(role)[0]!r} is not used, because it was not named as the measured "
        f"{role}"
        for role in ("velocity", "acceleration")
        if role in chosen and role not in asked
    ]
    _check_chosen(table, chosen)
    without = _missing_notes(table, missing, chosen, has_period=has_period)
    if any(role in requested or role not in without for role in missing):
        raise _missing_columns(table, chosen, missing)
    return chosen, (*without.values(), *unasked)


def _check_chosen(table: Table, chosen: Mapping[str, _Chosen]) -> None:
    """Refuse columns without numbers, and a column for two roles.

    Raises
    ------
    DataError
    """
    roles: dict[str, str] = {}
    for role, (name, _) in chosen.items():
        holds = table.columns[name].holds
        refuse(
            DataError,
            (
                holds,
                f"{table.source}: the column {name!r} for the {role} contains {holds}. Name a "
                f"column of real numbers or time stamps with {_columns_setting([role])}",
            ),
            (
                roles.setdefault(name, role) != role,
                f"{table.source}: the column {name!r} is used for both the {roles[name]} and the "
                f"{role}. Name another column for the {role} with {_columns_setting([role])}",
            ),
            code="columns",
        )


def _missing_notes(
    table: Table,
    missing: dict[str, str],
    chosen: Mapping[str, _Chosen],
    *,
    has_period: bool,
) -> dict[str, str]:
    """Return notes by role on missing columns that are not needed.

    There is no note on a name that several columns have: the user has to choose a column.

    Parameters
    ----------
    table : Table
    missing : dict of str to str
        Names of the columns that were not found, by role.
    chosen : mapping of str to (str, str)
        Name and given unit of the columns that were found, by role.
    has_period : bool
        True if the user gave the sampling period.
    """
    timed = "time" in missing and _has_clocks(
        table.columns[name].read() for name, _ in chosen.values()
    )
    # Role, condition under which its column may be missing, and the consequence.
    consequences = (
        ("time", has_period, "the time is counted by the sampling period"),
        ("time", timed, _CLOCKS),
        ("control", "force" in chosen, "the control law is not compared with the record"),
        ("position", "velocity" in chosen, "the position is the integral of the velocity"),
        ("velocity", True, "the velocity is the derivative of the position"),
        ("acceleration", True, "the acceleration is the derivative of the velocity"),
        ("reference", True, "only least squares is available"),
        ("injected", True, "no test signal is considered"),
    )
    return {
        role: f"no column {missing[role]!r} for the {role}, so {consequence}"
        for role, may_be_missing, consequence in consequences
        if may_be_missing and role in missing and not table.alike(missing[role])
    }


def _missing_columns(
    table: Table, chosen: Mapping[str, object], missing: dict[str, str]
) -> DataError:
    """Return the error that columns are missing, with similar names of the table.

    `chosen` has the columns that were found, and `missing` the names that were not, both by role.
    """
    wanted = ", ".join(f"{name!r} for the {role}" for role, name in missing.items())
    several = [candidates for name in missing.values() if len(candidates := table.alike(name)) > 1]
    # Similar names: the closest one, and longer ones with a unit after the name.
    names = {name.casefold(): name for name in list(table.columns)[:1000]}
    close = dict[str, None]()
    for plain in map(str.casefold, missing.values()):
        longer = [name for name in names if name.startswith((f"{plain} ", f"{plain}["))]
        close |= dict.fromkeys((*get_close_matches(plain, names, 1, 0.8), *longer[:2]))
    meant = " or ".join(repr(names[near]) for near in close)
    hint = f" Did you mean {meant}?" if meant else ""
    if several:
        hint = " Several columns have the same name: " + "; ".join(map(", ".join, several)) + "."
    usual = ("time", "reference", "control") if "position" in missing else ()
    named = [*missing, *(role for role in usual if role not in chosen and role not in missing)]
    advice = table.missing or f"Name the columns with {_columns_setting(named)}."
    return DataError(
        f"{table.source}: there is no column {wanted}. Found: {table.listed()}.{hint} {advice}",
        code="columns",
    )


def _columns_setting(roles: Iterable[str]) -> str:
    """Return the setting that names the columns of some roles, as the user types it."""
    return setting("columns", dict.fromkeys(roles, "NAME"))


def motion_role(roles: Container[str]) -> str:
    """Return the role of the motion: position, or velocity in a log without a position."""
    return "velocity" if "velocity" in roles and "position" not in roles else "position"
