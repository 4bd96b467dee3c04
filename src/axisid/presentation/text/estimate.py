"""An estimate as a document: its parameters with deviations and intervals, and its errors."""

from axisid.estimation.estimates import Estimate, Value
from axisid.presentation.blocks import Column, Document, Table, text_columns

from .quantity import quantity

_STARTS = {"least-squares": "LS", "nominal": "nominal"}


def estimate_document(estimate: Estimate) -> Document:
    """Every parameter with its deviation and interval, and the errors."""
    values = {**estimate.ddm_parameters, **estimate.parameters}
    errors = {
        "equation error": None if estimate.by_output_error else estimate.equation_error_percent,
        "simulation error": estimate.simulation_error_percent,
    }
    about = estimate.covariance_names[estimate.chosen]
    table = Table(
        columns=(
            *text_columns(["", "unit"]),
            Column("value", parts=("sd", "rel. sd", "i.i.d.")),
            Column("95 % interval"),
        ),
        rows=(
            *((name, v.unit, quantity(v), _interval(v)) for name, v in values.items()),
            *((name, "%", _percent(error), "") for name, error in errors.items()),
        ),
        labels=2,
        title=f"{estimate.method.upper()}; sd: {about}",
    )
    return (table,)


def iterations(estimate: Estimate) -> str:
    """How many iterations there were, and from where; a dash for least squares."""
    if not estimate.iterates:
        return "-"
    count = str(len(estimate.iterates) - 1)
    return f"{count} from {_STARTS[estimate.started]}" if estimate.started else count


def _interval(value: Value) -> str:
    low, high = value.interval
    return f"{low:.6g} … {high:.6g}"


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{error:.4g}"
