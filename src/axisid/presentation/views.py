"""How each result looks: in blocks, as plain data, in figures. One row for each type."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import singledispatch
from inspect import signature
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from axisid.codegen.artefacts import write_for_user
from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Estimate
from axisid.estimation.fitting import OutputFit
from axisid.estimation.identification import Identification
from axisid.estimation.law_search import LawSearch
from axisid.estimation.monte_carlo import MonteCarlo
from axisid.estimation.records import Record
from axisid.estimation.studies import Comparison, FitValidation, Sweep, Validation
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import derive
from axisid.presentation.blocks import Document, plain_text
from axisid.presentation.documents import (
    written_comparison,
    written_diagnosis,
    written_estimate,
    written_fit_validation,
    written_identification,
    written_law_search,
    written_output_fit,
    written_record,
    written_sweep,
    written_validation,
)
from axisid.presentation.formulas import axis_document
from axisid.presentation.html import blocks_html
from axisid.presentation.monte_carlo import (
    PLOTS,
    monte_carlo_plot,
    study_document,
    study_facts,
    written_study,
)
from axisid.presentation.plots import (
    Plot,
    autocorrelation_plot,
    convergence_plot,
    drawable,
    force_plot,
    friction_plot,
    mean_residual_plot,
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
    result_comparison_document,
)
from axisid.presentation.schema import JsonObject, plain
from axisid.presentation.text import (
    comparison_document,
    diagnosis_blocks,
    fit_validation_document,
    identification_document,
    law_search_document,
    output_fit_document,
    record_document,
    saved_document,
    saved_estimate_document,
    saved_fit_document,
    sweep_document,
    validation_document,
)
from axisid.support.arrays import finite_tree
from axisid.support.errors import UsageError
from axisid.support.files.json_text import json_text
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable
from axisid.support.real_numbers import is_whole
from axisid.support.remedy import Wording, as_arguments
from axisid.support.user_values import is_among, quoted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Figure: TypeAlias = Callable[..., Plot]
_Written: TypeAlias = Callable[..., JsonObject | Mapping[str, Any]]
_OF_ESTIMATE: Mapping[str, Callable[..., Plot | Missing]] = {
    "force": force_plot,
    "autocorrelation": autocorrelation_plot,
    "spectrum": spectrum_plot,
    "convergence": convergence_plot,
}
_OF_SAVED = {"autocorrelation": autocorrelation_plot, "convergence": convergence_plot}
_OF_METHOD = {"friction": friction_plot, "tracking": tracking_plot, "repeats": repeats_plot}


@singledispatch
def as_blocks(result: Presentable, *, wording: Wording = as_arguments, **how: Any) -> Document:
    """A result as a document of blocks, which text, terminals and HTML are rendered from.

    Parameters
    ----------
    result : Presentable
    wording : callable
        `as_arguments`, or `as_options` for the command line: how settings are told.
    **how
        As the result's `summary` takes it.
    """
    del wording, how
    raise UsageError(f"a {type(result).__name__} has no document of its own.")


def _settled(document: Callable[..., Document]) -> Callable[..., Document]:
    """A document that tells no settings, or tells them as its file does."""

    def blocks(result: Presentable, *, wording: Wording = as_arguments, **how: Any) -> Document:
        del wording
        return document(result, **how)

    return blocks


def _by_facts(
    document: Callable[..., Document], facts: Callable[..., Presentable]
) -> Callable[..., Document]:
    """The document of what a result tells."""
    return _settled(lambda result, **how: document(facts(result), **how))


@singledispatch
def as_text(result: Presentable, **how: Any) -> str:
    """A result as plain text; of an estimate by itself one line."""
    return plain_text(as_blocks(result, **how))


as_text.register(Estimate, repr)
as_text.register(SavedEstimate, repr)


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
    return dict(finite_tree(plain(written(result, **how))))


@singledispatch
def written(result: Presentable) -> JsonObject | Mapping[str, Any]:
    """A result as what JSON has of it."""
    raise UsageError(f"a {type(result).__name__} has no plain data of its own.")


def saved_as(result: Presentable, file: object, **how: Any) -> Path:
    """The file that a result was written to as JSON."""
    path = Path(file) if isinstance(file, (str, Path)) else None
    if path is None or path.suffix != ".json":
        raise UsageError(
            f"the result cannot be saved to {quoted(file)}; give a name that ends in .json.",
            code="save-ending",
        )
    known = signature(result.to_dict).parameters
    if foreign := [name for name in how if name not in known]:
        takes = ", ".join(known) or "nothing"
        raise UsageError(
            f"the result is not saved by {quoted(foreign[0])}; beside the file it takes {takes}.",
            code="save-option",
        )
    return write_for_user(path, json_text(result.to_dict(**how)))


def figure_of(
    result: Presentable, what: str, method: str | None = None, ax: object = None, **of: Any
) -> "Figure":
    """One of a result's figures, by its name, drawn anew or on axes that are given."""
    plot = plot_of(result, what, method, **of)
    from axisid.presentation.drawing import draw, draw_on

    return draw(plot) if ax is None else draw_on(plot, ax)


@singledispatch
def plot_of(result: Presentable, what: str, method: str | None = None) -> Plot:
    """One of a result's figures as data, by its name."""
    del method
    raise _no_figure(result, what, ())


def _of_estimate(result: Estimate, what: str, method: str | None = None) -> Plot:
    if not is_among(what, _OF_ESTIMATE):
        raise _no_figure(result, what, _OF_ESTIMATE)
    _check_method(result, method, (result.method,))
    return drawable(_OF_ESTIMATE[what](result), what)


def _of_identification(
    result: Identification, what: str, method: str | None = None, record: int | None = None
) -> Plot:
    """Of several records a figure is of one, by its number; the iteration is of all."""
    if len(result.parts) > 1 and what != "convergence":
        return _of_identification(_part(result, record), what, method)
    if record not in (None, 1):
        raise _no_record(record, len(result.parts))
    if is_among(what, ("record",)):
        return record_plot(result)
    estimate = result.preferred if method is None else result[method]
    if is_among(what, _OF_METHOD):
        return drawable(_OF_METHOD[what](result, estimate), what)
    if not is_among(what, _OF_ESTIMATE):
        raise _no_figure(result, what, ("record", *_OF_METHOD, *_OF_ESTIMATE))
    return plot_of(estimate, what)


def _part(result: Identification, record: int | None) -> Identification:
    """The part of a result that one record is, by its number from 1; by default the first."""
    number = 1 if record is None else record
    if not (is_whole(number) and 1 <= number <= len(result.parts)):
        raise _no_record(record, len(result.parts))
    return result.parts[int(number) - 1]


def _no_record(record: object, count: int) -> UsageError:
    return UsageError(
        f"there is no record {quoted(record)}; give a number from 1 to {count}.",
        code="no-such-record",
    )


def _of_sweep(result: Sweep, what: str, method: str | None = None) -> Plot:
    if not is_among(what, ("", "sweep")):
        raise _no_figure(result, what, ("sweep",))
    _check_method(result, method, ())
    return sweep_plot(result)


def _of_fit(
    result: OutputFit, what: str, method: str | None = None, record: int | None = None
) -> Plot:
    if not is_among(what, ("", "output")):
        raise _no_figure(result, what, ("output",))
    _check_method(result, method, ())
    number = 1 if record is None else record
    if not (is_whole(number) and 1 <= number <= len(result.records)):
        raise _no_record(record, len(result.records))
    return output_plot(result, int(number) - 1)


def _of_monte_carlo(result: MonteCarlo, what: str, method: str | None = None) -> Plot:
    _check_method(result, method, ())
    if not is_among(what, PLOTS):
        raise _no_figure(result, what, PLOTS)
    return drawable(monte_carlo_plot(result, what), what)


def _of_saved_estimate(result: SavedEstimate, what: str, method: str | None = None) -> Plot:
    _check_method(result, method, (result.method,))
    if not is_among(what, _OF_SAVED):
        raise UsageError(
            f"the file of a result has no rows of its record, which the figure {quoted(what)} "
            f"needs; identify again, or choose from {', '.join(_OF_SAVED)}.",
            code="no-saved-rows",
        )
    return drawable(_OF_SAVED[what](result), what)


def _of_saved(result: SavedIdentification, what: str, method: str | None = None) -> Plot:
    judged = method is None or method.lower() == result.preferred.method
    found, of = result.diagnosis.lack_of_fit, result.preferred
    if what == "repeats" and judged and found is not None:
        return mean_residual_plot(found, of.method, "", of.row_period, left=of.form.left)
    return plot_of(result.preferred if method is None else result[method], what)


def _of_saved_runs(
    result: SavedMonteCarlo | SavedOutputFit, what: str, method: str | None = None
) -> Plot:
    """A file of these holds figures and no samples, of which their plots are."""
    del method
    made, by = (
        ("runs", "monte_carlo") if isinstance(result, SavedMonteCarlo) else ("samples", "fit")
    )
    raise UsageError(
        f"a saved result has no {made} to draw {quoted(what) if what else 'a figure'} of; the one "
        f"that {by} returns has: call its plot() before it is saved.",
        code="saved-without-samples",
    )


def _check_method(result: Presentable, method: str | None, own: Sequence[str]) -> None:
    if not (method is None or is_among(str(method).lower(), own)):
        raise UsageError(
            f"a figure of {type(result).__name__} has no method to choose; leave it out.",
            code="no-method-to-choose",
        )


def _no_figure(result: Presentable, what: str, there: Iterable[str]) -> UsageError:
    listed = ", ".join(there)
    choose = f"; choose from {listed}" if listed else ""
    return UsageError(
        f"{type(result).__name__} has no figure {quoted(what)}{choose}.", code="unknown-figure"
    )


_as_read = attrgetter("document")  # what a result was read from
#: By type of result: its document, its plain data, and one of its figures, of what has any.
_VIEWS: dict[type, tuple[Callable[..., Document], _Written, _Figure | None]] = {
    Record: (record_document, written_record, None),
    Diagnosis: (diagnosis_blocks, written_diagnosis, None),
    Estimate: (_by_facts(saved_estimate_document, estimate_facts), written_estimate, _of_estimate),
    Identification: (identification_document, written_identification, _of_identification),
    Sweep: (sweep_document, written_sweep, _of_sweep),
    LawSearch: (law_search_document, written_law_search, None),
    Comparison: (comparison_document, written_comparison, None),
    Validation: (validation_document, written_validation, None),
    OutputFit: (output_fit_document, written_output_fit, _of_fit),
    FitValidation: (fit_validation_document, written_fit_validation, None),
    MonteCarlo: (_by_facts(study_document, study_facts), written_study, _of_monte_carlo),
    ResultComparison: (_settled(result_comparison_document), _as_read, None),
    SavedIdentification: (saved_document, _as_read, _of_saved),
    SavedEstimate: (_settled(saved_estimate_document), _as_read, _of_saved_estimate),
    SavedOutputFit: (saved_fit_document, _as_read, _of_saved_runs),
    SavedFitValidation: (fit_validation_document, _as_read, None),
    SavedMonteCarlo: (_settled(study_document), _as_read, _of_saved_runs),
}
for _kind, (_document, _data, _figure) in _VIEWS.items():
    as_blocks.register(_kind, _document)
    written.register(_kind, _data)
    if _figure is not None:
        plot_of.register(_kind, _figure)
