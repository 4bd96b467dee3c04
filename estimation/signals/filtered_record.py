"""A record under a filter: what the filter leaves open is chosen, what it cannot serve refused."""

from dataclasses import replace
from typing import Literal

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.errors import AxisidError, DataError, UsageError

from .prefilter import Prefilter
from .signals import Signals, drive_force, filtered_signals
from .without_turns import LEAST_LEFT, Information

_UNITS_APART = (60.0, 1e3, 1e6, 1e9)  # minutes, ms, us and ns for seconds
_SAME = 0.02  # relative, of such a factor


def settled(prefilter: Prefilter, axis: GeneratedAxis, record: Record) -> Prefilter:
    """The prefilter for a record: its segments and masked rows, and its hold if that is open."""
    if not isinstance(prefilter, Prefilter):
        raise UsageError(f"the prefilter is {prefilter!r}; give a Prefilter, or leave it out.")
    fitted = replace(
        prefilter,
        hold=chosen_hold(prefilter, axis, measured=record.force is not None),
        segments=record.segments,
        masked=record.masked,
        silent=(),
    )
    if prefilter.reversals == "keep" or not (prefilter.reversals or axis.has_direction):
        return replace(fitted, reversals="keep")
    check_filter(fitted, axis, len(record), record.period, record.provenance.source)
    silent = fitted.near_reversals(record.position, record.period)
    left_out = replace(fitted, reversals="leave-out", silent=silent)
    if prefilter.reversals is None and axis.is_linear and _too_little(left_out, axis, record):
        return replace(fitted, reversals="keep")
    return left_out


def _too_little(left_out: Prefilter, axis: GeneratedAxis, record: Record) -> bool:
    """Whether a parameter is hardly shown without the samples near reversals and rests."""
    starts = [start for start, _ in record.spans]
    unknown = np.zeros(len(record))
    signals = filtered_signals(left_out, record.position, unknown, record.period, starts)
    near = np.zeros(len(record), dtype=bool)
    for start, stop in left_out.silent:
        near[start:stop] = True
    found = Information(axis)
    kept = left_out.kept(len(record), record.period)
    found.add(signals, kept, near, float(np.abs(signals.velocity).max()))
    return found.remaining < LEAST_LEFT


def check_filter(
    prefilter: Prefilter, axis: GeneratedAxis, samples: int, period: float, source: str
) -> None:
    """Refuse a record that the prefilter cannot serve, with what explains it best.

    Parameters
    ----------
    prefilter : Prefilter
    axis : GeneratedAxis
    samples : int
        Of the record.
    period : float
        s
    source : str
        File name, for messages.

    Raises
    ------
    DataError
        The time is in another unit than the control law's period.
    UsageError, DataError
        As `Prefilter.check` does.
    """
    try:
        prefilter.check(samples, period)
    except AxisidError as error:
        law = axis.axis.control
        ratio = 1.0 if law is None or law.continuous else period / law.period
        apart = max(ratio, 1 / ratio)
        if law is None or not any(abs(apart / unit - 1) < _SAME for unit in _UNITS_APART):
            raise
        raise DataError(
            f"{source} is sampled every {_duration(period)}, the control law of axis "
            f"{axis.axis.name!r} runs every {_duration(law.period)}: is time's unit right? Give it "
            f"with --columns time=NAME:UNIT. (As it stands, {error})"
        ) from error


def _duration(seconds: float) -> str:
    """In the unit that needs fewest zeros."""
    units = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))
    size, unit = next((u for u in units if seconds >= u[0] * (1 - _SAME)), units[-1])
    return f"{seconds / size:.4g} {unit}"


def chosen_hold(
    prefilter: Prefilter, axis: GeneratedAxis, *, measured: bool
) -> Literal["raw", "zoh"]:
    """The hold of the prefilter, or what suits a force that is measured or commanded."""
    law = axis.axis.control
    held = not measured and not (law is not None and law.continuous)
    return prefilter.hold or ("zoh" if held else "raw")


def measured_signals(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Signals:
    """Filtered motion beside the force, aligned as the prefilter says."""
    prefilter = settled(prefilter, axis, record)
    check_filter(prefilter, axis, len(record), record.period, record.provenance.source)
    starts = [start for start, _ in record.spans]
    force = drive_force(axis, record)
    return filtered_signals(prefilter, record.position, force, record.period, starts)
