"""What a trend looks like as text: limits, results beyond them, steps."""

from collections.abc import Sequence

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
    blocks = (block for each in shown for block in _series_blocks(each))
    left = len(others) - _MOST_SHOWN
    more = (paragraph(f"and {left} more series without a change."),) if left > 0 else ()
    return heading, *blocks, *more


def _series_blocks(series: Series) -> tuple[Block, ...]:
    said = [line for chart in series.charts for line in _changes(series, chart)]
    methods = dict.fromkeys(point.method.upper() for point in series.points)
    table = Table(
        columns=text_columns(
            ("parameter", "unit", "centre", "sd between", "sd of a result", "limits of the last")
        ),
        rows=tuple(map(_row, series.charts)),
        title=f"{series.title}, {len(series.points)} results by {' and '.join(methods)}",
    )
    if len(methods) > 1:
        said.append("The results are judged by different methods, which may differ: choose one.")
    return table, paragraph(*(said or ["Nothing beyond the limits, and no step."]))


def _row(chart: Chart) -> tuple[Cell, ...]:
    own = f"{chart.deviations[-1]:.3g}"
    if isinstance(chart.limits, Missing):
        return chart.parameter, chart.unit, f"{chart.values[-1]:.6g}", "", own, ""
    limits = chart.limits
    return (
        chart.parameter,
        chart.unit,
        f"{limits.centre:.6g}",
        f"{limits.between:.3g}",
        own,
        f"{limits.lower[-1]:.4g} .. {limits.upper[-1]:.4g}",
    )


def _changes(series: Series, chart: Chart) -> list[str]:
    """What is said of a parameter."""
    said = []
    if isinstance(chart.limits, Missing):
        said.append(f"{chart.parameter}: {chart.limits.reason}.")
    said += [
        f"{chart.parameter} steps by {step.difference:+.4g} +- {step.deviation:.2g} {chart.unit} "
        f"from {series.points[step.place].name} on (p {step.p_value:.2g})."
        for step in chart.steps
    ]
    if chart.beyond:
        names = ", ".join(series.points[place].name for place in chart.beyond)
        said.append(f"{chart.parameter} is beyond its limits in {names}.")
    return said
