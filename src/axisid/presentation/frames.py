"""Results as dataframes of pandas or polars, whichever is asked for or installed."""

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Any

from axisid.estimation.control_law_search import LawSearch
from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Estimate
from axisid.estimation.fitting import OutputFit
from axisid.estimation.identification import Identification
from axisid.estimation.monte_carlo import MonteCarlo, run_columns
from axisid.estimation.records import Record
from axisid.estimation.studies import Comparison, Sweep, Validation
from axisid.presentation.saved import SavedEstimate, SavedIdentification
from axisid.support.errors import UsageError, is_among, quoted
from axisid.support.presentable import Presentable

_LIBRARIES = ("pandas", "polars")

Row = dict[str, Any]
Columns = list[Row] | Mapping[str, Any]


def frame_of(result: Presentable, library: str | None) -> Any:
    """A result as a dataframe, see `Presentable.to_frame`."""
    name = _library(library)
    columns = _columns_of(result)
    if name == "pandas":
        import pandas as pd  # type: ignore[import-untyped]

        return pd.DataFrame(columns)
    import polars as pl

    return pl.DataFrame(columns, infer_schema_length=None)


def _library(library: str | None) -> str:
    """The one that is asked for, or else installed."""
    name = next(filter(find_spec, _LIBRARIES), "pandas") if library is None else library
    if not is_among(name, _LIBRARIES):
        raise UsageError(
            f"there is no dataframe of {quoted(name)}; give pandas or polars.", code="dataframe"
        )
    if find_spec(name) is None:
        raise UsageError(
            f"a dataframe needs {name}, which is not installed; run: pip install {name}",
            code="missing-library",
        )
    return name


def _columns_of(result: Presentable) -> Columns:
    """The rows of a result's dataframe, or its columns by name."""
    for kind, columns in _COLUMNS.items():
        if isinstance(result, kind):
            return columns(result)
    raise UsageError(
        f"a {type(result).__name__} has no table of numbers; see its to_dict().", code="dataframe"
    )


def _of_sweep(result: Sweep) -> list[Row]:
    return [
        {"cutoff": cutoff, **row}
        for cutoff, found in zip(result.cutoffs, result.results, strict=True)
        for row in _rows(*found.estimates.values())
    ]


def _of_comparison(result: Comparison) -> list[Row]:
    return [
        {
            "candidate": each.name,
            "parameters": each.size,
            "equation_error_percent": each.estimate.equation_error_percent,
            "held_out_equation_error_percent": each.equation.error_percent,
            "held_out_simulation_error_percent": None
            if each.simulation is None
            else each.simulation.error_percent,
            "log_likelihood": each.criteria.log_likelihood,
            "aic": each.criteria.aic,
            "bic": each.criteria.bic,
            "tic": each.criteria.tic,
            "recommended": each.name == result.recommended,
        }
        for each in result.candidates
    ]


def _of_validation(result: Validation) -> list[Row]:
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
            else each.reestimate.apart.share_percent,
            "holds": each.holds,
        }
        for each in result
    ]


def _of_laws(result: LawSearch) -> list[Row]:
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


def _of_diagnosis(result: Diagnosis) -> list[Row]:
    return [
        {
            "check": check.name,
            "status": check.status,
            "figure": check.figure,
            "threshold": check.threshold,
            "p_value": check.p_value,
            "meaning": check.meaning,
        }
        for check in result.verdict
    ]


def _of_fit(result: OutputFit) -> list[Row]:
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


def _rows(*estimates: Estimate | SavedEstimate) -> list[Row]:
    """A row for each parameter."""
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


#: By type of result what gives the columns.
_COLUMNS: Mapping[Any, Callable[[Any], Columns]] = {
    Estimate | SavedEstimate: _rows,
    Identification | SavedIdentification: lambda result: _rows(*result.estimates.values()),
    Sweep: _of_sweep,
    LawSearch: _of_laws,
    Comparison: _of_comparison,
    Validation: _of_validation,
    Diagnosis: _of_diagnosis,
    OutputFit: _of_fit,
    MonteCarlo: run_columns,
    Record: Record.channels,
}
