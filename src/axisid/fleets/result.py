"""A fleet that was identified: what is believed, what is usual, what stands out, what failed."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Belief, Checked
from axisid.presentation.blocks import (
    Block,
    Cell,
    Document,
    Heading,
    Table,
    paragraph,
    plain_text,
    text_columns,
)
from axisid.presentation.html import blocks_html
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.quoting import first_of, is_among, quoted

from .ledger import FleetRow, counts_of
from .outliers import AxisGroup, Outlier, groups_of
from .table import write_table

_MOST_SHOWN = 20  # rows of a table; all are in the file
_MOST_REASONS = 5  # logs of a verdict with what is wrong with each


def fleet_document(
    folder: str, rows: Sequence[FleetRow], groups: Sequence[AxisGroup], notes: Sequence[str] = ()
) -> Document:
    """What is believed, for each axis what is usual and what stands out, doubts, and failures."""
    heading = Heading(
        title=f"Fleet of {_logs(len(rows))}",
        facts=(
            ("logs", _statuses(rows)),
            ("verdicts", _verdicts(rows)),
            ("results", folder),
            ("work", _work(rows)),
        ),
    )
    by_axis = (block for group in groups for block in _group_blocks(group))
    doubts = (*_checks(rows), *_doubted(rows, "not believed"), *_doubted(rows, "with care"))
    said = (paragraph(*notes),) if notes else ()
    return heading, *by_axis, *_not_comparable(rows), *doubts, *_failures(rows), *said


def _statuses(rows: Sequence[FleetRow]) -> str:
    """How the logs ended: ``ok`` says nothing yet of what a result is worth."""
    told = {"ok": "identified", "skipped": "done before", "failed": "without a result"}
    return ", ".join(f"{n} {told[status]}" for status, n in counts_of(rows).items() if n)


def _verdicts(rows: Sequence[FleetRow]) -> str:
    """How many results can be believed."""
    found = Counter(row.verdict for row in rows)
    kinds: tuple[Belief, ...] = ("believed", "with care", "not believed")
    return ", ".join(f"{found[kind]} {kind}" for kind in kinds if found[kind])


def _logs(count: int) -> str:
    return "1 log" if count == 1 else f"{count} logs"


def _work(rows: Sequence[FleetRow]) -> str:
    spent = [row.seconds for row in rows if row.status == "ok"]
    return f"{np.mean(spent):.2g} s of CPU for each log" if spent else ""


def _group_blocks(group: AxisGroup) -> tuple[Block, ...]:
    if isinstance(group.usual, Missing):
        said = f"{group.axis}: {group.usual.reason}; so the sd between {_of(group)} is not told."
        return _values(group), paragraph(said)
    return (_values(group), _outliers(group))


def _of(group: AxisGroup) -> str:
    """What is held against one another."""
    return "logs" if group.machines == len(group.rows) else "machines"


def _values(group: AxisGroup) -> Table:
    """Each parameter over the logs: middle, scatter, and the deviation of one estimate."""
    values = np.array([[v.value for v in row.parameters.values()] for row in group.rows])
    own = np.array([[v.sd for v in row.parameters.values()] for row in group.rows])
    usual = None if isinstance(group.usual, Missing) else group.usual
    rows: list[tuple[Cell, ...]] = []
    for i, (name, unit) in enumerate(zip(group.names, group.units, strict=True)):
        between = "" if usual is None else f"{np.sqrt(usual.between[i, i]):.3g}"
        middle = np.median(values[:, i]) if usual is None else usual.centre[i]
        rows.append((name, unit, f"{middle:.6g}", between, f"{np.median(own[:, i]):.3g}"))
    of = _of(group)
    heads = ("parameter", "unit", "centre", f"sd between {of}", "sd of an estimate")
    title = f"{group.axis}, {_logs(len(group.rows))}"
    if of == "machines":
        title += f" of {group.machines} machines"
    if group.untold:
        title += f", {group.untold} without a serial number and so not compared"
    return Table(columns=text_columns(heads), rows=tuple(rows), title=title)


def _outliers(group: AxisGroup) -> Block:
    if not group.outliers:
        return paragraph(f"No log of {group.axis} stands out.")
    serials = {row.name: row.serial for row in group.rows}
    rows = tuple(
        (
            each.name,
            serials[each.name],
            f"{each.distance:.3g}",
            f"{each.p_value:.1e}",
            f"{each.parameter} {each.apart:+.3g}",
        )
        for each in group.outliers[:_MOST_SHOWN]
    )
    heads = ("log", "serial", "distance", "p", "furthest, in deviations")
    return Table(
        columns=text_columns(heads),
        rows=rows,
        title=f"{group.axis}: {len(group.outliers)} stand out",
        said=_more(len(group.outliers)),
    )


def _not_comparable(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    """Which logs are held against no others, since there is nothing to compare."""
    found = [row.name for row in rows if row.has_result and not row.is_comparable]
    logs = "1 log has" if len(found) == 1 else f"{len(found)} logs have"
    said = (
        f"{logs} values or deviations that are not finite, or too large to compare, and no part in "
        f"what is usual: {first_of(found)}."
    )
    return (paragraph(said),) if found else ()


def _checks(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    """Which checks fail, and of which logs."""
    found = Counter(name for row in rows for name in row.failing)
    cells = tuple(
        (name, str(count), first_of([row.name for row in rows if name in row.failing]))
        for name, count in found.most_common()
    )
    if not cells:
        return ()
    return (Table(columns=text_columns(("check that fails", "logs", "which")), rows=cells),)


def _doubted(rows: Sequence[FleetRow], verdict: Belief) -> tuple[Block, ...]:
    """The logs of a verdict, each with what the gravest of its checks says."""
    found = [row for row in rows if row.verdict == verdict]
    if not found:
        return ()
    lines = [f"{row.name}: {row.failing[0]}: {row.doubt}" for row in found[:_MOST_REASONS]]
    title = f"{verdict.capitalize()}: {_logs(len(found))}"
    return (paragraph(*map(_ended, lines), *_more(len(found), _MOST_REASONS), title=title),)


def _ended(text: str) -> str:
    """A sentence with its full stop."""
    return text if text.endswith(".") else f"{text.removesuffix(': ')}."


def _failures(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    failed = [row for row in rows if not row.has_result]
    if not failed:
        return ()
    lines = [_with_log(row) for row in failed[:_MOST_SHOWN]]
    title = f"Without a result: {_logs(len(failed))}"
    return (paragraph(*lines, *_more(len(failed)), title=title),)


def _with_log(row: FleetRow) -> str:
    """A reason with the path of its log, which it may begin with."""
    return row.reason if row.reason.startswith(row.log) else f"{row.log}: {row.reason}"


def _more(count: int, shown: int = _MOST_SHOWN) -> tuple[str, ...]:
    left = count - shown
    return (f"and {left} more, which the table of the fleet has.",) if left > 0 else ()


@dataclass(frozen=True, kw_only=True)
class Fleet(Checked):
    """What became of the logs of a fleet.

    Attributes
    ----------
    folder : str
        Of the results.
    rows : tuple of FleetRow
        In the order in which the logs were named.
    notes : tuple of str
        What is said of the folder: lines that cannot be read, results of other logs.
    """

    folder: str
    rows: tuple[FleetRow, ...]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[FleetRow]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> FleetRow:
        """A row by the name of its result."""
        found = {row.name: row for row in self.rows}
        if not is_among(name, found):
            raise UsageError(
                f"the fleet has no log {quoted(name)}; name one of {first_of(list(found))}, or "
                "take one of fleet.rows by its place.",
                code="fleet",
            )
        return found[name]

    def __str__(self) -> str:
        return self.summary()

    @property
    def counts(self) -> dict[str, int]:
        """How many logs there are of each status."""
        return counts_of(self.rows)

    @property
    def failed(self) -> tuple[FleetRow, ...]:
        """The rows without a result, each with its reason."""
        return tuple(row for row in self.rows if not row.has_result)

    @cached_property
    def groups(self) -> tuple[AxisGroup, ...]:
        """The logs with a result by axis, with what is usual among them."""
        return groups_of(self.rows)

    @property
    def outliers(self) -> tuple[Outlier, ...]:
        """The logs whose parameters are not those of the others, the furthest first."""
        found = (each for group in self.groups for each in group.outliers)
        return tuple(sorted(found, key=lambda each: each.p_value))

    @property
    def checks(self) -> tuple[Check, ...]:
        """What fails in any log, of how many, and whether any stands out; a row has its own."""
        found = dict.fromkeys(check.name for row in self.rows for check in row.checks)
        by_name = {n: [r.name for r in self.rows if n in (c.name for c in r.checks)] for n in found}
        out = first_of([each.name for each in self.outliers])
        return (
            *(
                Check.unless(name, f"fails in {len(logs)} of {len(self)}: {first_of(logs)}")
                for name, logs in by_name.items()
            ),
            Check.unless("outlying logs", out and f"stand out: {out}", "no log stands out"),
        )

    def summary(self) -> str:
        """Counts, what is usual, what stands out, and what failed, as text."""
        return plain_text(self.document())

    def _repr_html_(self) -> str:
        """For notebooks."""
        return blocks_html(self.document())

    def document(self) -> Document:
        """The same in blocks."""
        return fleet_document(self.folder, self.rows, self.groups, self.notes)

    def write(self, file: str | Path | None = None) -> Path:
        """Write the table of all logs, a row for each.

        Parameters
        ----------
        file : str or Path, optional
            Ends in ``.parquet``, ``.csv`` or ``.npz``; by default ``fleet.parquet`` in the folder
            of the results, or ``fleet.csv`` where pyarrow is not installed.

        Returns
        -------
        Path
            What was written.

        Raises
        ------
        UsageError
            The ending is another one, or the place cannot be written to.
        """
        place = None if file is None else Path(file)
        return write_table(self.rows, self.outliers, Path(self.folder), place)
