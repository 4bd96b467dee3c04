"""What a control law read of a record whose times are uneven, and how far that is open.

The rows of such a record may be what the law read, whose stamps alone jitter; or the samples may be
off even times, between which the law read. Which it is, the law itself tells: the one that it fits.
A record that was resampled has the rows of neither, since its control, which a drive holds, and
its noise are drawn between the samples.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import control_along, law_ticks, position_noise, start_of_law
from axisid.estimation.problems import evenly, jitter_of
from axisid.estimation.records import Record
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
    return record.sampled is not None or bool(
        np.max(np.abs(jitter_of(record))) > _MIN_UNEVEN * record.period
    )


def other_readings(record: Record) -> Iterator[LawReading]:
    """What else a law may have read than the samples of a record as they are."""
    raw = record if record.sampled is None else record.sampled
    if record.sampled is not None:
        yield LawReading("in the rows as they were sampled", raw.longest(), _STAMPS)
    raw = raw.longest()
    at = "at even times by the stamps"
    yield LawReading(at, evenly(raw, ["position"]))
    yield LawReading(at, evenly(raw, ["position", "reference", "injected"]))


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
    even = evenly(raw, ["position"])
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
