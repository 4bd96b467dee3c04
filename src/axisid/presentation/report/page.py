"""The page: every part in its place, and nothing from outside."""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from html import escape

from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep, Validation, default_cutoffs, sweep
from axisid.presentation.plots import Plot, plots_by_record
from axisid.support.missing import Missing
from axisid.support.remedy import Wording, as_arguments

from .frame import Page, figure_html, framed
from .model import model_html
from .parameters import parameters_html
from .provenance import provenance_html, truth_text
from .verdict import verdict_html

_PAIRS = (("friction", "convergence"), ("autocorrelation", "spectrum"))  # beside one another
_CUTOFFS = 8


def report_html(
    result: Identification,
    cutoffs: Sweep | None = None,
    *,
    validation: Validation | Sequence[Validation] | None = None,
    draws: int = 0,
    command: str = "",
    made: datetime | None = None,
    wording: Wording = as_arguments,
) -> str:
    """One page about a result, self-contained: it asks the network for nothing.

    Parameters
    ----------
    result : Identification
    cutoffs : Sweep, optional
        Of the same record; see `report_sweep`.
    validation : Validation or sequence of Validation, optional
        On further records.
    draws : int
        As in `Identification.summary`.
    command : str, optional
        What reproduces it.
    made : datetime, optional
        When it was made.
    wording : callable
        How settings are told, see `axisid.support.remedy`.
    """
    axis, diagnosis = result.axis.axis, result.diagnosis
    plots = plots_by_record(result, cutoffs)
    heading = axis.title or axis.name
    checked = (validation,) if isinstance(validation, Validation) else tuple(validation or ())
    page = Page(
        title=f"{heading}: axisid report",
        heading=heading,
        subheading=_subheading(result),
        verdict=verdict_html(diagnosis.verdict, diagnosis.preferred, wording),
        parameters=parameters_html(result, checked, draws, wording=wording),
        figures=figures_html(plots, result.record_names if result.of_records else (), wording),
        model=model_html(axis),
        provenance=provenance_html(result, command, made, wording=wording),
        simulated=simulated_html(truth_text(result)),
        further="records" if result.of_records else "",
    )
    return framed(page, (p for of in plots.values() for p in of.values() if isinstance(p, Plot)))


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


def figures_html(
    plots: Mapping[int, Mapping[str, Plot | Missing]], names: Sequence[str], wording: Wording
) -> str:
    """The figures of all records, and those of each, of which the reader chooses one."""
    if len(plots) == 1:
        return _figures(plots[0], wording)
    options = "".join(
        f'<option value="{i}">{i}: {escape(name)}</option>' for i, name in enumerate(names, 1)
    )
    picker = (
        '<p class="note record-picker" hidden><label>Figures of record '
        f'<select id="record-picker">{options}</select></label></p>'
    )
    of_each = "".join(_figures(of_one, wording, record=i) for i, of_one in plots.items() if i)
    return f"{picker}{of_each}{_figures(plots[0], wording)}"


def _figures(plots: Mapping[str, Plot | Missing], wording: Wording, record: int = 0) -> str:
    """Figures; those of a record by itself have its number in their names."""
    of, suffix = (f' data-record="{record}"', f"-{record}") if record else ("", "")
    plots = {name.removesuffix(suffix): plot for name, plot in plots.items()}
    kinds = {name: type(plot) for name, plot in plots.items()}
    # Where one of a pair cannot be drawn, the other takes the whole width.
    halves = {name for pair in _PAIRS if len({kinds.get(n) for n in pair}) == 1 for name in pair}
    return "".join(
        figure_html(name, plot, wording, of, half=name in halves) for name, plot in plots.items()
    )
