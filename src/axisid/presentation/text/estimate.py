"""An estimate as a document: its parameters with deviations and intervals, and its errors."""

import math

from axisid.estimation.estimates import Value
from axisid.presentation.blocks import Column, Document, Quantity, Table, text_columns
from axisid.presentation.saved import SavedEstimate
from axisid.support.number_text import range_text

_SMALL, _VAGUE = 0.01, 1e4  # percent of the value, of a deviation
_STARTS = {"least-squares": "LS", "nominal": "nominal"}


def saved_estimate_document(estimate: SavedEstimate) -> Document:
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


def iterations(estimate: SavedEstimate) -> str:
    """How many iterations there were, and from where; a dash for least squares."""
    if not estimate.iterates:
        return "-"
    count = str(len(estimate.iterates) - 1)
    return f"{count} from {_STARTS[estimate.started]}" if estimate.started else count


def _interval(value: Value) -> str:
    low, high = value.interval
    return range_text(low, high, " … ", digits=6)


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{error:.4g}"


def quantity(value: Value) -> Quantity:
    """Value and deviation; then relative deviation and i.i.d. deviation, digits as they warrant."""
    digits = places(value)
    relative = value.relative_deviation_percent
    percent = f"{relative:.2f} %" if relative >= _SMALL else f"{relative:.1g} %"
    percent = percent if relative < _VAGUE else f">{_VAGUE - 1:.0f} %"
    return Quantity(
        f"{value.value:.{digits}f}",
        f"{value.deviation:.{digits}f}",
        (percent, f"{value.sd:.{digits}f}"),
    )


def places(value: Value) -> int:
    """Decimal places that show four digits of the deviation, four at least."""
    if not 0 < value.sd < math.inf:
        return 4
    return min(max(4, 3 - math.floor(math.log10(value.sd))), 12)
