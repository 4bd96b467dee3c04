"""What a fleet looks like: counts, what is usual, what stands out, what failed."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from axisid.presentation.blocks import (
    Block,
    Cell,
    Document,
    Heading,
    Table,
    paragraph,
    text_columns,
)
from axisid.support.missing import Missing

from .outliers import AxisGroup
from .row import FleetRow, counts_of

_MOST_SHOWN = 20  # rows of a table; all are in the file


def fleet_document(folder: str, rows: Sequence[FleetRow], groups: Sequence[AxisGroup]) -> Document:
    """Counts, for each axis what is usual and what stands out, checks that fail, and failures."""
    told = ", ".join(f"{n} {status}" for status, n in counts_of(rows).items() if n)
    heading = Heading(
        title=f"Fleet of {_logs(len(rows))}",
        facts=(("status", told), ("results", folder), ("work", _work(rows))),
    )
    by_axis = (block for group in groups for block in _group_blocks(group))
    return heading, *by_axis, *_not_finite(rows), *_checks(rows), *_failures(rows)


def _logs(count: int) -> str:
    return "1 log" if count == 1 else f"{count} logs"


def _work(rows: Sequence[FleetRow]) -> str:
    spent = [row.seconds for row in rows if row.status == "ok"]
    return f"{np.mean(spent):.2g} s of CPU for each log" if spent else ""


def _group_blocks(group: AxisGroup) -> tuple[Block, ...]:
    if isinstance(group.usual, Missing):
        said = f"{group.axis}: {group.usual.reason}."
        return _values(group), paragraph(said)
    return (_values(group), _outliers(group))


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
    heads = ("parameter", "unit", "centre", "sd between logs", "sd of an estimate")
    return Table(
        columns=text_columns(heads),
        rows=tuple(rows),
        title=f"{group.axis}, {_logs(len(group.rows))}",
    )


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


def _not_finite(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    """How many logs are held against no others, since there is nothing to compare."""
    count = sum(row.has_result and not row.is_finite for row in rows)
    logs = "1 log has" if count == 1 else f"{count} logs have"
    said = f"{logs} values that are not finite, and no part in what is usual."
    return (paragraph(said),) if count else ()


def _checks(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    """Which checks fail, and of how many logs."""
    found = Counter(name for row in rows for name in row.failing)
    if not found:
        return ()
    cells = tuple((name, str(count)) for name, count in found.most_common())
    return (Table(columns=text_columns(("check that fails", "logs")), rows=cells),)


def _failures(rows: Sequence[FleetRow]) -> tuple[Block, ...]:
    failed = [row for row in rows if not row.has_result]
    if not failed:
        return ()
    lines = [f"{row.log}: {row.reason}" for row in failed[:_MOST_SHOWN]]
    return (paragraph(*lines, *_more(len(failed)), title="Without a result"),)


def _more(count: int) -> tuple[str, ...]:
    left = count - _MOST_SHOWN
    return (f"and {left} more, which the table of the fleet has.",) if left > 0 else ()
