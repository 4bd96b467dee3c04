"""A force column beside a control: the two must belong together, and the control within limits."""

from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.records import Record
from axisid.estimation.signals import (
    DriveAlong,
    acting_control,
    recorded_signals,
)
from axisid.estimation.thresholds import MAX_LIMIT_EXCESS, MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.missing import Missing

from .column_comparison import ColumnComparison, LowPassed, unmasked

_MAX_FORCE_DIFFERENCE = 20.0  # % between the recorded force and what the drive makes of the control
_MAX_FORCE_LAG = 5e-3  # s, of the recorded force behind the control
# of the samples, at which the control may be beyond the limit: spikes may be
_MAX_LIMIT_EXCESS_SHARE = 1e-3

_NAME = "force against control"
_LIMIT = "control against limit"


def force_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """The recorded force against what the drive makes of the control; nothing without both."""
    if record.force is None or record.control is None:
        return None
    drive, longest = axis.axis.drive, record.longest()
    maker, of_maker = (
        ("the drive's gain", "gain times control")
        if drive.is_gain
        else ("the drive", "what the drive makes of the control")
    )
    commanded, by_gain = _commanded(axis, longest)
    apart, found = _compared(longest, commanded)
    vague = float(np.hypot(found.factor_deviation, drive.relative_sd * by_gain))
    far = replace(found, factor_deviation=vague).distances
    scaled, shifted = far["factor"] > 1, far["offset"] > 1
    lag, near = found.delay * record.period, apart <= _MAX_FORCE_DIFFERENCE
    late, q = abs(lag) > _MAX_FORCE_LAG, axis.axis.coordinate
    good = near and not (scaled or late or shifted)
    suspect = f"the drive ({drive.force_text(q)})"
    if drive.is_gain:
        suspect = (
            f"the gain, which would be {found.factor * drive.gain:.4g} {q.force_unit}/{drive.unit} "
            f"for {drive.gain:g}"
        )
    if good:
        meaning = f"the force column is what {maker} makes of the control"
    elif near and scaled:
        meaning = (
            f"the force column is {found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} "
            f"times what {maker} makes of the control, and otherwise the same: every parameter is "
            f"scaled by it. Check the force column's scale and {suspect}, or declare how well the "
            "gain is known (relative_sd)"
        )
    elif near and not late:
        meaning = (
            f"the force column is {found.offset:+.4g} +- {found.offset_deviation:.1g} "
            f"{q.force_unit} beside what {maker} makes of the control, and otherwise the same: a "
            "constant force, and friction that differs with the direction, take it up. Check the "
            "zero of the force's sensor, or of the control's converter"
        )
    else:
        meaning = (
            f"the force column is {found.factor:.3g} times what {maker} makes of the control, "
            f"{1e3 * lag:.2g} ms later and {apart:.3g} % off it: check the column, its "
            f"unit and timing, and the {'gain' if drive.is_gain else 'drive'}"
        )
    return Check(
        name=_NAME,
        status=passed(good),
        figure=apart if np.isfinite(apart) else None,
        threshold=_MAX_FORCE_DIFFERENCE,
        source=f"difference in percent of {of_maker}, in what is slow against a current "
        "loop; fails too for a lag beyond 5 ms, and where the factor between the two is off 1 by "
        "more than 1 % and three deviations, that of the gain among them, or a constant between "
        "them more than 1 % of the force and three deviations",
        meaning=meaning,
    )


def limit_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """The recorded control against the drive's limit; nothing without either."""
    drive = axis.axis.drive
    if record.control is None or not np.isfinite(drive.limit):
        return None
    size, most_excess = np.abs(record.control)[unmasked(record)], MAX_LIMIT_EXCESS.value
    if not size.size:
        return None
    beyond = size > (1 + most_excess) * drive.limit
    share = float(np.mean(beyond))
    good, used = share <= _MAX_LIMIT_EXCESS_SHARE, record.force is None
    most = float(size.max())
    return Check(
        name=_LIMIT,
        status=passed(good, matters=used),
        figure=100 * share,
        threshold=100 * _MAX_LIMIT_EXCESS_SHARE,
        source=f"percent of the samples at which the control is more than {100 * most_excess:g} % "
        "beyond the drive's limit",
        meaning=f"the control stays within the drive's limit of {drive.limit:g} {drive.unit}"
        if good
        else f"the control is beyond the drive's limit of {drive.limit:g} {drive.unit} in "
        f"{100 * share:.2g} % of the samples, up to {most:.3g} {drive.unit}: "
        + (
            "a control that is recorded before the drive limits it gives no force there; record "
            "what the drive applies, or the force, or correct the limit or the control's unit"
            if used
            else "the force is measured, so that it matters to the simulated loop alone; correct "
            "the limit or the control's unit, unless it is recorded before the drive limits it"
        ),
    )


def _commanded(axis: GeneratedAxis, record: Record) -> tuple[Array, float]:
    """What the drive makes of the control of a record of one piece, (N,), and how far by its gain.

    The latter is the slope of the logarithms: 1 for a force that is all the gain's.
    """
    velocity = np.gradient(record.position, record.period)  # its noise is filtered with the force
    motion = record.position, velocity, np.gradient(velocity, record.period)
    recorded = recorded_signals(axis, record.provenance.source, record.signals)
    control = acting_control(axis, np.asarray(record.control), [0], record.period)
    drive = DriveAlong(
        axis=axis, starts=[0], period=record.period, held=True, delay=0.0, mean=False
    )
    commanded, slope = (each(control, motion, recorded) for each in (drive.force, drive.slope))
    used = unmasked(record)
    power = float(commanded[used] @ commanded[used])
    return commanded, float(slope[used] @ commanded[used]) / power if power else 1.0


def _compared(record: Record, commanded: Array) -> tuple[float, ColumnComparison]:
    """How far the two are apart in what is slow, percent, and what is between them.

    Both are low-passed, so that what a current loop and its sensor do is no factor; a few samples,
    of which no factor can be told, are compared as they are.
    """
    slow, target = commanded, np.asarray(record.force)
    columns = LowPassed.of(record, commanded, target)
    found: ColumnComparison | Missing = Missing("too few samples")
    if not isinstance(columns, Missing):
        slow, target = columns.computed[columns.rows], columns.measured[columns.rows]
        found = ColumnComparison.of(columns)
    if isinstance(found, Missing):  # nothing tells how well the factor is known
        found = ColumnComparison(
            factor=float(slow @ target / (slow @ slow)),
            factor_deviation=np.inf,
            delay=0.0,
            delay_deviation=np.inf,
            offset=0.0,
            offset_deviation=np.inf,
            size=0.0,
            left_percent=0.0,
        )
    # What is left is no noise where the force is measured behind a gear: a factor that explains
    # no more than that is none.
    unexplained = found.left_percent / 100 / MIN_DISTANCE_FROM_NOISE.value
    return relative_error_percent(target - slow, slow), replace(
        found,
        factor_deviation=max(found.factor_deviation, unexplained),
        offset_deviation=max(found.offset_deviation, unexplained * found.size),
    )
