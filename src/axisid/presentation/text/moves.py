"""What repeats and what moves leave of one another, in a table's rows and in notes."""

from collections.abc import Sequence

from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Value
from axisid.estimation.moves import Band, LackOfFit
from axisid.presentation.blocks import Cell, Quantity
from axisid.support.number_text import range_text

from .estimate import places

_OVER_MOVES = "sd over moves"


def band_row(values: Sequence[Value], bands: Sequence[Band | None]) -> list[tuple[Cell, ...]]:
    """Deviations of the model's error, where one noticeably exceeds that of noise."""
    if not any(band is not None and band.exceeds for band in bands):
        return []
    cells = (_deviation(v, b) for v, b in zip(values, bands, strict=True))
    return [(f"  {_OVER_MOVES}", "", *cells)]


def _deviation(value: Value, band: Band | None) -> Cell:
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
