"""How each result looks: in blocks, as plain data, in figures. One row for each type."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from inspect import signature
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from axisid.estimation.control_law_search import LawSearch
from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Estimate
from axisid.estimation.fitting import OutputFit
from axisid.estimation.identification import Identification, record_place
from axisid.estimation.monte_carlo import MonteCarlo
from axisid.estimation.records import Record
from axisid.estimation.studies import Comparison, FitValidation, Sweep, Validation
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import derive
from axisid.presentation.blocks import Document, plain_text
from axisid.presentation.formulas import axis_document
from axisid.presentation.html import blocks_html
from axisid.presentation.plots import (
    PLOTS,
    Plot,
    autocorrelation_plot,
    convergence_plot,
    drawable,
    force_plot,
    friction_plot,
    monte_carlo_plot,
    output_plot,
    record_plot,
    repeats_plot,
    spectrum_plot,
    sweep_plot,
    tracking_plot,
)
from axisid.presentation.saved import (
    ResultComparison,
    SavedEstimate,
    SavedFitValidation,
    SavedIdentification,
    SavedMonteCarlo,
    SavedOutputFit,
    estimate_facts,
    identification_facts,
    plain,
    result_comparison_document,
    study_facts,
    written_comparison,
    written_diagnosis,
    written_estimate,
    written_fit_validation,
    written_identification,
    written_law_search,
    written_output_fit,
    written_record,
    written_study,
    written_sweep,
    written_validation,
)
from axisid.presentation.text import (
    comparison_document,
    diagnosis_blocks,
    fit_validation_document,
    law_search_document,
    output_fit_document,
    record_document,
    saved_document,
    saved_estimate_document,
    saved_fit_document,
    study_document,
    sweep_document,
    validation_document,
)
from axisid.support.errors import Missing, UsageError, is_among, quoted
from axisid.support.files import json_text, write_file
from axisid.support.presentable import Presentable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Figures: TypeAlias = Mapping[str, Callable[..., Plot | Missing]]


def as_blocks(result: Presentable, **how: Any) -> Document:
    """A result as a document of blocks, which text, terminals and HTML are rendered from.

    Parameters
    ----------
    result : Presentable
    **how
        As the result's `summary` takes it.
    """
    document, _ = _views_of(result)
    return document(result, **how)


def as_text(result: Presentable, **how: Any) -> str:
    """A result as plain text; of an estimate by itself one line."""
    if isinstance(result, (Estimate, SavedEstimate)):
        return repr(result)
    return plain_text(as_blocks(result, **how))


def as_html(result: Presentable) -> str:
    """A result for notebooks."""
    return blocks_html(as_blocks(result))


def axis_html(axis: Axis) -> str:
    """A declared axis for notebooks, with the models that follow from it."""
    return blocks_html(axis_document(derive(axis)))


def as_frame(result: Presentable, library: str | None = None) -> Any:
    """A result's numbers as a dataframe of pandas or polars."""
    from .frames import frame_of

    return frame_of(result, library)


def as_document(result: Presentable, **how: Any) -> dict[str, Any]:
    """A result as plain numbers, texts and lists; what is not finite is None."""
    _, written = _views_of(result)
    return plain(written(result, **how))


def saved_as(result: Presentable, file: object, **how: Any) -> Path:
    """The file that a result was written to as JSON."""
    path = Path(file) if isinstance(file, (str, Path)) else None
    if path is None or path.suffix != ".json":
        raise UsageError(
            f"the result cannot be saved to {quoted(file)}; give a name that ends in .json.",
            code="result-file",
        )
    known = signature(result.to_dict).parameters
    if foreign := [name for name in how if name not in known]:
        takes = ", ".join(known) or "nothing"
        raise UsageError(
            f"the result is not saved by {quoted(foreign[0])}; beside the file it takes {takes}.",
            code="result-file",
        )
    return write_file(path, json_text(result.to_dict(**how)))


def figure_of(
    result: Presentable, what: str, method: str | None = None, ax: object = None, **of: Any
) -> "Figure":
    """One of a result's figures, by its name, drawn anew or on axes that are given."""
    plot = plot_of(result, what, method, **of)
    from axisid.presentation.drawing import draw, draw_on

    return draw(plot) if ax is None else draw_on(plot, ax)


def plot_of(result: Presentable, what: str, method: str | None = None, **of: Any) -> Plot:
    """One of a result's figures as data, by its name, which the only one of a result needs not."""
    if isinstance(result, (Identification, SavedIdentification)):
        return _of_identification(result, what, method, **of)
    figures = _FIGURES.get(type(result), {})
    if not what and len(figures) == 1:
        (what,) = figures
    if not is_among(what, figures):
        raise _no_figure(result, what, figures)
    own = (result.method,) if isinstance(result, (Estimate, SavedEstimate)) else ()
    if not (method is None or is_among(str(method).lower(), own)):
        raise UsageError(
            f"a figure of {type(result).__name__} has no method to choose; leave it out.",
            code="figure",
        )
    return drawable(figures[what](result, **of), what)


def _of_identification(
    result: Identification | SavedIdentification,
    what: str,
    method: str | None,
    record: int | None = None,
) -> Plot:
    """Of several records a figure is of one, by its number; the iteration is of all."""
    if isinstance(result, Identification):
        place = record_place(1 if record is None else record, len(result.parts))
        result = result if what == "convergence" else result.parts[place]
    estimate = result.preferred if method is None else result[method]
    figures = _figures_of(result, estimate)
    if is_among(what, figures):
        return drawable(figures[what](result, estimate), what)
    if isinstance(estimate, Estimate) and not is_among(what, _OF_ESTIMATE):
        raise _no_figure(result, what, (*figures, *_OF_ESTIMATE))
    return plot_of(estimate, what)


def _figures_of(
    result: Identification | SavedIdentification, estimate: Estimate | SavedEstimate
) -> _Figures:
    """The figures of a result and an estimate together; of a file as far as it has their data."""
    if isinstance(result, Identification):
        return {
            "record": lambda whole, _: record_plot(whole),
            "friction": friction_plot,
            "tracking": tracking_plot,
            "repeats": repeats_plot,
        }
    told = estimate is result.preferred and result.diagnosis.lack_of_fit is not None
    return {"repeats": repeats_plot} if told else {}


def _no_figure(result: Presentable, what: str, there: Iterable[str]) -> UsageError:
    listed = ", ".join(there)
    if isinstance(result, SavedEstimate | SavedMonteCarlo | SavedOutputFit):
        of = f"{quoted(what)} " if what else ""
        return UsageError(
            f"the file of a result has no rows, samples or runs, which the figure {of}needs; draw "
            "it from what identify, fit or monte_carlo returns"
            + (f", or choose from {listed}." if listed else "."),
            code="figure",
        )
    choose = f"; choose from {listed}" if listed else ""
    return UsageError(
        f"{type(result).__name__} has no figure {quoted(what)}{choose}.", code="figure"
    )


def _views_of(result: Presentable) -> tuple[Callable[..., Document], Callable[..., Any]]:
    for kind in type(result).__mro__:
        if kind in _VIEWS:
            return _VIEWS[kind]
    raise UsageError(f"a {type(result).__name__} has no document and no plain data of its own.")


_OF_ESTIMATE: _Figures = {
    "force": force_plot,
    "autocorrelation": autocorrelation_plot,
    "spectrum": spectrum_plot,
    "convergence": convergence_plot,
}
#: By type of result its figures by name; those of an identification are of an estimate too.
_FIGURES: Mapping[type, _Figures] = {
    Estimate: _OF_ESTIMATE,
    SavedEstimate: {name: _OF_ESTIMATE[name] for name in ("autocorrelation", "convergence")},
    Sweep: {"sweep": sweep_plot},
    OutputFit: {
        "output": lambda fit, record=None: output_plot(
            fit, record_place(1 if record is None else record, len(fit.records))
        )
    },
    MonteCarlo: {name: partial(monte_carlo_plot, name=name) for name in PLOTS},
}
_as_read = attrgetter("document")  # what a result was read from
#: By type of result its document and its plain data.
_VIEWS: Mapping[type, tuple[Callable[..., Document], Callable[..., Any]]] = {
    Record: (record_document, written_record),
    Diagnosis: (diagnosis_blocks, written_diagnosis),
    Estimate: (lambda each: saved_estimate_document(estimate_facts(each)), written_estimate),
    Identification: (
        lambda each, draws=0, **how: saved_document(
            identification_facts(each, draws), draws, **how
        ),
        written_identification,
    ),
    Sweep: (sweep_document, written_sweep),
    LawSearch: (law_search_document, written_law_search),
    Comparison: (comparison_document, written_comparison),
    Validation: (validation_document, written_validation),
    OutputFit: (output_fit_document, written_output_fit),
    FitValidation: (fit_validation_document, written_fit_validation),
    MonteCarlo: (lambda study: study_document(study_facts(study)), written_study),
    ResultComparison: (result_comparison_document, lambda result: result),
    SavedIdentification: (saved_document, _as_read),
    SavedEstimate: (saved_estimate_document, _as_read),
    SavedOutputFit: (saved_fit_document, _as_read),
    SavedFitValidation: (fit_validation_document, lambda result: result),
    SavedMonteCarlo: (study_document, _as_read),
}
