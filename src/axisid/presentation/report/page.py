"""The page: every part in its place, the figures as data inside it, and nothing from outside.

The data are small, and harmless whatever the names in them are: each array is stored once, as
32-bit floats in base64; one with even steps as start, step, count.
"""

import base64
import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep, Validation, default_cutoffs, sweep
from axisid.modeling.declaration import Axis, ControlLaw, Memory, equation_of_motion
from axisid.modeling.quantities import FORCE, Coordinate, Formula, written
from axisid.presentation.formulas import formula_mathml
from axisid.presentation.html import prose_html
from axisid.presentation.plots import SHADED, TITLES, Panel, Plot, Series, plots_by_record
from axisid.presentation.saved import identification_facts
from axisid.support.errors import Missing
from axisid.support.version import __version__

from .parameters import parameters_html, verdict_html
from .provenance import provenance_html, truth_text

Array = NDArray[np.float64]

_MOST_POINTS = 30_000  # of a curve; more become the least and the largest of each stretch
_EVEN = 1e-6  # of a step
_PAIRS = (("friction", "convergence"), ("autocorrelation", "spectrum"))  # beside one another
_SCRIPTS = ("ticks.js", "panel.js", "plot.js", "page.js")
_CUTOFFS = 8


def script_json(value: Any) -> str:
    """JSON for the inside of a script element, which nothing in it can end."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def figures_data(plots: Iterable[Plot]) -> dict[str, Any]:
    """What the page's script draws: ``arrays`` in base64, and ``plots`` that refer to them."""
    pool = _Pool()
    listed = [_plot_data(plot, pool) for plot in plots]
    return {"arrays": list(pool.numbers), "plots": listed}


class _Pool:
    """Arrays by content; insertion order is their number."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def put(self, values: Array | None) -> Any:
        if values is None:
            return None
        if len(values) > 2 and _is_even(values):
            step = float(values[-1] - values[0]) / (len(values) - 1)
            return {"start": float(values[0]), "step": step, "count": len(values)}
        content = base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")
        return self.numbers.setdefault(content, len(self.numbers))


def _is_even(values: Array) -> bool:
    steps = np.diff(values)
    return bool(steps[0] != 0 and np.all(np.abs(steps - steps.mean()) <= _EVEN * abs(steps[0])))


def _plot_data(plot: Plot, pool: _Pool) -> dict[str, Any]:
    return {
        "name": plot.name,
        "x_label": plot.x_label,
        "log": plot.log,
        "whole": plot.whole,
        "shaded": plot.shaded,
        "shade": SHADED,
        "marks": plot.marks,
        "panels": [_panel_data(panel, pool) for panel in plot.panels],
    }


def _panel_data(panel: Panel, pool: _Pool) -> dict[str, Any]:
    return {
        "label": panel.label,
        "log": panel.log,
        "weight": panel.weight,
        "span": panel.span,
        "levels": panel.levels,
        "series": [_series_data(series, pool) for series in panel.series],
    }


def _series_data(series: Series, pool: _Pool) -> dict[str, Any]:
    x, y = series.x, series.y
    if len(x) > _MOST_POINTS and series.low is None:
        if series.kind == "line":
            x, y = thinned(x, y, _MOST_POINTS)
        else:
            every = -(-len(x) // _MOST_POINTS)
            x, y = x[::every], y[::every]
    return {
        "label": series.label,
        "kind": series.kind,
        "tone": series.tone,
        "broad": series.broad,
        "dashed": series.dashed,
        "aside": series.aside,
        "x": pool.put(x),
        "y": pool.put(y),
        "low": pool.put(series.low),
        "high": pool.put(series.high),
    }


def thinned(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """The least and the largest value of each stretch, in their order, evenly in x.

    Parameters
    ----------
    x, y : (n,) array
        Even in x.
    most : int
        How many points may be left; extremes are kept whatever it is.
    """
    length = -(-len(x) // (most // 2))
    starts = np.arange(0, len(x), length)
    places: list[list[int]] = []
    for start in starts:
        part = y[start : start + length]
        least, largest = int(part.argmin()), int(part.argmax())
        places.append(sorted((int(start) + least, int(start) + largest)))
    halves = (starts[:, None] + np.array([0.25, 0.75]) * length).ravel()
    step = (x[-1] - x[0]) / (len(x) - 1)
    return x[0] + step * halves, y[np.array(places).ravel()]


def report_html(
    result: Identification,
    cutoffs: Sweep | None = None,
    *,
    validation: Validation | Sequence[Validation] | None = None,
    command: str = "",
    made: datetime | None = None,
) -> str:
    """One page about a result, self-contained: it asks the network for nothing.

    Parameters
    ----------
    result : Identification
    cutoffs : Sweep, optional
        Of the same record; see `report_sweep`.
    validation : Validation or sequence of Validation, optional
        On further records.
    command : str, optional
        What reproduces it.
    made : datetime, optional
        When it was made.
    """
    axis, diagnosis, form = result.axis.axis, result.diagnosis, result.preferred.form
    plots = plots_by_record(result, cutoffs)
    heading = axis.title or axis.name
    checked = (validation,) if isinstance(validation, Validation) else tuple(validation or ())
    return page_of(
        (p for of in plots.values() for p in of.values() if isinstance(p, Plot)),
        several=bool(result.of_records),
        heading=escape(heading),
        subheading=escape(_subheading(result)),
        verdict=verdict_html(diagnosis.verdict, diagnosis.preferred),
        parameters=parameters_html(
            identification_facts(result, 0),
            {p.name: p.description for p in (*result.axis.declared.parameters, *form.declared)},
            checked,
        ),
        figures=figures_html(plots, result.record_names if result.of_records else ()),
        model=model_html(axis),
        provenance=provenance_html(result, command, made),
        simulated=simulated_html(truth_text(result)),
    )


def page_of(plots: Iterable[Plot], *, several: bool, heading: str, **parts: str) -> str:
    """A page of its parts in HTML, with the data of its figures.

    Parameters
    ----------
    plots : iterable of Plot
    several : bool
        Whether a reader chooses of which record figures are.
    heading : str
    **parts
        What else stands in the template.
    """
    style = _asset("page.css") + _asset("records.css") * several
    script = "".join(map(_asset, _SCRIPTS)) + _asset("records.js") * several
    return Template(_asset("page.html")).substitute(
        parts,
        version=__version__,
        title=f"{heading}: axisid report",
        heading=heading,
        data=script_json(figures_data(plots)),
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
    )


def report_sweep(
    result: Identification, progress: Callable[[int, int, str], None] | None = None
) -> Sweep:
    """The modest sweep of a report: the methods of the inverse model at a few cut-offs.

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
    swept = sweep(
        result.axis,
        result.records,
        default_cutoffs(1 / result.record.period, points=_CUTOFFS),
        result.prefilter,
        methods or list(result.estimates),
        progress=progress,
        start=result.start,
        **result.shared_as,
    )
    return swept.with_result(result)


def simulated_html(truth: str) -> str:
    """What nobody may overlook of a record that was not measured: what it was computed with."""
    if not truth:
        return ""
    return (
        '<p class="simulated"><b>SIMULATED.</b> This record is not a measurement: it was computed '
        f"with {escape(truth)}.</p>"
    )


def _subheading(result: Identification) -> str:
    """The axis, what it was identified from, and how many samples that is."""
    name, records = result.axis.axis.name, result.records
    if len(records) > 1:
        samples = sum(map(len, records))
        return f"{name}, identified from {len(records)} records, {samples} samples"
    (record,) = records
    size = f"{len(record)} samples of {1e3 * record.period:.6g} ms"
    return f"{name}, identified from {record.provenance.source}, {size}"


def figures_html(plots: Mapping[int, Mapping[str, Plot | Missing]], names: Sequence[str]) -> str:
    """The figures of all records, and those of each, of which the reader chooses one."""
    if len(plots) == 1:
        return _figures(plots[0])
    options = "".join(
        f'<option value="{i}">{i}: {escape(name)}</option>' for i, name in enumerate(names, 1)
    )
    picker = (
        '<p class="note record-picker" hidden><label>Figures of record '
        f'<select id="record-picker">{options}</select></label></p>'
    )
    of_each = "".join(_figures(of_one, record=i) for i, of_one in plots.items() if i)
    return f"{picker}{of_each}{_figures(plots[0])}"


def _figures(plots: Mapping[str, Plot | Missing], record: int = 0) -> str:
    """Figures; those of a record by itself have its number in their names."""
    of, suffix = (f' data-record="{record}"', f"-{record}") if record else ("", "")
    plots = {name.removesuffix(suffix): plot for name, plot in plots.items()}
    kinds = {name: type(plot) for name, plot in plots.items()}
    # Where one of a pair cannot be drawn, the other takes the whole width.
    halves = {name for pair in _PAIRS if len({kinds.get(n) for n in pair}) == 1 for name in pair}
    return "".join(_figure(name, plot, of, half=name in halves) for name, plot in plots.items())


def _figure(name: str, plot: Plot | Missing, of: str, *, half: bool) -> str:
    wide = (' class="half"' if half else "") + of
    heading = TITLES[name] if isinstance(plot, Missing) else plot.title
    title = f'<div class="figure-head"><h3>{escape(heading)}</h3></div>'
    if isinstance(plot, Missing):
        why = prose_html(f"None: {plot}")
        return f'<figure{wide}>{title}<p class="none">{why}</p></figure>'
    return (
        f'<figure{wide} id="figure-{plot.name}">{title}'
        f'<div class="plot" id="plot-{plot.name}" aria-label="{escape(plot.title)}"></div>'
        f"<figcaption>{prose_html(plot.caption)}</figcaption></figure>"
    )


def model_html(axis: Axis) -> str:
    """The equation of motion, the drive and the control law."""
    q, law = axis.coordinate, axis.control
    motion = formula_mathml(equation_of_motion(axis), q)
    said = (
        f"Position {q.name} in {q.unit}; {FORCE}, the drive's force, is {axis.drive.force_text(q)}."
    )
    said += f" There {axis.drive.timing_text}." if axis.drive.timing_text else ""
    equation = f'<div class="equation">{motion}<p>{escape(said)}</p></div>'
    return equation if law is None else equation + _law(law, q)


def _law(law: ControlLaw, q: Coordinate) -> str:
    """What the drive computes once a period, and what it remembers until the next."""
    formulas = [Formula(name="control", value=law.output)]
    formulas += [Formula(name=_next(memory), value=memory.following) for memory in law.memory]
    typeset = "".join(formula_mathml(formula, q) for formula in formulas)
    how = "continuous" if law.continuous else f"evaluated every {1e3 * law.period:g} ms and held"
    late = f", applied {law.delay} samples late" if law.delay else ""
    gains = ", ".join(f"{name} = {value:g}" for name, value in law.gains.items())
    facts = f"{law.name}, {how}{late}" + (f"; {gains}." if gains else ".")
    if law.memory:
        starts = ", ".join(f"{m.name} = {written(m.start, q)}" for m in law.memory)
        facts += f" Kept from sample to sample; at the first: {starts.replace('_', ' ')}."
    return f'<h3>Control law</h3><div class="equation">{typeset}<p>{escape(facts)}</p></div>'


def _next(memory: Memory) -> sympy.Symbol:
    return sympy.Symbol(f"{memory.name}_next")


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """What the page's security policy knows its own script or style by."""
    digest = hashlib.sha256(text.encode()).digest()
    return f"sha256-{base64.b64encode(digest).decode()}"
