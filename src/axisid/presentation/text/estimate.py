"""An estimate as a document, and notes on what its numbers rest on."""

import math
from collections.abc import Mapping, Sequence

from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Physical, Value
from axisid.estimation.lack_of_fit import JackknifeInterval, LackOfFit
from axisid.modeling.declaration import known_text
from axisid.presentation.blocks import Cell, Column, Document, Quantity, Table, text_columns
from axisid.presentation.saved import SavedEstimate
from axisid.support.errors import or_dash, range_text
from axisid.support.mappings import grouped

_SMALL, _VAGUE = 0.01, 1e4  # percent of the value, of a deviation
_STARTS = {"least-squares": "LS", "nominal": "nominal"}
_OVER_MOVES = "sd over moves"
_FIX = " (fix NAME=VALUE+-SD)"


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
            *((name, "%", or_dash(error, ".4g"), "") for name, error in errors.items()),
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


def band_row(
    values: Sequence[Value], bands: Sequence[JackknifeInterval | None]
) -> list[tuple[Cell, ...]]:
    """Deviations of the model's error, where one noticeably exceeds that of noise."""
    if not any(band is not None and band.exceeds for band in bands):
        return []
    cells = (_band_cell(v, b) for v, b in zip(values, bands, strict=True))
    return [(f"  {_OVER_MOVES}", "", *cells)]


def _band_cell(value: Value, band: JackknifeInterval | None) -> Cell:
    if band is None:
        return "-"
    share = f"{100 * band.deviation / abs(value.value):.2f} %" if value.value else "-"
    return Quantity("", f"{band.deviation:.{places(value)}f}", (share, ""))


def moves_notes(diagnosis: Diagnosis) -> list[str]:
    """What repeats, and what bands of the model's error are, as far as there are any."""
    found = diagnosis.lack_of_fit
    notes = [] if found is None else [_repeats(found)]
    exceeding = {
        name: band
        for name, band in diagnosis.bands.get(diagnosis.preferred, {}).items()
        if band.exceeds
    }
    if not any(band.exceeds for of_one in diagnosis.bands.values() for band in of_one.values()):
        return notes
    listed = "; ".join(
        f"{name} {range_text(*band.interval, ' to ')} ({band.groups} groups by {band.by})"
        for name, band in exceeding.items()
    )
    own = f" 95 % of {diagnosis.preferred}: {listed}." if listed else ""
    notes.append(
        f"{_OVER_MOVES}: how far a parameter scatters where a group of moves is left out "
        "(jackknife), as the model's own error makes it, which is alike in moves that are alike; "
        f"the sd beside it supposes that what is left averages out over time, as noise does.{own}"
    )
    return notes


def _repeats(found: LackOfFit) -> str:
    what = "Moves" if found.period is None else f"Every {found.period:.4g} s the reference"
    again = "repeat" if found.period is None else "repeats"
    return (
        f"{what} {again}, up to {found.times} times ({found.rows} rows): "
        f"{100 * max(found.share, 0.0):.0f} +- {100 * found.deviation:.1g} % of what is left there "
        "is left again each time; the rest is noise."
    )


def physical_notes(found: Mapping[str, Physical]) -> list[str]:
    """Notes of a table; none where the estimates are of the physical parameters already."""
    if not found:
        return []
    notes = []
    if any(physical.shows_more for physical in found.values()):
        notes.append(_how(next(iter(found.values()))))
    said = grouped(
        (sentence, method)
        for method, physical in found.items()
        for sentence in (
            *(_fixable(each) for each in physical.undetermined),
            *physical.remarks,
        )
    )
    return notes + [
        f"{sentence}." if len(methods) == len(found) else f"{', '.join(methods)}: {sentence}."
        for sentence, methods in said.items()
    ]


def _fixable(sentence: str) -> str:
    return sentence + (_FIX if sentence.endswith(" known") else "")


def _how(physical: Physical) -> str:
    known = ", ".join(f"{p.name} = {known_text(p)} {p.unit}" for p in physical.known)
    fixed = f", and to {known}, declared as known" if known else ""
    more = (
        " Where the record shows a known parameter too, the two are weighed, and the others change "
        "through their correlation with it."
        if known
        else ""
    )
    return (
        "Physical parameters: the nearest to the estimates above, less its bias, by "
        f"their covariance{fixed} (minimum distance).{more}"
    )
