"""What a trend looks like as text: limits, results beyond them, steps, drifts."""

from collections.abc import Sequence

import numpy as np

from axisid.populations import Drift
from axisid.presentation.blocks import (
    Block,
    Cell,
    Document,
    Heading,
    Table,
    paragraph,
    text_columns,
)
from axisid.presentation.formulas import range_text
from axisid.support.missing import Missing

from .chart import Chart
from .series import Series

_MOST_SHOWN = 20  # series without a change, which say little


def trend_document(series: Sequence[Series], by: str) -> Document:
    """Each series: its parameters with limits, and what changed; those that changed first."""
    changed = [each for each in series if each.has_changed]
    others = [each for each in series if not each.has_changed]
    results = sum(len(each.points) for each in series)
    heading = Heading(
        title="Trend",
        facts=(
            ("results", str(results)),
            ("series", f"{len(series)}, {len(changed)} with a change"),
            ("order", by or "as the files are named"),
        ),
    )
    shown = (*changed, *others[:_MOST_SHOWN])
    blocks = (block for each in shown for block in _series_blocks(each, by))
    left = len(others) - _MOST_SHOWN
    more = (paragraph(f"and {left} more series without a change."),) if left > 0 else ()
    return heading, *blocks, *more


def _series_blocks(series: Series, by: str) -> tuple[Block, ...]:
    said = [line for chart in series.charts for line in _changes(series, chart, by)]
    methods = dict.fromkeys(point.method.upper() for point in series.points)
    results = "1 result" if len(series.points) == 1 else f"{len(series.points)} results"
    table = Table(
        columns=text_columns(
            ("parameter", "unit", "centre", "sd between", "sd of the last", "limits of the last")
        ),
        rows=tuple(map(_row, series.charts)),
        title=f"{series.title}, {results} by {' and '.join(methods)}",
    )
    if len(methods) > 1:
        said.append("The results are judged by different methods, which may differ: choose one.")
    if len({point.signature for point in series.points}) > 1:
        said.append("The results are of different models of that name, whose values may differ.")
    said += _failing(series)
    return table, paragraph(*(said or ["Nothing beyond the limits, no step and no drift."]))


def _failing(series: Series) -> list[str]:
    """Which results have a verdict that fails, and by which checks."""
    failing = [point for point in series.points if point.failing]
    if not failing:
        return []
    shown = "; ".join(f"{p.name} ({', '.join(p.failing)})" for p in failing[:_MOST_SHOWN])
    left = len(failing) - _MOST_SHOWN
    more = f"; and {left} more" if left > 0 else ""
    what = "set no limits and tell no change" if series.set_aside else "count like the others"
    return [
        f"The verdict fails of {len(failing)} of {len(series.points)} results, which {what} and "
        f"may be wrong: {shown}{more}."
    ]


def _row(chart: Chart) -> tuple[Cell, ...]:
    own = f"{chart.deviations[-1]:.3g}"
    if isinstance(chart.limits, Missing):
        return chart.parameter, chart.unit, f"{np.median(chart.values):.6g}", "", own, ""
    limits = chart.limits
    return (
        chart.parameter,
        chart.unit,
        f"{limits.centre[-1]:.6g}",
        f"{limits.between:.3g}",
        own,
        range_text(limits.lower[-1], limits.upper[-1]),
    )


def _changes(series: Series, chart: Chart, by: str) -> list[str]:
    """What is said of a parameter."""
    said = []
    if isinstance(chart.limits, Missing):
        said.append(f"{chart.parameter}: {chart.limits.reason}.")
    said += [
        f"{chart.parameter} steps by {step.difference:+.4g} +- {step.deviation:.2g} {chart.unit} "
        f"from {series.points[step.place].name} on (p {step.p_value:.2g})."
        for step in chart.steps
    ]
    if chart.drift is not None:
        said.append(_drift(series, chart, chart.drift, by))
    if chart.beyond:
        names = ", ".join(series.points[place].name for place in chart.beyond)
        said.append(f"{chart.parameter} is beyond its limits in {names}.")
    return said


def _drift(series: Series, chart: Chart, drift: Drift, by: str) -> str:
    """How fast a parameter drifts, and how far it has."""
    of = "day" if series.origin(by) else f"unit of {by}" if by else "result"
    whole = drift.line[-1] - drift.line[0]
    return (
        f"{chart.parameter} drifts by {drift.slope:+.3g} +- {drift.deviation:.2g} {chart.unit} for "
        f"each {of}, {whole:+.3g} {chart.unit} in all (p {drift.p_value:.2g})."
    )
