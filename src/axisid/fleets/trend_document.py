"""Document of a trend: text, and a page with a figure of each series."""

import base64
from collections.abc import Sequence
from html import escape
from string import Template

import numpy as np
from numpy.typing import NDArray

from axisid.presentation.documents import (
    Block,
    Cell,
    Document,
    Heading,
    blocks_html,
    paragraph,
    text_table,
)
from axisid.presentation.plots import Panel, Plot, PlotSeries, Tone, labelled
from axisid.support.arrays import Array
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.settings import setting
from axisid.support.version import __version__
from axisid.support.wording import first_of, range_text

from .robust_statistics import LARGEST
from .series import Chart, Series, notable_first

_MOST_SHOWN = 20  # series without a change, and results that a sentence names
_MOST_DRAWN = 50  # series; those with a change first
_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="axisid $version">
<title>$title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2328; background: #fff;
  max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 0.5rem 0; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: 0.5rem 0; }
th, td { padding: 0.2rem 0.8rem 0.2rem 0; border-bottom: 1px solid #e3e5e8; text-align: right; }
th:first-child, td:first-child { text-align: left; }
dl { display: grid; grid-template-columns: max-content auto; gap: 0 1rem; }
dd { margin: 0; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; }
</style>
</head>
<body>
<main>
$text
$figures
</main>
</body>
</html>
""")


def trend_document(series: Sequence[Series], by: str, notes: Sequence[str] = ()) -> Document:
    """Return a trend as a document: a table of all series, then a section for each series.

    Series with a change come first. Each section has a table of limits, and sentences on changes.
    Only 20 series without a change are shown. `by` is the condition that orders the results; empty
    for the given order.
    """
    ordered = notable_first(series)
    notable = sum(each.has_changed or each.has_beyond for each in ordered)
    changed = sum(each.has_changed for each in series)
    beyond = notable - changed
    also = f", {beyond} {'more ' if changed else ''}with results beyond the limits"
    heading = Heading(
        title="Trend",
        facts={
            "results": str(sum(len(each.points) for each in series)),
            "series": f"{len(series)}, {changed} with a step or a drift{also * bool(beyond)}",
            "order": by or "order of the files",
        },
    )
    shown = ordered[: notable + _MOST_SHOWN]
    blocks = (block for each in shown for block in _series_blocks(each, by))
    left = len(ordered) - len(shown)
    more = (f"and {left} more series without a change.",) if left > 0 else ()
    end = (paragraph(*more, *notes),) if more or notes else ()
    rows = []
    for each in shown:
        steps = (chart.parameter for chart in each.charts if chart.steps)
        drifts = (chart.parameter for chart in each.charts if chart.drift is not None)
        far = (f"{chart.parameter} {len(chart.beyond)}" for chart in each.charts if chart.beyond)
        changes = [", ".join(names) for names in (steps, drifts, far)]
        failing = sum(bool(point.failing) for point in each.points)
        rows.append((each.title, str(len(each.points)), *changes, str(failing or "")))
    overview = text_table(
        ("series", "results", "steps", "drifts", "beyond limits", "with failed checks"), rows
    )
    tables = [overview] if len(shown) > 1 else []
    return heading, *tables, *blocks, *end


def _series_blocks(series: Series, by: str) -> tuple[Block, ...]:
    """Return the table of parameters and limits of a series, and sentences on it.

    The sentences report missing limits, steps, drifts, results beyond limits, and reasons why the
    results may not be comparable.
    """
    points = series.points
    without = grouped(
        (chart.limits.reason, chart.parameter)
        for chart in series.charts
        if isinstance(chart.limits, Missing)
    )
    sentences = [f"{', '.join(names)}: {reason}." for reason, names in without.items()]
    # A slope is per day, per unit of the condition, or per result.
    per = "result"
    if by:
        per = f"unit of {by}"
    if series.origin(by):
        per = "day"
    for chart in series.charts:
        name, unit, drift = chart.parameter, chart.unit, chart.drift
        sentences += [
            f"{name} steps by {step.difference:+.4g} +- {step.deviation:.2g} {unit} at "
            f"{points[step.place].name} (p = {step.p_value:.2g})."
            for step in chart.steps
        ]
        if drift is not None:
            sentences.append(
                f"{name} drifts by {drift.slope:+.3g} +- {drift.deviation:.2g} {unit} per {per}, "
                f"{drift.line[-1] - drift.line[0]:+.3g} {unit} in total (p = "
                f"{drift.p_value:.2g})."
            )
        if chart.beyond:
            beyond = first_of([points[place].name for place in chart.beyond], _MOST_SHOWN)
            sentences.append(f"{name} is beyond its limits in {beyond}.")
    methods = dict.fromkeys(point.method.upper() for point in points)
    results = "1 result" if len(points) == 1 else f"{len(points)} results"
    table = text_table(
        (
            "parameter",
            "unit",
            "typical value",
            "sd between results",
            "sd of last",
            "limits of last",
        ),
        map(_row, series.charts),
        title=f"{series.title}, {results} by {' and '.join(methods)}",
    )
    failing = [f"{p.name} ({', '.join(p.failing)})" for p in points if p.failing]
    use = "are used for limits and changes"
    if any(points[i].failing for i in series.set_aside):
        use = "are excluded from limits and changes"
    odd = [point.name for point in points if not point.is_comparable]
    doubts = (
        (
            len(methods) > 1,
            "The verdicts judge estimates of different methods, whose values may differ. Select "
            f"one method with {setting('method', 'METHOD')}.",
        ),
        (
            len({point.signature for point in points}) > 1,
            "The results come from different models of the same name. Their values may differ.",
        ),
        (
            failing,
            f"{len(failing)} of {len(points)} results have failed checks. These results {use} and "
            f"may be wrong: {first_of(failing, _MOST_SHOWN)}.",
        ),
        (
            odd,
            "Results with values or standard errors that are not finite, or too large to compare, "
            f"are excluded from limits and changes: {first_of(odd, _MOST_SHOWN)}.",
        ),
    )
    sentences += [doubt for is_so, doubt in doubts if is_so]
    if not sentences:
        sentences = ["No result is beyond the limits. There is no step and no drift."]
    return table, paragraph(*sentences)


def _row(chart: Chart) -> tuple[Cell, ...]:
    """Return the row of a parameter: centre, scatter, standard error and limits of the last result.

    Without limits the centre is the median of all results.
    """
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


def trend_plot(series: Series, by: str) -> Plot:
    """Return the figure of a series: values with intervals, limits as a band, steps as marks.

    `by` is the condition that orders the results; empty for their order.
    """
    steps = {step.place for chart in series.charts for step in chart.steps}
    origin = series.origin(by)
    places = np.array(series.places) - (series.places[0] if origin else 0.0)
    whole = all(_drawn(chart).all() for chart in series.charts)
    caption = "Whiskers are 95 % intervals. The band shows the control limits."
    left = " Values that are not finite, or too large to compare, are not drawn."
    return Plot(
        name="trend",
        title=series.title,
        caption=caption + ("" if whole else left),
        x_label=f"days from {origin}" if origin else by or "result",
        panels=tuple(_panel(chart, places) for chart in series.charts),
        marks=tuple((float(places[i]), series.points[i].name) for i in sorted(steps)),
        whole=not by,
    )


def _drawn(chart: Chart) -> NDArray[np.bool_]:
    """Return a mask, (n,), of the results whose value and interval a figure can show."""
    return np.asarray(np.all(np.abs([chart.values, chart.low, chart.high]) < LARGEST, axis=0))


def _panel(chart: Chart, places: Array) -> Panel:
    """Return the panel of a parameter; `places`, (n,), are the x values of the results."""
    beyond, drawn = np.isin(np.arange(len(places)), chart.beyond), _drawn(chart)
    curves = []
    if not isinstance(chart.limits, Missing):
        curves.append(
            PlotSeries(
                label="centre and limits",
                x=places,
                y=chart.limits.centre,
                low=chart.limits.lower,
                high=chart.limits.upper,
                tone="other",
            )
        )
    kinds: tuple[tuple[str, NDArray[np.bool_], Tone], ...] = (
        ("results", drawn & ~beyond, "model"),
        ("beyond the limits", drawn & beyond, "error"),
    )
    for label, kept, tone in kinds:
        if kept.any():
            curves.append(
                PlotSeries(
                    label=label,
                    x=places[kept],
                    y=chart.values[kept],
                    low=chart.low[kept],
                    high=chart.high[kept],
                    kind="points",
                    tone=tone,
                )
            )
    return Panel(label=labelled(chart.parameter, chart.unit), series=tuple(curves))


def trend_page(series: Sequence[Series], by: str, document: Document) -> str:
    """Return an HTML page with the document of a trend and a figure of each series.

    At most 50 series are drawn, those with a change first.
    """
    from axisid.presentation.matplotlib import draw, rendered

    figures = []
    for each in notable_first(series)[:_MOST_DRAWN]:
        plot = trend_plot(each, by)
        data = base64.b64encode(rendered(draw(plot, plot.title), "svg")).decode()
        text = escape(f"{plot.title}. {plot.caption}")
        figures.append(
            f'<figure><img alt="{text}" src="data:image/svg+xml;base64,{data}">'
            f"<figcaption>{escape(plot.caption)}</figcaption></figure>"
        )
    title = escape(f"Trend of {', '.join(dict.fromkeys(each.axis for each in series))}")
    return _PAGE.substitute(
        version=__version__,
        title=title,
        text=blocks_html(document),
        figures="\n".join(figures),
    )
