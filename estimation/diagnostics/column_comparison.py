"""Comparison of a measured column with a computed one: a factor, a delay and a constant.

The comparison does not depend on the model. Both columns may be noisy. The factor of a regression
is then too small, and the inverse of the factor of the reverse regression is too large, so that the
true factor lies between the two [Frisch1934]_. The delay is found by shifting the computed column
until the regression gives a delay of 0, where noise attenuates nothing.

A force is compared with the force that the drive makes of the control, a velocity with the
derivative of the position, an acceleration with the derivative of the velocity. A factor between
them is a unit or a scale, a delay is that of a filter in the drive or the logger, a constant is the
zero of a sensor.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import AdvisedShift, Record, samples_apart, shift_into_time
from axisid.estimation.records.columns import likely_unit
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.estimation.signals import (
    DriveReplay,
    Prefilter,
    RowTimes,
    SampledFilter,
    acting_control,
    recorded_signals,
)
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    MAX_LIMIT_EXCESS,
    MAX_MISALIGNMENT,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.estimation.verdict_checks import Check, status_of
from axisid.support.arrays import Array, MaybeNan, mask_of, relative_error_percent
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing, unless_missing

from .column_findings import (
    ColumnCorrections,
    ColumnFault,
    ControlAgainstLimit,
    ForceAgainstControl,
    GainOfForce,
    MeasuredMotion,
    MotionReference,
)

# Hz; columns are compared below it, far below the bandwidth of any current loop
_MAX_CUTOFF = 30.0
# fewest samples that are compared, in settling times of the low-pass
_MIN_SETTLING_TIMES = 10
MAX_COLUMN_OFFSET = 0.01  # constant between the two, relative to the rms of the computed one
# % of the computed column, unexplained by factor, delay and constant; beyond it the column is
# another signal, as noise in the band is far less
_MAX_DIFFERENCE = 30.0

_OFTEN = 4  # rows per period of the highest frequency in the band
_STEPS, _STILL = 12, 1e-3  # of the search for the delay, samples
_FARTHEST = 50.0  # largest delay that is searched for, samples
_MAX_FORCE_DIFFERENCE = 20.0  # % between the recorded force and the force by the control
_TINY = 1e-300
_MAX_FORCE_LAG = 5e-3  # s, of the recorded force behind the control
# share of the samples at which the control may be beyond the limit, such as spikes
_MAX_LIMIT_EXCESS_SHARE = 1e-3
# in the order in which they are corrected
_CORRECTED: tuple[ColumnFault, ...] = ("delay", "factor", "offset")
_PARTS: dict[str, Literal["factor", "delay", "offset", "unexplained part"]] = {
    "factor": "factor",
    "delay": "delay",
    "offset": "offset",
    "left": "unexplained part",
}


#: Computed column and measured column, (N,) each, the sample numbers of the rows to compare, and
#: the distance of these rows in samples.
Columns = tuple[Array, Array, NDArray[np.int64], int]


def unmasked(record: Record) -> NDArray[np.bool_]:
    """Return a mask of the samples that are not masked in the record, (N,)."""
    return ~mask_of(record.masked, len(record))


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnComparison:
    """Comparison of a measured column with a computed one.

    Attributes
    ----------
    factor : float
        Measured divided by computed, the middle of its range; null for unrelated columns.
    factor_deviation : float
        Half the range of the factor that noise allows.
    delay : float
        Delay of the measured column, samples.
    delay_deviation : float
        Standard error of the delay, samples.
    offset : float
        Constant of the measured column relative to the computed one, SI.
    offset_deviation : float
        Standard error of the constant, SI.
    size : float
        Root mean square of the computed column, SI.
    left_percent : float
        Part of one column that the other one, its derivative and a constant do not explain, percent
        of the column (rms).
    """

    factor: MaybeNan
    factor_deviation: MaybeNan
    delay: MaybeNan
    delay_deviation: MaybeNan
    offset: MaybeNan
    offset_deviation: MaybeNan
    size: float
    left_percent: float

    @property
    def distances(self) -> dict[str, float]:
        """Distance of the factor from 1, and of delay, constant and residual from 0, by name.

        Each distance is divided by its tolerance, and is too large above 1. The residual has the
        name ``left``, the constant the name ``offset``.
        """
        far = MIN_DISTANCE_FROM_NOISE.value
        return {
            "factor": abs(self.factor - 1)
            / max(MAX_SCALE_ERROR.value, far * self.factor_deviation),
            "delay": abs(self.delay) / max(MAX_MISALIGNMENT.value, far * self.delay_deviation),
            "offset": abs(self.offset)
            / max(MAX_COLUMN_OFFSET * self.size, far * self.offset_deviation),
            "left": self.left_percent / _MAX_DIFFERENCE,
        }

    @property
    def worst(self) -> float:
        """Largest of the `distances`; a column is wrong where it is more than 1."""
        return max(self.distances.values())


@unless_missing
def compared_columns(columns: Columns) -> ColumnComparison | Missing:
    """Return the comparison of two columns; Missing where the axis hardly moves in the rows.

    The measured column is regressed on the computed one, its derivative and a constant. The
    computed column is shifted by the delay until the regression finds no further delay. Unrelated
    signals have a delay of 0. The reverse regression then gives the other end of the range of the
    factor.
    """
    computed, measured, rows, step = columns
    order = RowTimes(rows // step)

    def fit(given: Array, target: Array) -> Solution:
        """Return the regression of a column on another, its derivative and a constant."""
        columns = np.column_stack([given, np.gradient(given), np.ones_like(given)])[rows]
        regressor = factor(columns, ("factor", "delay", "offset"), neighbours=order)
        return least_squares(target[rows], regressor)

    delay, moved = 0.0, computed
    try:
        fitted = first = fit(computed, measured)
        for _ in range(_STEPS):
            gain, by_sample, _ = map(float, fitted.theta)
            change = -by_sample / gain if gain else np.inf
            if abs(change) < _STILL:
                break
            if not abs(delay + change) < _FARTHEST:
                delay, moved, fitted = 0.0, computed, first
                break
            delay += change
            moved = np.asarray(
                scipy.ndimage.shift(computed, delay, order=3, mode="nearest"), dtype=float
            )
            fitted = fit(moved, measured)
        back = fit(measured, moved)
    except EstimationError:
        return Missing("the axis hardly moves in the compared samples")
    deviations = np.sqrt(np.diag(Hac(2 * _OFTEN).matrix(fitted)))
    ways = float(fitted.theta[0]), 1 / (float(back.theta[0]) or _TINY)
    gain = sum(ways) / 2
    correlation_squared = float(fitted.theta[0] * back.theta[0])  # partial
    return ColumnComparison(
        factor=gain,
        factor_deviation=float(np.hypot(deviations[0], np.subtract(*ways) / 2)),
        delay=delay,
        delay_deviation=float(deviations[1] / abs(gain)) if gain else float("inf"),
        offset=float(fitted.theta[2]),
        offset_deviation=float(deviations[2]),
        size=float(np.sqrt(np.mean(computed[rows] ** 2))),
        left_percent=100 * float(np.sqrt(max(1 - correlation_squared, 0.0))),
    )


def low_passed(
    record: Record, computed: Array, measured: Array, times: int = 0
) -> Columns | Missing:
    """Return two columns of a record of one segment after the same low-pass, and rows to compare.

    The computed column is also differentiated `times` times. The rows are decimated samples, which
    suffices below the cut-off. Missing where too few consecutive samples are not masked.
    """
    period = record.period
    cutoff = min(COMPARISON_CUTOFF.value / period, _MAX_CUTOFF)
    settle = round(1 / (cutoff * period))
    used = scipy.ndimage.minimum_filter1d(unmasked(record), 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < _MIN_SETTLING_TIMES * settle:
        return Missing("the record has too few consecutive samples without mask")
    smooth = SampledFilter(Prefilter(cutoff=cutoff), period)
    computed, measured = smooth.low_passed(computed), smooth.low_passed(measured)
    for _ in range(times):
        computed = np.gradient(computed, period)
        # Means over the two samples that a central difference spans, by Simpson's rule.
        measured[1:-1] = (measured[:-2] + 4 * measured[1:-1] + measured[2:]) / 6
    step = max(settle // _OFTEN, 1)
    return computed, measured, np.flatnonzero(used).astype(np.int64)[::step], step


def force_check(axis: GeneratedAxis, record: Record) -> Check | Missing | None:
    """Return the check of the recorded force against the force from the control.

    None without both columns. Missing where they cannot be compared.
    """
    if record.force is None or record.control is None:
        return None
    drive, longest = axis.drive, record.longest()
    of_maker = (
        "gain times control" if drive.is_gain else "the force that the drive makes of the control"
    )
    commanded, by_gain = _commanded(axis, longest)
    # After a low-pass, the dynamics of the current loop and its sensor do not affect the factor.
    compared = _compared(low_passed(longest, commanded, np.asarray(longest.force)))
    if isinstance(compared, Missing):
        return compared
    apart, found = compared
    lag = found.delay * record.period
    deviation = float(np.hypot(found.factor_deviation, drive.relative_sd * by_gain))
    fault = _fault_of_force(replace(found, factor_deviation=deviation), apart, lag)
    return Check(
        name="force against control",
        status=status_of(fault is None),
        figure=apart if np.isfinite(apart) else None,
        threshold=_MAX_FORCE_DIFFERENCE,
        source="difference between the recorded force and the force by the control, in percent of "
        f"{of_maker} (rms), at frequencies far below the bandwidth of a current loop. The check "
        "also fails for a lag of more than 5 ms, for a factor that differs from 1 by more than 1 % "
        "and three standard errors (including that of the gain), and for a constant of more than "
        "1 % of the force and three standard errors",
        finding=ForceAgainstControl(
            fault=fault,
            difference_percent=apart,
            factor=found.factor,
            factor_uncertainty=found.factor_deviation,
            offset=found.offset,
            offset_uncertainty=found.offset_deviation,
            lag=lag,
            force_unit=str(axis.coordinate.force_unit),
            drive=drive.force_text(axis.coordinate),
            gain=_gain_of_force(axis, found.factor),
        ),
    )


def _fault_of_force(
    found: ColumnComparison, apart: float, lag: float
) -> Literal["scale", "offset", "other"] | None:
    """Return the kind of the difference between the recorded force and that by the control.

    None where they agree. It is ``scale`` for a factor alone, ``offset`` for a constant alone, and
    ``other`` for a late force or a larger difference.

    Parameters
    ----------
    found : ColumnComparison
    apart : float
        Difference, percent of the force by the control (rms).
    lag : float
        Lag of the recorded force, s.
    """
    far = found.distances
    is_near, is_late = apart <= _MAX_FORCE_DIFFERENCE, abs(lag) > _MAX_FORCE_LAG
    is_scaled = far["factor"] > 1
    if is_near and is_scaled:
        return "scale"
    if not is_near or is_late:
        return "other"
    return "offset" if far["offset"] > 1 else None


def _gain_of_force(axis: GeneratedAxis, factor: float) -> GainOfForce | None:
    """Return the declared drive gain and the one that fits the force.

    None for a drive that is more than a gain. `factor` is the recorded force over that by the
    declared gain.
    """
    drive = axis.drive
    if not drive.is_gain:
        return None
    return GainOfForce(
        declared=float(drive.gain),
        fitting=float(factor * drive.gain),
        unit=f"{axis.coordinate.force_unit}/{drive.unit}",
    )


def limit_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """Return the check of the recorded control against the limit of the drive.

    None without a control, without a limit, and where all samples are masked.
    """
    drive = axis.drive
    if record.control is None or not np.isfinite(drive.limit):
        return None
    size, most_excess = np.abs(record.control)[unmasked(record)], MAX_LIMIT_EXCESS.value
    if not size.size:
        return None
    share = float(np.mean(size > (1 + most_excess) * drive.limit))
    good, has_force = share <= _MAX_LIMIT_EXCESS_SHARE, record.force is not None
    return Check(
        name="control against limit",
        status=status_of(good, matters=not has_force),
        figure=100 * share,
        threshold=100 * _MAX_LIMIT_EXCESS_SHARE,
        source="samples with a control that exceeds the limit of the drive by more than "
        f"{100 * most_excess:g} %, in percent of all samples",
        finding=ControlAgainstLimit(
            is_beyond=not good,
            share_percent=100 * share,
            excess_percent=100 * most_excess,
            limit=float(drive.limit),
            largest=float(size.max()),
            unit=str(drive.unit),
            has_force=has_force,
        ),
    )


def _commanded(axis: GeneratedAxis, record: Record) -> tuple[Array, float]:
    """Return the force by the control of a record without gaps, (N,), and its slope by the gain.

    The slope is the relative change of the force by a relative change of the drive gain: 1 for a
    force that is proportional to the gain.
    """
    velocity = np.gradient(record.position, record.period)  # its noise is filtered with the force
    along = (
        acting_control(axis, np.asarray(record.control), [0], record.period),
        (record.position, velocity, np.gradient(velocity, record.period)),
        recorded_signals(axis, record.provenance.source, record.signals),
    )
    drive = DriveReplay(
        axis=axis, starts=[0], period=record.period, held=True, delay=0.0, mean=False
    )
    commanded, slope = (drive.force(*along, by_gain=by_gain) for by_gain in (False, True))
    used = unmasked(record)
    power = float(commanded[used] @ commanded[used])
    return commanded, float(slope[used] @ commanded[used]) / power if power else 1.0


@unless_missing
def _compared(columns: Columns) -> tuple[float, ColumnComparison] | Missing:
    """Return the difference of a measured force from the computed one, and their comparison.

    The difference is the root mean square in percent of the computed force. Behind a gear, the
    residual is not noise. The uncertainty of factor and constant is therefore at least a third of
    the residual.
    """
    computed, measured, rows, _ = columns
    if isinstance(found := compared_columns(columns), Missing):
        return found
    unexplained = found.left_percent / 100 / MIN_DISTANCE_FROM_NOISE.value
    return relative_error_percent((measured - computed)[rows], computed[rows]), replace(
        found,
        factor_deviation=max(found.factor_deviation, unexplained),
        offset_deviation=max(found.offset_deviation, unexplained * found.size),
    )


def compared_motion(
    record: Record, role: str, velocities: Sequence[Array] = ()
) -> ColumnComparison | Missing:
    """Compare a measured velocity or acceleration with the derivative of a measured column.

    A velocity without a position is compared with that of the simulated loop, where there is one.
    It follows the recorded reference nearly independently of the parameters, and has the scale and
    the zero of the motion.

    Parameters
    ----------
    record : Record
        Record with the measured column.
    role : {"velocity", "acceleration"}
        The measured column.
    velocities : sequence of (N,) array
        Velocity of the simulated loop in each segment; empty where there is no loop.

    Returns
    -------
    ColumnComparison or Missing
        Missing where there is no such derivative, or the record is too short or hardly moves.
    """
    longest = record.longest()
    by_position = role == "velocity" or record.velocity is None
    basis = longest.position if by_position else np.asarray(longest.velocity)
    times = 2 if role == "acceleration" and by_position else 1
    if by_position and record.integrated:
        if role != "velocity" or not velocities:
            return Missing(
                f"no position was recorded to compare the {role} with, and no loop can be "
                f"simulated. The scale of the motion relies only on the column of the {role}"
            )
        basis, times = max(velocities, key=len), 0
    return compared_columns(low_passed(longest, basis, np.asarray(getattr(longest, role)), times))


def derivative_check(
    axis: GeneratedAxis, record: Record, role: str, found: ColumnComparison | Missing | None
) -> Check | Missing | None:
    """Return the check of a measured velocity or acceleration against a derivative.

    None without the column. Missing where the comparison, `found`, is missing.
    """
    if found is None or isinstance(found, Missing):
        return found
    q, far = axis.coordinate, found.distances
    unit = str(q.velocity_unit if role == "velocity" else q.acceleration_unit)
    worst = max(far, key=lambda part: far[part])
    return Check(
        name=f"measured {role}",
        status=status_of(found.worst <= 1),
        figure=found.worst if np.isfinite(found.worst) else None,
        threshold=1.0,
        source="largest of four distances, each divided by its tolerance. The tolerances are "
        f"{MAX_SCALE_ERROR.value:g} for the distance of the factor from 1, "
        f"{MAX_MISALIGNMENT.value:g} samples for the delay and {100 * MAX_COLUMN_OFFSET:g} % of "
        f"the {role} for the constant, each at least three standard errors, and "
        f"{_MAX_DIFFERENCE:g} % of the {role} for the unexplained part. The check fails above 1",
        finding=MeasuredMotion(
            role=role,
            reference=_reference_of(record, role),
            is_other_signal=bool(far["left"] > 1),
            is_wrong=not found.worst <= 1,
            worst=found.worst,
            worst_of=_PARTS[worst],
            unexplained_percent=found.left_percent,
            factor=found.factor,
            factor_uncertainty=found.factor_deviation,
            delay=found.delay,
            delay_uncertainty=found.delay_deviation,
            offset=found.offset,
            offset_uncertainty=found.offset_deviation,
            unit=unit,
            corrections=_corrections(record, found, role, unit),
        ),
    )


def _reference_of(record: Record, role: str) -> MotionReference:
    """Return the signal that a measured velocity or acceleration is compared with."""
    if role == "velocity":
        if record.integrated:
            return "velocity of the simulated loop"
        return "derivative of the position"
    if record.velocity is None:
        return "second derivative of the position"
    return "derivative of the measured velocity"


def _corrections(
    record: Record, found: ColumnComparison, role: str, unit: str
) -> ColumnCorrections:
    """Return the corrections of a measured column that differs from a computed derivative.

    Parameters
    ----------
    record : Record
    found : ColumnComparison
    role : {"velocity", "acceleration"}
    unit : str
        Unit of the column in the model.
    """
    far = found.distances
    faults = tuple(part for part in _CORRECTED if far[part] > 1)
    shift: AdvisedShift | None = None
    if "delay" in faults and samples_apart(getattr(record, role)) == 1:
        shift = shift_into_time(role, found.delay, MAX_MISALIGNMENT.value)
    vague = MIN_DISTANCE_FROM_NOISE.value * found.factor_deviation / (abs(found.factor) or _TINY)
    vague += MAX_SCALE_ERROR.value
    is_by_loop = role == "velocity" and record.integrated
    return ColumnCorrections(
        column=record.provenance.columns.get(role, "NAME"),
        faults=faults,
        shift=shift,
        likely_unit=likely_unit(unit, found.factor, vague) if "factor" in faults else None,
        is_reversed=abs(found.factor + 1) <= vague,
        scale_reference="reference" if is_by_loop else "position",
    )
