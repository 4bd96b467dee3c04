"""Result of a fleet: verdicts, statistics of the parameters, outliers, failures.

A log is an outlier if its parameters differ from the parameters of the other logs by more than the
scatter between logs and the standard errors explain. The table of a fleet has a row for each log,
as Parquet, CSV or NumPy arrays.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import UNITS_ENTRY, split_labels
from axisid.estimation.thresholds import FLEET_LEVEL
from axisid.estimation.verdict_checks import Belief, Check, Checked
from axisid.presentation.documents import (
    Block,
    Document,
    Heading,
    paragraph,
    text_table,
)
from axisid.presentation.result_files import schema_of
from axisid.support.arrays import Array
from axisid.support.checks import is_among
from axisid.support.errors import UsageError
from axisid.support.files import csv_text, write_by_ending
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.presentable import Shown
from axisid.support.table_bytes import npz_bytes, parquet_bytes
from axisid.support.wording import first_of, quoted

from .ledger import FleetRow, FleetValue, unchecked_of
from .robust_statistics import RandomEffects, detect_outliers, spread_of

_MIN_LOGS_PER_PARAMETER = 5  # with fewer, half of the logs are too few to estimate the scatter
_FAR = 1e3  # median absolute deviations; values further out do not count for the rank


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlier:
    """A log whose parameters differ from the parameters of the other logs.

    Attributes
    ----------
    name : str
        Name of the row.
    distance : float
        Mahalanobis distance of all parameters from the centre, in standard deviations.
    p_value : float
        Probability of an equal or larger distance for a log that is not an outlier.
    parameter : str
        Parameter that alone has the largest distance from the centre.
    apart : float
        Distance of this parameter from the centre, in standard deviations, with its sign.
    """

    name: str
    distance: float
    p_value: float
    parameter: str
    apart: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisGroup:
    """Logs of one axis with the same parameters.

    Attributes
    ----------
    axis : str
    names, units : tuple of str
        Names and units of the parameters.
    rows : tuple of FleetRow
    machines : int
        Number of machines that are compared. Each log counts as one machine, unless serial numbers
        show that machines have several logs.
    untold : int
        Number of logs that are not compared, because they have no serial number.
    usual : RandomEffects or Missing
        Centre and scatter of the parameters of machines that are not outliers; Missing, with the
        reason, if they cannot be estimated.
    outliers : tuple of Outlier
        Outliers, the furthest first.
    """

    axis: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[FleetRow, ...]
    machines: int
    untold: int
    usual: RandomEffects | Missing
    outliers: tuple[Outlier, ...]


def groups_of(rows: Iterable[FleetRow]) -> tuple[AxisGroup, ...]:
    """Return the rows with a comparable result, in groups of the same axis and parameters."""
    found = grouped(
        ((row.axis, tuple(row.parameters)), row)
        for row in rows
        if row.has_result and row.is_comparable
    )
    groups = []
    for (axis, names), each in found.items():
        machines = _machines(each)
        usual, outliers = _judged(names, machines)
        groups.append(
            AxisGroup(
                axis=axis,
                names=names,
                units=tuple(value.unit for value in each[0].parameters.values()),
                rows=tuple(each),
                machines=len(machines),
                untold=len(each) - sum(map(len, machines)),
                usual=usual,
                outliers=outliers,
            )
        )
    return tuple(groups)


def _machines(rows: Sequence[FleetRow]) -> list[list[FleetRow]]:
    """Return the rows of each machine, a list of lists; often each row is a machine of its own.

    Logs of one machine share its deviation from other machines. If these logs counted as separate
    machines, the other machines would become outliers. So logs are grouped by serial number if
    there are several machines of which one has several logs; a log without a serial number is then
    excluded. Otherwise each log counts as a machine, and logs of a single machine are compared with
    one another.
    """
    found = grouped((row.serial, row) for row in rows)
    by_serial = [each for serial, each in found.items() if serial]
    if len(by_serial) > 1 and max(map(len, by_serial)) > 1:
        return by_serial
    return [[row] for row in rows]


def _judged(
    names: Sequence[str], machines: Sequence[Sequence[FleetRow]]
) -> tuple[RandomEffects | Missing, tuple[Outlier, ...]]:
    """Return the random effects of the machines' parameters, and the outliers.

    With too few machines, or values without scatter in some direction, the effects are Missing,
    with the reason. All logs of an outlying machine are outliers.
    """
    # Mean of the parameters of each machine, (n, p).
    values = np.array(
        [np.mean([[v.value for v in r.parameters.values()] for r in each], 0) for each in machines]
    )
    least, logs = _MIN_LOGS_PER_PARAMETER * max(len(names), 1), sum(map(len, machines))
    if len(machines) < least:
        count, enough = "1 log is" if logs == 1 else f"{logs} logs are", f"{least}"
        if logs > len(machines):
            count, enough = f"{logs} logs of {len(machines)} machines are", f"{least} machines"
        each = f"{_MIN_LOGS_PER_PARAMETER} for each parameter"
        return Missing(
            f"{count} too few to find outliers; at least {enough} are needed, {each}"
        ), ()
    if not _is_spread(values):
        return Missing("the values of the logs span fewer dimensions than there are parameters"), ()
    covariances = np.array(
        [np.mean([row.covariance for row in each], axis=0) / len(each) for each in machines]
    )
    detected = detect_outliers(values, covariances, FLEET_LEVEL.value)
    outliers = []
    for i in detected.far:
        scatter = np.sqrt(np.diag(detected.usual.between + covariances[i]))
        scores = (values[i] - detected.usual.centre) / scatter
        furthest = int(np.argmax(np.abs(scores)))
        outliers += [
            Outlier(
                name=row.name,
                distance=float(np.sqrt(detected.distances[i])),
                p_value=float(detected.p_values[i]),
                parameter=names[furthest],
                apart=float(scores[furthest]),
            )
            for row in machines[i]
        ]
    return detected.usual, tuple(outliers)


def _is_spread(values: Array) -> bool:
    """Return True if values, (n, p), scatter in all p dimensions."""
    spread = spread_of(values)
    if not spread.size or not spread.all():
        return False
    scores = (values - np.median(values, axis=0)) / spread
    # At the scale of values that are far away, all other values would be one point.
    near = scores[np.all(np.abs(scores) < _FAR, axis=1)]
    return bool(len(near) and np.linalg.matrix_rank(near - near.mean(axis=0)) == values.shape[1])


#: Default names of the table: with pyarrow, and without.
TABLES = ("fleet.parquet", "fleet.csv")
#: Numbers of a parameter, by the ending of their column's name.
_FIGURES: dict[str, Callable[[FleetValue], float]] = {
    "": lambda v: v.value,
    ".sd": lambda v: v.sd,
    ".low": lambda v: v.interval_95[0],
    ".high": lambda v: v.interval_95[1],
}
#: The table by column.
Columns = dict[str, list[str | float | None]]
_MOST_SHOWN = 20  # rows of a table on the screen; the file has all rows
_MOST_REASONS = 5  # logs that are listed with the reason for a verdict
#: Words of the headline of a result, by verdict.
_HEADLINES: dict[Belief, str] = {
    "believed": "all checks passed",
    "with care": "use with care",
    "not believed": "do not use",
}


def _listed(lines: Sequence[str], title: str, most: int) -> Block:
    """Return a paragraph of the first `most` lines, and the number of further lines."""
    return paragraph(*lines[:most], *_more(len(lines), most), title=title)


def _counted(found: Iterable[str], kinds: Iterable[str]) -> str:
    """Return the number of each kind that occurs, as text: ``3 identified, 1 without a result``."""
    count = Counter(found)
    return ", ".join(f"{count[kind]} {kind}" for kind in kinds if count[kind])


def _logs(count: int) -> str:
    """Return a number of logs as text: ``1 log``, ``2 logs``."""
    return "1 log" if count == 1 else f"{count} logs"


def _group_blocks(group: AxisGroup) -> tuple[Block, ...]:
    """Return the table of a group's parameters, and the table of its outliers.

    The first table has the typical value (robust centre, or median), the standard deviation between
    logs or machines, and the median standard error of an estimate.
    """
    values = np.array([[v.value for v in row.parameters.values()] for row in group.rows])
    own = np.array([[v.sd for v in row.parameters.values()] for row in group.rows])
    middles, between = np.median(values, axis=0), [""] * len(group.names)
    if not isinstance(group.usual, Missing):
        middles = group.usual.centre
        between = [f"{sd:.3g}" for sd in np.sqrt(np.diag(group.usual.between))]
    figures = zip(middles, between, np.median(own, axis=0), strict=True)
    rows = tuple(
        (name, unit, f"{middle:.6g}", scatter, f"{sd:.3g}")
        for name, unit, (middle, scatter, sd) in zip(group.names, group.units, figures, strict=True)
    )
    of = "logs" if group.machines == len(group.rows) else "machines"
    table = text_table(
        ("parameter", "unit", "typical value", f"sd between {of}", "standard error"),
        rows,
        title=f"{group.axis}, {_logs(len(group.rows))}"
        + f" of {group.machines} machines" * (of == "machines")
        + f", {group.untold} without a serial number not compared" * bool(group.untold),
        said=(
            f"typical value: robust centre of the values, or their median if the sd between {of} "
            "is not estimated. standard error: median of the standard errors of the results.",
        ),
    )
    if isinstance(group.usual, Missing):
        reason = f"{group.axis}: {group.usual.reason}. No sd between {of} is estimated."
        return table, paragraph(reason)
    if not group.outliers:
        return table, paragraph(f"No log of {group.axis} is an outlier.")
    serials, count = {row.name: row.serial for row in group.rows}, len(group.outliers)
    return table, text_table(
        ("log", "serial", "distance, in sd", "p", "largest deviation, in sd"),
        (
            (
                each.name,
                serials[each.name],
                f"{each.distance:.3g}",
                f"{each.p_value:.1e}",
                f"{each.parameter} {each.apart:+.3g}",
            )
            for each in group.outliers[:_MOST_SHOWN]
        ),
        title=f"{group.axis}: {count} outlier" + "s" * (count > 1),
        said=_more(count),
    )


def _more(count: int, shown: int = _MOST_SHOWN) -> tuple[str, ...]:
    """Return a line on the rows that a table does not show; empty if it shows all `count` rows."""
    left = count - shown
    return (f"and {left} more, see the table of the fleet.",) if left > 0 else ()


@dataclass(frozen=True, kw_only=True)
class Fleet(Checked, Shown):
    """Results of all logs of a fleet.

    Attributes
    ----------
    folder : str
        Folder of the results.
    rows : tuple of FleetRow
        A row for each log, in the order in which the logs were named.
    notes : tuple of str
        Sentences on the folder, such as on lines of the ledger that cannot be read.
    """

    folder: str
    rows: tuple[FleetRow, ...]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[FleetRow]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> FleetRow:
        """Return a row by the name of its result."""
        found = {row.name: row for row in self.rows}
        if not is_among(name, found):
            raise UsageError(
                f"the fleet has no log {quoted(name)}. Name one of {first_of(list(found))}, or "
                "select a row of fleet.rows by its index.",
                code="fleet",
            )
        return found[name]

    @property
    def counts(self) -> dict[str, int]:
        """Return the number of logs of each status."""
        found = Counter(row.status for row in self.rows)
        return {status: found[status] for status in ("ok", "skipped", "failed")}

    @property
    def failed(self) -> tuple[FleetRow, ...]:
        """Return the rows without a result, each with its reason."""
        return tuple(row for row in self.rows if not row.has_result)

    @cached_property
    def groups(self) -> tuple[AxisGroup, ...]:
        """Return the logs with a result in groups of the same axis and parameters."""
        return groups_of(self.rows)

    @property
    def outliers(self) -> tuple[Outlier, ...]:
        """Return the outliers of all groups, by rising p-value."""
        found = (each for group in self.groups for each in group.outliers)
        return tuple(sorted(found, key=lambda each: each.p_value))

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the checks of the fleet.

        These are each check that fails in a log, with the number of such logs; the check *outlying
        logs*; and each check that could not be made in a log.
        """
        found = grouped(
            (check.name, row.name)
            for row in self.rows
            for check in row.checks
            if check.status == "fail"
        )
        out = first_of([each.name for each in self.outliers])
        return (
            *(
                Check.unless(name, f"fails in {len(logs)} of {len(self)} logs: {first_of(logs)}")
                for name, logs in found.items()
            ),
            Check.unless("outlying logs", out and f"outliers: {out}", "no log is an outlier"),
            *unchecked_of(self.rows),
        )

    def document(self) -> Document:
        """Return the fleet as a document: verdicts, parameters, outliers, failures."""
        # The status "ok" would read like a verdict.
        statuses = {
            "ok": "identified",
            "skipped": "kept from an earlier run",
            "failed": "without a result",
        }
        spent = [row.seconds for row in self if row.status == "ok"]
        headlines = [_HEADLINES[row.verdict] for row in self if row.verdict]
        heading = Heading(
            title=f"Fleet of {_logs(len(self))}",
            facts={
                "logs": _counted((statuses[row.status] for row in self), statuses.values()),
                "verdicts": ", ".join(
                    f"{headline}: {_logs(headlines.count(headline))}"
                    for headline in _HEADLINES.values()
                    if headline in headlines
                ),
                "folder": self.folder,
                "CPU time": f"{np.mean(spent):.2g} s per log" if spent else "",
            },
        )
        blocks: list[Block] = [heading, *(b for group in self.groups for b in _group_blocks(group))]
        if odd := [row.name for row in self if row.has_result and not row.is_comparable]:
            excluded = f"{_logs(len(odd))} {'is' if len(odd) == 1 else 'are'} excluded"
            note = (
                f"{excluded} from the statistics, because values or standard errors are not finite "
                f"or too large to compare: {first_of(odd)}."
            )
            blocks.append(paragraph(note))
        if failing := grouped((name, row.name) for row in self for name in row.failing):
            most = sorted(failing.items(), key=lambda each: -len(each[1]))
            blocks.append(
                text_table(
                    ("failed check", "number of logs", "logs"),
                    ((name, str(len(logs)), first_of(logs)) for name, logs in most),
                )
            )
        for verdict in ("not believed", "with care"):
            if doubted := [row for row in self if row.verdict == verdict]:
                lines = [f"{row.name}: {row.checks[0].name}: {row.doubt}" for row in doubted]
                ended = [
                    each if each.endswith(".") else f"{each.removesuffix(': ')}." for each in lines
                ]
                title = f"{_HEADLINES[verdict].capitalize()}: {_logs(len(doubted))}"
                blocks.append(_listed(ended, title, _MOST_REASONS))
        if self.failed:
            lines = [
                row.reason if row.reason.startswith(row.log) else f"{row.log}: {row.reason}"
                for row in self.failed
            ]
            blocks.append(_listed(lines, f"Without a result: {_logs(len(lines))}", _MOST_SHOWN))
        if self.notes:
            blocks.append(paragraph(*self.notes))
        return tuple(blocks)

    def write(self, file: str | Path | None = None) -> Path:
        """Write the table with a row for each log, and return the file.

        Parameters
        ----------
        file : str or Path, optional
            File that ends in ``.parquet``, ``.csv`` or ``.npz``; by default ``fleet.parquet`` in
            the folder of the results, or ``fleet.csv`` if pyarrow is not installed.

        Returns
        -------
        Path
            File written.

        Raises
        ------
        UsageError
            The ending is another one, or the file cannot be written.
        """
        default = Path(self.folder, TABLES[find_spec("pyarrow") is None])
        place = default if file is None else Path(file)
        columns, units = columns_of(self.rows, self.outliers)
        # The name of a condition may contain its unit already.
        heads = [
            f"{name} [{units[name]}]" if name in units and name[-1] not in "])" else name
            for name in columns
        ]

        def arrays() -> dict[str, Any]:
            return {
                name: np.array(["" if cell is None else cell for cell in cells])
                if any(isinstance(cell, str) for cell in cells)
                else np.array(cells, dtype=np.float64)
                for name, cells in columns.items()
            }

        writers: dict[str, Callable[[], str | bytes]] = {
            ".parquet": lambda: parquet_bytes(
                columns, units, {"axisid": schema_of(FleetRow)}, place
            ),
            ".csv": lambda: csv_text([heads, *zip(*columns.values(), strict=True)]),
            ".npz": lambda: npz_bytes({**arrays(), UNITS_ENTRY: json.dumps(units)}),
        }
        return write_by_ending(place, writers, f"the table is {quoted(str(place))}", "fleet")


def columns_of(
    rows: Sequence[FleetRow], outliers: Sequence[Outlier]
) -> tuple[Columns, dict[str, str]]:
    """Return the table, a list of cells by column, and the units of the columns that have one.

    The columns are the description of a log, its status, conditions, parameters, its distance from
    the centre if it is an outlier, and the CPU time.
    """
    out = {each.name: each for each in outliers}
    units = {"outlier_distance": "1", "outlier_p": "1", "seconds": "s"}
    columns: Columns = {
        name: [getattr(row, name) for row in rows]
        for name in "name log axis serial status reason code method verdict".split()
    }
    columns["failing"] = ["; ".join(row.failing) for row in rows]
    columns["unchecked"] = ["; ".join(row.unchecked) for row in rows]
    for name in dict.fromkeys(name for row in rows for name in row.conditions):
        values = [row.conditions.get(name) for row in rows]
        # A column has one type: numbers if all values are numbers, otherwise texts.
        numeric = all(value is None or isinstance(value, float) for value in values)
        columns[f"condition.{name}"] = [v if v is None or numeric else str(v) for v in values]
        if unit := split_labels([name])[0][1]:
            units[f"condition.{name}"] = unit
    for name in dict.fromkeys(name for row in rows for name in row.parameters):
        found = [row.parameters.get(name) for row in rows]
        names = [f"{name}{ending}" for ending in _FIGURES]
        for column, figure in zip(names, _FIGURES.values(), strict=True):
            columns[column] = [None if v is None else figure(v) for v in found]
        own = {v.unit for v in found if v is not None}
        if len(own) > 1:  # different axes use the name for different quantities
            columns[f"{name}.unit"] = [None if v is None else v.unit for v in found]
        elif own != {""}:
            units |= dict.fromkeys(names, own.pop())
    for column, attribute in (("outlier_distance", "distance"), ("outlier_p", "p_value")):
        columns[column] = [getattr(out.get(row.name), attribute, None) for row in rows]
    columns["seconds"] = [row.seconds for row in rows]
    return columns, units
