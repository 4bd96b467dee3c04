"""Views of each type of result: blocks of text, plain data, dataframe, figures.

`_VIEWS` at the end of the file has one row per type of result.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from importlib.util import find_spec
from inspect import signature
from operator import attrgetter, methodcaller
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from axisid.estimation.control_law_search import LawSearch
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification, record_index
from axisid.estimation.misspecification import lack_of_fit
from axisid.estimation.model_selection import Comparison, Sweep
from axisid.estimation.model_validation import FitValidation, Validation
from axisid.estimation.monte_carlo import MonteCarlo, run_columns
from axisid.estimation.output_error import OutputFit
from axisid.estimation.records import Record
from axisid.estimation.regression import CovarianceNote
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import derive
from axisid.presentation.documents import Document, axis_document, blocks_html, plain_text
from axisid.presentation.plots import (
    PLOTS,
    Plot,
    autocorrelation_plot,
    convergence_plot,
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
from axisid.presentation.result_files import (
    ResultComparison,
    SavedEstimate,
    SavedFitValidation,
    SavedIdentification,
    SavedMonteCarlo,
    SavedOutputFit,
    identification_facts,
    plain,
    result_comparison_document,
    written_comparison,
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
from axisid.presentation.sentences import covariance_text
from axisid.presentation.text import (
    comparison_document,
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
from axisid.support.checks import is_among
from axisid.support.errors import UsageError
from axisid.support.files import json_text, write_file
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable, Shown
from axisid.support.wording import quoted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Figures: TypeAlias = Mapping[str, Callable[..., Plot | Missing]]
_Row: TypeAlias = dict[str, Any]
_LIBRARIES = ("pandas", "polars")


class _View(NamedTuple):
    """Views of one type of result.

    Attributes
    ----------
    document : callable
        Returns the document of blocks, from the result and the arguments of `summary`.
    written : callable
        Returns the document of the result file; by default the result itself.
    columns : callable or None
        Returns the rows or columns of the dataframe; None if the result has no dataframe.
    figures : mapping of str to callable
        Functions by the name of a figure; each returns the figure as data.
    """

    document: Callable[..., Document]
    written: Callable[..., Any] = lambda result: result
    columns: Callable[[Any], list[_Row] | Mapping[str, Any]] | None = None
    figures: _Figures = MappingProxyType({})


def as_blocks(result: Shown, **how: Any) -> Document:
    """Return a result as a document of blocks, from which text and HTML are rendered.

    Parameters
    ----------
    result : Shown
    **how
        Arguments of the `summary` of the result.
    """
    return _view_of(result).document(result, **how)


def as_text(result: Shown, **how: Any) -> str:
    """Return a result as plain text; a single estimate as one line."""
    if isinstance(result, (Estimate, SavedEstimate)):
        return repr(result)
    return plain_text(as_blocks(result, **how))


def covariance_name(note: CovarianceNote) -> str:
    """Return the note on a covariance as text."""
    return covariance_text(note)


def as_html(result: Shown) -> str:
    """Return a result as HTML for notebooks."""
    return blocks_html(as_blocks(result))


def axis_html(axis: Axis) -> str:
    """Return a declared axis and its derived models as HTML for notebooks."""
    return blocks_html(axis_document(derive(axis)))


def as_frame(result: Presentable, library: str | None = None) -> Any:
    """Return the numbers of a result as a dataframe of pandas or polars.

    Parameters
    ----------
    result : Presentable
    library : {"pandas", "polars"}, optional
        By default the installed one, pandas first.

    Raises
    ------
    UsageError
        There is no such library, it is not installed, or the result has no table of numbers.
    """
    name = next(filter(find_spec, _LIBRARIES), "pandas") if library is None else library
    if not is_among(name, _LIBRARIES):
        raise UsageError(
            f"library is {quoted(name)}; expected is pandas or polars. Give one of them.",
            code="dataframe",
        )
    if find_spec(name) is None:
        raise UsageError(
            f"a dataframe needs {name}, which is not installed. Run: pip install {name}",
            code="missing-library",
        )
    columns = _view_of(result).columns
    if columns is None:
        raise UsageError(
            f"{type(result).__name__} has no table of numbers for a dataframe. Use its to_dict().",
            code="dataframe",
        )
    if name == "pandas":
        import pandas as pd  # type: ignore[import-untyped]

        return pd.DataFrame(columns(result))
    import polars as pl

    return pl.DataFrame(columns(result), infer_schema_length=None)


def as_document(result: Presentable, **how: Any) -> dict[str, Any]:
    """Return a result as plain numbers, texts and lists; non-finite numbers are None."""
    return plain(_view_of(result).written(result, **how))


def saved_as(result: Presentable, file: object, **how: Any) -> Path:
    """Write a result as JSON, and return the file.

    Parameters
    ----------
    result : Presentable
    file : str or Path
        Name that ends in ``.json``.
    **how
        Arguments of the `to_dict` of the result.

    Raises
    ------
    UsageError
        The name or an argument is invalid, or the file cannot be written.
    """
    path = Path(file) if isinstance(file, (str, Path)) else None
    if path is None or path.suffix != ".json":
        raise UsageError(
            f"the result cannot be saved to {quoted(file)}. Give a file name that ends in .json.",
            code="result-file",
        )
    known = signature(result.to_dict).parameters
    unknown = [name for name in how if name not in known]
    if unknown:
        arguments = ", ".join(["the file", *known])
        raise UsageError(
            f"save has no argument {quoted(unknown[0])}. Give only {arguments}.",
            code="result-file",
        )
    return write_file(path, json_text(result.to_dict(**how)))


def figure_of(
    result: Presentable, what: str, method: str | None = None, ax: object = None, **of: Any
) -> "Figure":
    """Return a figure of a result by its name: a new one, or drawn on the given axes.

    Parameters
    ----------
    result : Presentable
    what : str
        Name of the figure; empty if the result has only one figure.
    method : str, optional
        Method of an identification; by default the judged one.
    ax : Axes or sequence of Axes, optional
        Axes to draw on, one per panel.
    **of
        Further arguments of the figure, such as the number of the record.
    """
    plot = plot_of(result, what, method, **of)
    from .matplotlib import draw, draw_on

    return draw(plot) if ax is None else draw_on(plot, ax)


def plot_of(result: Presentable, what: str, method: str | None = None, **of: Any) -> Plot:
    """Return a figure of a result as data, by its name; the arguments are those of `figure_of`.

    Raises
    ------
    UsageError
        There is no such figure or method, or the figure cannot be drawn.
    """
    figures = _view_of(result).figures
    if not what and len(figures) == 1:
        (what,) = figures
    if not is_among(what, figures):
        raise _no_figure(result, what, figures)
    own = (result.method,) if isinstance(result, (Estimate, SavedEstimate)) else ()
    if isinstance(result, (Identification, SavedIdentification)):
        plot = figures[what](*_of_method(result, what, method, **of))
    elif method is None or is_among(str(method).lower(), own):
        plot = figures[what](result, **of)
    else:
        raise UsageError(
            f"a figure of {type(result).__name__} has no choice of the method. Omit method.",
            code="figure",
        )
    if isinstance(plot, Missing):
        raise UsageError(
            f"the figure {what} cannot be drawn: {str(plot).removesuffix('.')}.", code="figure"
        )
    return plot


def _of_method(
    result: Identification | SavedIdentification,
    what: str,
    method: str | None,
    record: int | None = None,
) -> tuple[Any, Any]:
    """Return the result and the estimate that a figure shows.

    A figure of a live result shows one record, given by its number from 1, by default the first.
    The figure of the convergence shows all records.
    """
    if isinstance(result, Identification):
        place = record_index(1 if record is None else record, len(result.parts))
        result = result if what == "convergence" else result.parts[place]
    return result, result.preferred if method is None else result[method]


def _saved_repeats(saved: SavedIdentification, estimate: SavedEstimate) -> Plot | Missing:
    """Return the figure of the repeating residual of a saved result.

    Missing unless the estimate is the judged one.
    """
    if estimate is not saved.preferred:
        return Missing("the file contains the repeating residual only for the judged estimate")
    return repeats_plot(estimate, saved.document.lack_of_fit or None)


def _no_figure(result: Presentable, what: str, there: Iterable[str]) -> UsageError:
    """Return the error for a figure that a result does not have; `there` are its figures."""
    listed = ", ".join(there)
    if isinstance(result, SavedIdentification | SavedEstimate | SavedMonteCarlo | SavedOutputFit):
        name = f"{quoted(what)} " if what else ""
        alternatives = f", or choose from {listed}" if listed else ""
        return UsageError(
            f"the figure {name}needs rows, samples or runs, which the file of a result does not "
            f"contain. Draw it from the result of identify, fit or monte_carlo{alternatives}.",
            code="figure",
        )
    advice = f" Choose from {listed}." if listed else ""
    return UsageError(
        f"{type(result).__name__} has no figure {quoted(what)}.{advice}", code="figure"
    )


def _of_sweep(result: Sweep) -> list[_Row]:
    """Return the dataframe's rows of a sweep: one for each cut-off, method and parameter."""
    return [
        {"cutoff": cutoff, **row}
        for cutoff, found in zip(result.cutoffs, result.results, strict=True)
        for row in _rows(*found.estimates.values())
    ]


def _of_comparison(result: Comparison) -> list[_Row]:
    """Return the dataframe's rows of a comparison: one for each candidate."""
    return [
        {
            "candidate": each.name,
            "parameters": each.size,
            "equation_error_percent": each.estimate.equation_error_percent,
            "held_out_equation_error_percent": each.equation.error_percent,
            "log_likelihood": each.criteria.log_likelihood,
            "aic": each.criteria.aic,
            "bic": each.criteria.bic,
            "recommended": each.name == result.recommended,
        }
        for each in result.candidates
    ]


def _of_validation(result: Validation) -> list[_Row]:
    """Return the dataframe's rows of a validation: one for each method."""
    return [
        {
            "method": each.method,
            "equation_error_percent": each.equation_error_percent,
            "own_equation_error_percent": each.own_equation_error_percent,
            "simulation_error_percent": each.simulation_error_percent,
            "position_error_rms": each.position_error_rms,
            "tracking_error_percent": each.tracking_error_percent,
            "reestimate_percent": None
            if each.reestimate is None
            else each.reestimate.share_percent,
            "holds": each.holds,
        }
        for each in result
    ]


def _of_laws(result: LawSearch) -> list[_Row]:
    """Return the dataframe's rows of a law search: one for each law and gain."""
    return [
        {
            "law": each.title,
            "gain": name,
            "value": value,
            "sd": each.deviations.get(name),
            "delay": each.law.delay,
            "held_out_percent": each.held_out_percent,
            "fitted_percent": each.fitted_percent,
        }
        for each in result.laws
        for name, value in each.law.gains.items()
    ]


def _of_fit(result: OutputFit) -> list[_Row]:
    """Return the dataframe's rows of a fit: one for each parameter."""
    return [
        {
            "parameter": name,
            "unit": value.unit,
            "value": value.value,
            "sd": value.deviation,
            "lower_95": value.interval[0],
            "upper_95": value.interval[1],
            "at_bound": result.at_bound.get(name, ""),
            "fixed": name in result.fixed,
        }
        for name, value in result.parameters.items()
    ]


def _of_methods(result: Identification | SavedIdentification) -> list[_Row]:
    """Return the dataframe's rows of an identification: one for each method and parameter."""
    return _rows(*result.estimates.values())


def _rows(*estimates: Estimate | SavedEstimate) -> list[_Row]:
    """Return one row of a dataframe for each parameter of each estimate."""
    return [
        {
            "method": estimate.method,
            "parameter": name,
            "unit": value.unit,
            "value": value.value,
            "corrected": value.corrected,
            "sd_hac": value.sd_hac,
            "lower_95": value.interval[0],
            "upper_95": value.interval[1],
            "sd_iid": value.sd,
            "sd_gain": value.sd_gain,
            "filter_bias": value.filter_bias,
            "interval_covariance": value.chosen,
        }
        for estimate in estimates
        for name, value in estimate.parameters.items()
    ]


def _of_one(figures: _Figures) -> _Figures:
    """Return figures of an estimate as functions of a result and an estimate.

    Their first argument, the result, is not used.
    """
    return {name: lambda _, each, draw=draw: draw(each) for name, draw in figures.items()}


def _view_of(result: Shown) -> _View:
    """Return the views of a result's type; another type is shown by its own method `document`."""
    kinds = (_VIEWS[kind] for kind in type(result).__mro__ if kind in _VIEWS)
    return next(kinds, _View(methodcaller("document")))


_OF_ESTIMATE: _Figures = {
    "force": force_plot,
    "autocorrelation": autocorrelation_plot,
    "spectrum": spectrum_plot,
    "convergence": convergence_plot,
}
_OF_SAVED_ESTIMATE: _Figures = {n: _OF_ESTIMATE[n] for n in ("autocorrelation", "convergence")}
_as_read = attrgetter("document")  # the document that a saved result was read from
_VIEWS: Mapping[type, _View] = {
    Record: _View(record_document, written_record, Record.channels),
    Estimate: _View(
        lambda each: saved_estimate_document(
            SavedEstimate.of(written_estimate(each), each.row_period)
        ),
        written_estimate,
        _rows,
        _OF_ESTIMATE,
    ),
    SavedEstimate: _View(
        saved_estimate_document,
        _as_read,
        _rows,
        _OF_SAVED_ESTIMATE,
    ),
    Identification: _View(
        lambda each, draws=0, **how: saved_document(
            identification_facts(each, draws), draws, **how
        ),
        written_identification,
        _of_methods,
        {
            "record": lambda whole, _: record_plot(whole),
            "friction": friction_plot,
            "tracking": tracking_plot,
            "repeats": lambda whole, each: repeats_plot(each, lack_of_fit(each, whole.data)),
            **_of_one(_OF_ESTIMATE),
        },
    ),
    SavedIdentification: _View(
        saved_document,
        _as_read,
        _of_methods,
        {"repeats": _saved_repeats, **_of_one(_OF_SAVED_ESTIMATE)},
    ),
    Sweep: _View(sweep_document, written_sweep, _of_sweep, {"sweep": sweep_plot}),
    LawSearch: _View(law_search_document, written_law_search, _of_laws),
    Comparison: _View(comparison_document, written_comparison, _of_comparison),
    Validation: _View(validation_document, written_validation, _of_validation),
    OutputFit: _View(
        output_fit_document,
        written_output_fit,
        _of_fit,
        {
            "output": lambda fit, record=None: output_plot(
                fit, record_index(1 if record is None else record, len(fit.records))
            )
        },
    ),
    SavedOutputFit: _View(saved_fit_document, _as_read),
    FitValidation: _View(fit_validation_document, written_fit_validation),
    SavedFitValidation: _View(fit_validation_document),
    MonteCarlo: _View(
        lambda study: study_document(written_study(study)),
        written_study,
        run_columns,
        {name: partial(monte_carlo_plot, name=name) for name in PLOTS},
    ),
    SavedMonteCarlo: _View(study_document),
    ResultComparison: _View(result_comparison_document),
}
