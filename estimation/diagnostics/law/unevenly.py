"""What a control law read of a record whose times are uneven, and how far that is open.

The rows of such a record may be what the law read, whose stamps alone jitter; or the samples may be
off even times, between which the law read. Which it is, the law itself tells: the one that it fits.
A record that was resampled has the rows of neither, since its control, which a drive holds, and
its noise are drawn between the samples.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import control_along, law_ticks, position_noise, start_of_law
from axisid.estimation.records import Between, Record, at_times
from axisid.estimation.thresholds import MAX_LAW_RESIDUAL
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.remedy import Remedy, Setting

# periods from even times, from which a law may have read something else; rounding is below
_MIN_UNEVEN = 1e-6
# what a law leaves, by what noise between samples with jitter makes, up to which it cannot be
# judged; 1.0 where that noise is all
_MAX_OPEN_RATIO = 2.0

_STAMPS = Remedy.of(
    "where its stamps jitter and not the sampling, ", Setting("resample", "auto", given=False)
)


@dataclass(frozen=True, slots=True)
class LawReading:
    """A way to read what the law read: in words, the record, and what is to be done if it fits."""

    said: str
    record: Record
    remedy: Remedy | None = None


def is_uneven(record: Record) -> bool:
    """Whether the samples of a record, or of the one that it was resampled from, are off at all."""
    whole = record.longest()
    return record.sampled is not None or bool(
        np.max(np.abs(whole.time - _even_times(whole))) > _MIN_UNEVEN * record.period
    )


def other_readings(record: Record) -> Iterator[LawReading]:
    """What else a law may have read than the samples of a record as they are."""
    raw = record if record.sampled is None else record.sampled
    if record.sampled is not None:
        yield LawReading("in the rows as they were sampled", raw.longest(), _STAMPS)
    raw = raw.longest()
    at = "at even times by the stamps"
    yield LawReading(at, _evenly(raw, ["position"]))
    yield LawReading(at, _evenly(raw, ["position", "reference", "injected"]))


def open_for_jitter(axis: GeneratedAxis, record: Record, off: float) -> float | None:
    """How much of the control jitter leaves open, percent, where that may be all that is off.

    None where the law's control would move too little for it: by the jitter, or by noise that the
    law measured at other times than the log.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    off : float
        Percent of the control that the law leaves, of the reading that fits best.
    """
    raw = (record if record.sampled is None else record.sampled).longest()
    even = _evenly(raw, ["position"])
    as_read, between = (_control(axis, each, each.position) for each in (raw, even))
    if relative_error_percent(as_read - between, np.asarray(raw.control)) < MAX_LAW_RESIDUAL.value:
        return None
    noise = position_noise(even.position) * np.random.default_rng(0).normal(size=len(even))
    moved = _control(axis, even, even.position + noise) - between
    left = relative_error_percent(moved, np.asarray(raw.control))
    return left if off < _MAX_OPEN_RATIO * left else None


def _control(axis: GeneratedAxis, record: Record, position: Array) -> Array:
    """What the law makes of a record with other positions."""
    whole = (0, len(record))
    ticks = law_ticks(axis, replace(record, position=position), whole)
    return control_along(axis, ticks, start_of_law(axis, record, whole, ticks))


def _even_times(record: Record) -> Array:
    """The even times that fit those of a record without gaps best, (N,), s."""
    count, first = np.arange(len(record), dtype=float), record.time[0]
    line = np.polyfit(count, record.time - first, 1)
    return np.asarray(np.polyval(line, count) + first, dtype=float)


def _evenly(record: Record, roles: Sequence[str]) -> Record:
    """A record without gaps with columns at the even times that fit its own best.

    As `--resample` does, position and reference go by cubic splines, and so does what was added to
    the reference; a signal that was added to the control by straight lines.
    """
    times, columns = _even_times(record), {**record.channels()}
    for role in columns.keys() & {*roles}:
        straight = role == "injected" and record.injected_at != "reference"
        how: Between = "linear" if straight else "spline"
        columns[role] = at_times(times, record.time, columns[role], how)
    return record.with_channels(columns)
