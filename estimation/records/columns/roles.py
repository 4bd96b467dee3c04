"""Which column of a table is which role, in SI: names from the user, the axis, or the role."""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches

from axisid.estimation.tables import Samples, Table
from axisid.modeling.declaration import ROLES, Axis
from axisid.support.errors import DataError, UsageError, quoted

from .units import assumed_units_text, check_no_counts, to_si

_MIN_NAME_SIMILARITY = 0.8  # by difflib, from which a column is proposed for a wanted one

_ON_REQUEST = ("velocity", "acceleration")  # a column that only bears the name is left out
_CLOCKS = "the file's own clocks are taken"
_COMPARED = 1000  # columns that a name is compared with

#: What an axis may be identified from, the first that is there.
MOTION_ROLES = ("position", "velocity")


class RoleColumns:
    """Columns by role, in SI, with what was assumed on the way.

    Of the columns that only the axis declares, the time may be missing where the period is given or
    the file has clocks of its own, the reference, a test signal, velocity and acceleration always,
    the position where there is a velocity, and the control where there is a force. The signals that
    the axis declares may not.
    """

    def __init__(
        self,
        table: Table,
        axis: Axis | None,
        requested: dict[str, str],
        *,
        has_period: bool = False,
        injected_at: str | None = None,
    ) -> None:
        self.injected_at = injected_at or ("" if axis is None else axis.injected_at) or None
        self.names: dict[str, str] = {}
        self.samples: dict[str, Samples] = {}
        notes: list[str] = []
        without_unit: dict[str, str] = {}
        chosen, without = _choose(table, axis, requested, has_period=has_period)
        notes += self._placed(table.source, chosen, requested, axis, has_place=bool(injected_at))
        for role, (name, unit, by_user) in chosen.items():
            column = table.columns[name]
            samples = column.read()
            values, note = samples.values, ""
            if unit or column.unit:
                values, note = to_si(
                    role,
                    values,
                    unit or column.unit,
                    axis,
                    requested=by_user and bool(unit),
                    source=table.source,
                    own=column.unit if unit else None,
                    injected_at=self.injected_at,
                )
            else:
                check_no_counts(role, name, values, axis, source=table.source)
                without_unit[role] = name
            self.names[role] = name
            self.samples[role] = replace(samples, values=values)
            notes += [said for said in (column.note, note) if said and said not in notes]
        if said := self._own_clocks(requested):
            notes.append(said)
            without_unit.pop("time", None)
        taken = assumed_units_text(without_unit, axis, injected_at=self.injected_at)
        self.notes = (*table.warnings, *table.notes, *notes, *([taken] if taken else []), *without)

    def _placed(
        self,
        source: str,
        chosen: dict[str, tuple[str, str, bool]],
        requested: Mapping[str, str],
        axis: Axis | None,
        *,
        has_place: bool,
    ) -> list[str]:
        """What is said of where the test signal enters; without a place it is not taken.

        Raises
        ------
        UsageError
            It was named and nothing says where it enters, or the other way round.
        """
        if "injected" not in chosen:
            if has_place:
                raise UsageError(
                    f"{source}: no column is the test signal that is added to the "
                    f"{self.injected_at}; name it with {_to_name(['injected'])}.",
                    code="test-signal",
                )
            return []
        name = chosen["injected"][0]
        if self.injected_at:
            return [f"{name!r} was added to the {self.injected_at}"]
        if "injected" in requested or (axis is not None and "injected" in axis.columns):
            raise UsageError(
                f"{source}: {name!r} is a test signal, but nothing says what it was added to; add "
                'injected_at = "control" or injected_at = "reference" in run.toml.',
                code="test-signal",
            )
        del chosen["injected"]
        return [f"{name!r} is left out, since nothing says whether it was added to the control"]

    def _own_clocks(self, requested: Mapping[str, str]) -> str:
        """Leave out a time column that no user named and that is of another group than the others.

        Where the file has clocks of its own they serve. What is said of it; empty where it stays.
        """
        others = {role: s for role, s in self.samples.items() if role != "time"}
        if "time" in requested or "time" not in self.samples or not _has_clocks(others.values()):
            return ""
        moving = motion_role(others)
        there, needed = len(self.samples["time"].values), len(others[moving].values)
        if there == needed:
            return ""
        name = self.names.pop("time")
        del self.samples["time"]
        return (
            f"the column {name!r} has {there} rows, the {moving} {needed}: {_CLOCKS} in its place"
        )


def _has_clocks(columns: Iterable[Samples]) -> bool:
    return all(samples.clock is not None for samples in columns)


def _choose(
    table: Table, axis: Axis | None, requested: dict[str, str], *, has_period: bool
) -> tuple[dict[str, tuple[str, str, bool]], tuple[str, ...]]:
    """Column, unit if one is given, and whether the user named it, by role; and what is missing."""
    roles = ROLES if axis is None else axis.roles
    _check_requested(requested, roles)
    declared = dict(axis.columns) if axis is not None else {}
    asked = {*requested, *declared}
    chosen: dict[str, tuple[str, str, bool]] = {}
    missing: dict[str, str] = {}
    for role in roles:
        wanted = requested.get(role) or declared.get(role) or role
        name, unit = table.find(wanted), ""
        if name is None and ":" in wanted:
            head, _, unit = wanted.rpartition(":")
            name = table.find(head.strip())
            wanted = head if name is None else wanted
        if name is not None:
            chosen[role] = (name, unit.strip(), role in requested)
        elif role in asked or role == "position" or role not in ROLES:
            missing[role] = wanted
    # What only bears the name of a measured derivative is none.
    unasked = [
        f"the column {chosen.pop(role)[0]!r} is left out, as nobody named it as the measured {role}"
        for role in _ON_REQUEST
        if role in chosen and role not in asked
    ]
    for role, (name, *_) in chosen.items():
        if holds := table.columns[name].holds:
            raise DataError(
                f"{table.source}: the column {name!r} for the {role} holds {holds}; give one of "
                f"real numbers, or of time stamps, with {_to_name([role])}.",
                code="columns",
            )
    without = _without(table, missing, chosen, has_period=has_period)
    if any(role in requested or role not in without for role in missing):
        raise _lacking(table, chosen, missing)
    _check_apart(table, chosen)
    return chosen, (*without.values(), *unasked)


def _check_requested(requested: Mapping[str, object], roles: Sequence[str]) -> None:
    """Refuse roles that there are not, and columns that are no text."""
    for role, column in requested.items():
        if role not in roles:
            raise UsageError(
                f"{role!r} is no role of a column; the roles are {', '.join(roles)}.",
                code="columns",
            )
        if not isinstance(column, str):
            raise UsageError(
                f"the column for the {role} is {quoted(column)}; give its name, or a Column.",
                code="columns",
            )


def _without(
    table: Table,
    missing: dict[str, str],
    chosen: dict[str, tuple[str, str, bool]],
    *,
    has_period: bool,
) -> dict[str, str]:
    """What is said of columns that only the axis names, and that can be done without.

    A name that several columns have is not missing, but to be told apart by the user.
    """
    timed = "time" in missing and _has_clocks(
        table.columns[name].read() for name, *_ in chosen.values()
    )
    spared = (
        ("time", has_period, "counted by the sampling period"),
        ("time", timed, _CLOCKS),
        ("control", "force" in chosen, "so the control law is not compared with the record"),
        ("position", "velocity" in chosen, "so it is the velocity's integral"),
        ("velocity", True, "so it is the position's derivative"),
        ("acceleration", True, "so it is the velocity's derivative"),
        ("reference", True, "so least squares only, no instruments"),
        ("injected", True, "so no test signal is reckoned with"),
    )
    return {
        role: f"no column {missing[role]!r} for the {role}, {what}"
        for role, is_spared, what in spared
        if is_spared and role in missing and not table.alike(missing[role])
    }


def _lacking(table: Table, chosen: Mapping[str, object], missing: dict[str, str]) -> DataError:
    """The error of all columns that are not found, with those that may be meant."""
    wanted = ", ".join(f"{name!r} for the {role}" for role, name in missing.items())
    several = [alike for name in missing.values() if len(alike := table.alike(name)) > 1]
    close = dict.fromkeys(near for name in missing.values() for near in _near(table, name))
    hint = ""
    if several:
        hint = " One name has several columns: " + "; ".join(map(", ".join, several)) + "."
    elif close:
        hint = f" Did you mean {' or '.join(map(repr, close))}?"
    usual = ("time", "reference", "control") if "position" in missing else ()
    named = [*missing, *(role for role in usual if role not in chosen and role not in missing)]
    advice = table.missing or f"Name the columns with {_to_name(named)}."
    return DataError(
        f"{table.source}: there is no column {wanted}; found {table.listed()}.{hint} {advice}",
        code="columns",
    )


def _to_name(roles: Iterable[str]) -> str:
    return f"columns {','.join(f'{role}=NAME' for role in roles)}"


def _near(table: Table, wanted: str) -> list[str]:
    """Columns whose names are nearly the one that is wanted."""
    names = {name.casefold(): name for name in list(table.columns)[:_COMPARED]}
    plain = wanted.casefold()
    close = get_close_matches(plain, names, n=2, cutoff=_MIN_NAME_SIMILARITY)
    close += [name for name in names if name.startswith((f"{plain} ", f"{plain}["))]
    return [names[name] for name in close]


def _check_apart(table: Table, chosen: dict[str, tuple[str, str, bool]]) -> None:
    """One column cannot be two things."""
    roles: dict[str, str] = {}
    for role, (name, *_) in chosen.items():
        if name in roles:
            raise DataError(
                f"{table.source}: the column {name!r} is taken for the {roles[name]} and for the "
                f"{role}; name another for one of them, with {_to_name([role])}.",
                code="columns",
            )
        roles[name] = role


def motion_role(roles: Container[str]) -> str:
    """The position, or the velocity of a log without one."""
    return next((role for role in MOTION_ROLES if role in roles), MOTION_ROLES[0])
