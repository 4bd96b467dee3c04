"""Which column of a table is which role, in SI: names from the user, the axis, or the role."""

from dataclasses import replace

from axisid.modeling import ROLES, Axis, UsageError

from .column_units import taken_as_si, to_si
from .errors import DataError
from .table import Samples, Table

_NEEDED = ("position",)


class Chosen:
    """Columns by role, in SI, with what was assumed on the way.

    Of the columns that only the axis declares, the time may be missing where the period is given,
    the reference always, and the control where there is a force.
    """

    def __init__(
        self, table: Table, axis: Axis | None, asked: dict[str, str], *, has_period: bool = False
    ) -> None:
        self.names: dict[str, str] = {}
        self.samples: dict[str, Samples] = {}
        notes: list[str] = []
        silent: dict[str, str] = {}
        chosen, without = _choose(table, axis, asked, has_period=has_period)
        for role, (name, unit, by_user) in chosen.items():
            column = table.columns[name]
            samples = column.read()
            written = unit or column.unit
            values, note = samples.values, ""
            if written:
                values, note = to_si(
                    role, values, written, axis, asked=by_user and bool(unit), source=table.source
                )
            else:
                silent[role] = name
            self.names[role] = name
            self.samples[role] = replace(samples, values=values)
            notes += [said for said in (column.note, note) if said and said not in notes]
        taken = taken_as_si(silent, axis)
        self.notes = (*table.warnings, *table.notes, *notes, *([taken] if taken else []), *without)


def _choose(
    table: Table, axis: Axis | None, asked: dict[str, str], *, has_period: bool
) -> tuple[dict[str, tuple[str, str, bool]], tuple[str, ...]]:
    """Column, unit if one is given, and whether the user named it, by role; and what is missing."""
    for role in asked:
        if role not in ROLES:
            raise UsageError(f"{role!r} is no role of a column; the roles are {', '.join(ROLES)}.")
    declared = dict(axis.columns) if axis is not None else {}
    chosen: dict[str, tuple[str, str, bool]] = {}
    missing: dict[str, str] = {}
    for role in ROLES:
        wanted = asked.get(role) or declared.get(role) or role
        name, unit = table.find(wanted), ""
        if name is None and ":" in wanted:
            head, _, unit = wanted.rpartition(":")
            name = table.find(head.strip())
            wanted = head if name is None else wanted
        if name is not None:
            chosen[role] = (name, unit.strip(), role in asked)
        elif holds := table.holds(wanted):
            raise DataError(
                f"{table.source}: the column {wanted!r} for the {role} holds {holds}; give one of "
                f"real numbers, or of time stamps, with --columns {role}=NAME."
            )
        elif role in asked or role in declared or role in _NEEDED:
            missing[role] = wanted
    _check_apart(table, chosen)
    without = _without(missing, chosen, has_period=has_period)
    for role, wanted in missing.items():
        if role in asked or role not in without:
            raise _not_found(table, role, wanted)
    return chosen, tuple(without.values())


def _without(
    missing: dict[str, str], chosen: dict[str, tuple[str, str, bool]], *, has_period: bool
) -> dict[str, str]:
    """What is said of columns that only the axis names, and that can be done without."""
    spared = {}
    if has_period:
        spared["time"] = "counted by the sampling period"
    if "force" in chosen:
        spared["control"] = "so the control law is not compared with the record"
    spared["reference"] = "so least squares only, no instruments"
    return {
        role: f"no column {missing[role]!r} for the {role}, {what}"
        for role, what in spared.items()
        if role in missing
    }


def _not_found(table: Table, role: str, wanted: str) -> DataError:
    alike = next((name for name in table.columns if name.casefold() == wanted.casefold()), "")
    meant = f" Did you mean {alike!r}?" if alike else ""
    return DataError(
        f"{table.source}: there is no column {wanted!r} for the {role}; found {table.listed()}."
        f"{meant} " + (table.missing or f"Name the column with --columns {role}=NAME.")
    )


def _check_apart(table: Table, chosen: dict[str, tuple[str, str, bool]]) -> None:
    """One column cannot be two things."""
    roles: dict[str, str] = {}
    for role, (name, *_) in chosen.items():
        if name in roles:
            raise DataError(
                f"{table.source}: the column {name!r} is taken for the {roles[name]} and for the "
                f"{role}; name another for one of them, with --columns {role}=NAME."
            )
        roles[name] = role
