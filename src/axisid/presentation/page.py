"""HTML pages of an identification, a fit and a study, and the report files of `identify`."""

import base64
import hashlib
import json
import platform
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import msgspec
import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import INSTRUMENT_STARTS
from axisid.estimation.identification import Identification
from axisid.estimation.model_selection import Sweep, default_cutoffs, sweep
from axisid.estimation.model_validation import Validation
from axisid.estimation.monte_carlo import MonteCarlo
from axisid.estimation.output_error import OutputFit
from axisid.estimation.records import Record
from axisid.estimation.verdict_checks import Check, Status, by_weight, conclusion
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Formula
from axisid.presentation.documents import (
    STATUS_CLASSES,
    Checks,
    Document,
    Heading,
    blocks_html,
    checks_html,
    formula_mathml,
    motion_sections,
    paragraph,
    prose_html,
    table_html,
    unbroken,
)
from axisid.presentation.plots import (
    SHADED,
    TITLES,
    Plot,
    PlotSeries,
    monte_carlo_plots,
    numbered,
    output_plot,
    plots_by_record,
    with_series,
)
from axisid.presentation.result_files import identification_facts, written_study
from axisid.presentation.sentences import conclusion_text
from axisid.presentation.text import (
    checks_table,
    details_document,
    findings,
    heading_facts,
    judged_table,
    output_fit_document,
    saved_document,
    study_document,
    validation_document,
    verdict_block,
)
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError
from axisid.support.files import replace_file
from axisid.support.missing import Missing
from axisid.support.version import __version__

_MOST_POINTS = 30_000  # of a curve; a longer one is thinned to the extremes of stretches
_EVEN = 1e-6  # relative tolerance of an even step
# Escapes of the signs that could end a script element, or a line in it.
_HARMLESS = str.maketrans({sign: f"\\u{ord(sign):04x}" for sign in "<>&\u2028\u2029"})
_PAIRS = (("friction", "convergence"), ("autocorrelation", "spectrum"))  # figures side by side


def script_json(value: Any) -> str:
    """Return JSON for a script element, escaped so that nothing in it ends the element."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).translate(_HARMLESS)


def figures_data(plots: Iterable[Plot]) -> dict[str, Any]:
    """Return the figures as data for the page's scripts.

    ``arrays`` has each distinct array of 32-bit floats in base64, and ``plots`` refers to arrays by
    their index.
    """
    indices: dict[str, int] = {}  # index of each array, by its content

    def put(values: Any) -> Any:
        """Return a number as it is, an evenly spaced array by its step, another by its index."""
        if not np.ndim(values):
            return float(values)
        step = float(values[-1] - values[0]) / max(len(values) - 1, 1)
        if len(values) > 2 and step and np.allclose(np.diff(values), step, _EVEN, 0.0):
            return {"start": float(values[0]), "step": step, "count": len(values)}
        content = base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")
        return indices.setdefault(content, len(indices))

    thin = (with_series(plot, _thinned_series) for plot in plots)
    listed = [msgspec.to_builtins(plot, enc_hook=put) for plot in thin]
    return {"arrays": list(indices), "plots": [{**plot, "shade": SHADED} for plot in listed]}


def _thinned_series(series: PlotSeries) -> PlotSeries:
    """Return a series with at most 30,000 points.

    A line keeps the extremes of each stretch, and points are thinned evenly. A series with a band
    is not thinned.
    """
    if len(series.x) <= _MOST_POINTS or series.low is not None:
        return series
    if series.kind == "line":
        x, y = thinned(series.x, series.y, _MOST_POINTS)
    else:
        every = -(-len(series.x) // _MOST_POINTS)  # rounded up
        x, y = series.x[::every], series.y[::every]
    return replace(series, x=x, y=y)


def thinned(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """Return a curve with fewer points: minimum and maximum of each stretch, in their order.

    The returned points are evenly spaced in x.

    Parameters
    ----------
    x, y : (n,) array
        Evenly spaced in x.
    most : int
        Maximum number of returned points; extremes are always kept.
    """
    length = -(-len(x) // (most // 2))  # of a stretch, rounded up
    starts = np.arange(0, len(x), length)
    places = []
    for start in starts:
        stretch = y[start : start + length]
        places.append(sorted((start + stretch.argmin(), start + stretch.argmax())))
    # The two points of a stretch are at a quarter and at three quarters of its length.
    halves = (starts[:, None] + np.array([0.25, 0.75]) * length).ravel()
    step = (x[-1] - x[0]) / (len(x) - 1)
    return x[0] + step * halves, y[np.array(places).ravel()]


def figures_html(plots: Mapping[int, Mapping[str, Plot | Missing]], names: Sequence[str]) -> str:
    """Return the HTML of all figures; with several records, of those of the chosen record.

    Parameters
    ----------
    plots : mapping of int to mapping of str to Plot or Missing
        Figures by number of the record and by name, as `plots_by_record` returns them.
    names : sequence of str
        Names of the records.
    """
    if len(plots) == 1:
        return _figures(plots[0])
    options = "".join(
        f'<option value="{i}">{i}: {escape(name)}</option>' for i, name in enumerate(names, 1)
    )
    picker = (
        '<p class="note record-picker" hidden><label>Figures of record '
        f'<select id="record-picker">{options}</select></label></p>'
    )
    of_each = "".join(_figures(by_name, record=i) for i, by_name in plots.items() if i)
    return f"{picker}{of_each}{_figures(plots[0])}"


def _figures(plots: Mapping[str, Plot | Missing], record: int = 0) -> str:
    """Return the HTML of figures, some of them in pairs side by side.

    Parameters
    ----------
    plots : mapping of str to Plot or Missing
        Figures by name; Missing with the reason if a figure cannot be drawn.
    record : int
        Number of the record, which is part of the names; 0 for figures of all records together.
    """
    attribute = suffix = ""
    if record:
        attribute, suffix = f' data-record="{record}"', f"-{record}"
    plots = {name.removesuffix(suffix): plot for name, plot in plots.items()}
    kinds = {name: type(plot) for name, plot in plots.items()}
    # If one figure of a pair cannot be drawn, the other takes the whole width.
    halves: set[str] = set()
    for pair in _PAIRS:
        if len({kinds.get(name) for name in pair}) == 1:
            halves.update(pair)
    return "".join(
        _figure(name, plot, attribute, half=name in halves) for name, plot in plots.items()
    )


def _figure(name: str, plot: Plot | Missing, attribute: str, *, half: bool) -> str:
    """Return the HTML of one figure; for a missing figure its title and the reason.

    Parameters
    ----------
    name : str
    plot : Plot or Missing
    attribute : str
        HTML attribute with the number of the record; empty for all records.
    half : bool
        True if the figure has half the width of the page.
    """
    attributes = (' class="half"' if half else "") + attribute
    heading = TITLES[name] if isinstance(plot, Missing) else plot.title
    title = f'<div class="figure-head"><h3>{escape(heading)}</h3></div>'
    if isinstance(plot, Missing):
        reason = prose_html(f"Not available: {plot}")
        return f'<figure{attributes}>{title}<p class="none">{reason}</p></figure>'
    return (
        f'<figure{attributes} id="figure-{plot.name}">{title}'
        f'<div class="plot" id="plot-{plot.name}" aria-label="{escape(plot.title)}"></div>'
        f"<figcaption>{prose_html(plot.caption)}</figcaption></figure>"
    )


_SCRIPTS = ("ticks.js", "panel.js", "plot.js", "page.js")
_CUTOFFS = 7  # of the sweep for the report, next to that of the result
_PACKAGES = ("numpy", "scipy", "casadi", "sympy")  # whose versions the page names
#: Text before the tables of all methods; the first table of the page has the judged method.
_ALL_METHODS = paragraph(
    "These values contain the bias of filter and noise. The table above is corrected for it.",
    "The number after ± is one standard error. The plots show 95 % intervals.",
    title="All methods, before the bias correction",
)
_STATUSES = ("fail", "note", "not evaluated", "pass")  # in the order of the table of checks
_SIMULATED = '<p class="simulated"><b>SIMULATED.</b> {}</p>'


def monte_carlo_page(result: MonteCarlo, *, command: str = "", made: datetime | None = None) -> str:
    """Return a self-contained HTML page about a study, which needs no network access.

    Parameters
    ----------
    result : MonteCarlo
    command : str, optional
        Command that reproduces the study.
    made : datetime, optional
        Date of the page; without a date, the same result gives the same page.
    """
    plan, study = result.plan, written_study(result)
    facts, axis, twin = heading_facts(study), plan.axis.axis, plan.twin.axis
    # Both models, which are shown if the identified model is not correct. `plan.is_right` is True
    # if it is the simulated model, and its exact known values are true; one model is then enough.
    other = f"<h3>Identified</h3>{_model_html(axis)}<h3>Simulated</h3>{_model_html(twin)}"
    return _page(
        study_document(study)[:-1],  # the last block has the findings, which are in the verdict
        {0: monte_carlo_plots(result)},  # the key 0 is for figures of all records together
        plan.axis,
        heading=f"{axis.title or axis.name}: a Monte-Carlo study",
        subheading=f"{facts['twins']}, {facts['noise']}",
        verdict='<section class="verdict"><h2>Findings</h2>'
        f"{blocks_html((findings(study),))}</section>",
        model=_model_html(axis) if plan.is_right else other,
        simulated=_SIMULATED.format(
            "No data are measured: every run is a simulated twin of the axis with its own noise."
        ),
        command=command,
        made=made,
    )


def fit_report_html(fit: OutputFit, *, command: str = "", made: datetime | None = None) -> str:
    """Return a self-contained HTML page about a fit, which needs no network access.

    Parameters
    ----------
    fit : OutputFit
    command : str, optional
        Command that reproduces it.
    made : datetime, optional
        Date of the page.
    """
    return _page(
        output_fit_document(fit),
        fit_plots(fit),
        fit.axis,
        fit.records,
        subheading=f"{fit.output} fitted to",
        verdict=_verdict_html(fit.checks, f"the fit of the {fit.output}"),
        command=command,
        made=made,
    )


def report_html(
    result: Identification,
    cutoffs: Sweep | None = None,
    *,
    validations: Sequence[Validation] = (),
    command: str = "",
    made: datetime | None = None,
) -> str:
    """Return a self-contained HTML page about an identification, which needs no network access.

    Parameters
    ----------
    result : Identification
    cutoffs : Sweep, optional
        Sweep of the same record over the cut-off; see `report_sweep`.
    validations : sequence of Validation
        Validations of the estimates on further records.
    command : str, optional
        Command that reproduces it.
    made : datetime, optional
        Date of the page.
    """
    facts, diagnosis = identification_facts(result, 0), result.diagnosis
    details = details_document(facts)[:-1]  # the checks are in the verdict
    more = (
        f"<details><summary>All diagnostics</summary>{_scrolled(details)}</details>",
        *(
            "<h2>Frozen estimates on a second record</h2>" + _scrolled(validation_document(each))
            for each in validations
        ),
    )
    return _page(
        (judged_table(facts), _ALL_METHODS, *saved_document(facts, every=True)),
        plots_by_record(result, cutoffs),
        result.axis,
        result.records,
        subheading="identified from",
        verdict=_verdict_html(diagnosis.verdict, f"the {diagnosis.preferred.upper()} estimate"),
        more="".join(more),
        command=command,
        made=made,
    )


def _page(
    document: Document,
    plots: Mapping[int, Mapping[str, Plot | Missing]],
    axis: GeneratedAxis,
    records: Sequence[Record] = (),
    *,
    heading: str = "",
    subheading: str,
    verdict: str,
    model: str = "",
    simulated: str = "",
    more: str = "",
    command: str,
    made: datetime | None,
) -> str:
    """Return the HTML page of a document and its figures, with the origin of the records.

    Parameters
    ----------
    document : Document
        Its headings are shown among the facts at the end of the page; its checks are in `verdict`.
    plots : mapping of int to mapping of str to Plot or Missing
        Figures by number of the record and by name.
    axis : GeneratedAxis
    records : sequence of Record
    heading, subheading : str
        Title of the page, by default that of the axis; and the start of the line below it.
    verdict, model, simulated, more : str
        HTML of the verdict, of the model (by default that of the axis), of the remark that data are
        simulated, and of what follows the tables.
    command : str
        Command that reproduces the result; empty for none.
    made : datetime or None
        Date of the page; None for none.
    """
    # Collect the facts on the result, its records and the program.
    facts = {"made": "" if made is None else made.isoformat(" ", "seconds")}
    for block in document:
        if isinstance(block, Heading):
            facts |= block.facts
    for i, record in enumerate(records, 1):
        number, source = f" {i}" if len(records) > 1 else "", record.provenance
        facts |= {
            f"file as given{number}": source.given,
            f"file{number}": source.path,
            f"sha256 of the file{number}": source.sha256,
        }
    if records:
        names = [record.provenance.source for record in records]
        sources = names[0] if len(names) == 1 else f"{len(names)} records"
        subheading = f"{axis.axis.name}, {subheading} {sources}, {sum(map(len, records))} samples"
        truth = records[0].provenance.truth
        if truth:
            listed = ", ".join(f"{name} = {value:g}" for name, value in truth.items())
            simulated = _SIMULATED.format(
                f"This record is not a measurement. It was simulated with {escape(listed)}."
            )
    several = len(plots) > 1
    style = _asset("page.css") + _asset("records.css") * several
    script = "".join(map(_asset, _SCRIPTS)) + _asset("records.js") * several
    title = escape(heading or axis.axis.title or axis.axis.name)
    shown = tuple(block for block in document if not isinstance(block, (Heading, Checks)))
    drawn = (
        plot for by_name in plots.values() for plot in by_name.values() if isinstance(plot, Plot)
    )
    simulated_by = "native code"
    if axis.native.library() is None:
        simulated_by = "the CasADi virtual machine"
    packages = ", ".join(f"{package} {version(package)}" for package in _PACKAGES)
    made_by = {
        "generated code": axis.signature,
        "simulated by": simulated_by,
        "versions": f"axisid {__version__}, Python {platform.python_version()}, {packages}",
        "platform": platform.platform(),
    }
    provenance = blocks_html((Heading(facts={**facts, **made_by}),))
    if command:
        provenance += f"<p>Command that reproduces this result:</p><pre>{unbroken(command)}</pre>"
    return Template(_asset("page.html")).substitute(
        version=__version__,
        title=f"{title}: axisid report",
        heading=title,
        subheading=escape(subheading),
        simulated=simulated,
        verdict=verdict,
        parameters=_scrolled(shown) + more,
        figures=figures_html(plots, [record.provenance.source for record in records]),
        model=model or _model_html(axis.axis),
        provenance=provenance,
        data=script_json(figures_data(drawn)),
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
    )


def _scrolled(document: Document) -> str:
    """Return blocks as HTML; each block scrolls if it is wider than the page."""
    return "".join(f'<div class="scroll">{blocks_html((block,))}</div>' for block in document)


def _tally_legend(checks: Iterable[Check]) -> str:
    """Return HTML with the number of checks of each status, in the colours of the bars."""
    counts = Counter(check.status for check in checks)
    words: Mapping[Status, str] = {
        "pass": "passed",
        "note": "with a note",
        "not evaluated": "not evaluated",
        "fail": "failed",
    }
    entries = [
        f'<span><i class="{STATUS_CLASSES[status]}"></i>{counts[status]} {word}</span>'
        for status, word in words.items()
        if counts[status]
    ]
    return f'<p class="legend">{" ".join(entries)} (one bar for each check)</p>'


def _verdict_html(checks: Sequence[Check], judged: str) -> str:
    """Return the HTML of a verdict: headline, bars, sentences on checks, table of all checks.

    Parameters
    ----------
    checks : sequence of Check
    judged : str
        Name of the result that the checks apply to.
    """
    ordered = sorted(by_weight(checks), key=lambda check: _STATUSES.index(check.status))
    bars = "".join(
        f'<span class="{STATUS_CLASSES[check.status]}" title="{escape(check.name)}"></span>'
        for check in reversed(ordered)
    )
    table = replace(checks_table(ordered, sources=True), title="")
    headline = prose_html(conclusion_text(conclusion(checks)))
    return (
        f'<section class="verdict" id="verdict"><h2>{headline}</h2>'
        f'<div class="tally" aria-hidden="true">{bars}</div>{_tally_legend(ordered)}'
        f"{checks_html(verdict_block(checks).judged)}"
        "<details><summary>All checks with value and threshold</summary>"
        f'<div class="scroll">{table_html(table)}</div>'
        f'</details><p class="note">Checks apply to {escape(judged)}.</p></section>'
    )


def report_sweep(
    result: Identification, progress: Callable[[int, int, str], None] | None = None
) -> Sweep:
    """Return a sweep over seven cut-offs for the report, by the methods of the inverse model.

    Its settings are those of the identification.

    Parameters
    ----------
    result : Identification
    progress : callable, optional
        As in `sweep`.

    Raises
    ------
    EstimationError
        No cut-off gave an estimate.
    """
    methods = [method for method, found in result.estimates.items() if not found.is_direct]
    started = (each.started for each in result.estimates.values() if each.started)
    joint, shared = result.problem.joint_form, dict[str, Any]()
    if joint is not None:
        shared = {
            "local": (*joint.local,),
            "known": {name: [*values] for name, values in joint.known.items()},
            "gain": "declared" if joint.gain is None else "identified",
        }
    swept = sweep(
        result.axis,
        result.records,
        default_cutoffs(1 / result.record.period, points=_CUTOFFS),
        result.prefilter,
        methods or list(result.estimates),
        progress=progress,
        start=next(started, INSTRUMENT_STARTS[0]),
        level=result.levels.level,
        least_share=result.levels.least_share,
        **shared,
    )
    return swept.with_result(result)


def _model_html(axis: Axis) -> str:
    """Return equation of motion, parameters, drive and control law as HTML."""
    parts = ""
    for section in motion_sections(axis):
        lines = "".join(
            formula_mathml(line, axis.coordinate)
            if isinstance(line, Formula)
            else f"<p>{escape(line)}</p>"
            for line in section.lines
        )
        note = f"<p>{escape(section.note)}.</p>" if section.note else ""
        parts += f'<h3>{escape(section.title)}</h3><div class="equation">{lines}{note}</div>'
    return parts


def _asset(name: str) -> str:
    """Return the text of a file of the page: a template, style or script."""
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """Return the hash of a style or script for the page's content security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def fit_plots(fit: OutputFit) -> Mapping[int, Mapping[str, Plot]]:
    """Return the figures of a fit by the number of the record, from 1, and by name.

    A single record has the number 0.
    """
    if len(fit.records) == 1:
        return {0: {"output": output_plot(fit)}}
    return {0: {}} | {
        i: {f"output-{i}": numbered(output_plot(fit, i - 1), i, record.provenance.source)}
        for i, record in enumerate(fit.records, 1)
    }


_PATIENCE = 1.0  # s; a sweep that takes longer reports its progress

#: Function that shows a line to the user.
Say = Callable[[str], None]


def write_outputs(
    result: Identification,
    validations: Sequence[Validation],
    say: Say,
    *,
    report: str | None = None,
    figures: str | None = None,
    command: str = "",
) -> list[Path]:
    """Write the requested report and figures, and return the files.

    Parameters
    ----------
    result : Identification
    validations : sequence of Validation
        Validations of the estimates on further records.
    say : callable
        Function that shows a line to the user.
    report : str, optional
        File of the page.
    figures : str, optional
        Folder of the figures.
    command : str
        Command that reproduces the result.

    Raises
    ------
    UsageError
        A file or folder cannot be written to.
    """
    cutoffs = _swept(result, say)
    written = []
    try:
        if report is not None:
            page = report_html(
                result,
                cutoffs,
                validations=validations,
                command=command,
                made=datetime.now().astimezone(),
            )
            replace_file(Path(report), page)
            written.append(Path(report))
        if figures is not None:
            from .matplotlib import write_figures

            found = plots_by_record(result, cutoffs).values()
            plots = (plot for by_name in found for plot in by_name.values())
            written += write_figures(plots, Path(figures), "pdf")
    except OSError as error:
        place = error.filename or report or figures
        raise UsageError(f"{place} cannot be written: {error.strerror}.") from error
    return written


def _swept(result: Identification, say: Say) -> Sweep | None:
    """Return the sweep for the report; None if no cut-off gives an estimate.

    A sweep that takes longer than a second reports its progress by `say`.
    """
    begin = time.monotonic()

    def progress(done: int, count: int, _: str) -> None:
        if time.monotonic() - begin > _PATIENCE:
            say(f"sweep for the report: {done} of {count} cut-offs are done")

    try:
        return report_sweep(result, progress)
    except EstimationError as error:
        say(f"the report has no sweep over the cut-off: {error}")
        return None
