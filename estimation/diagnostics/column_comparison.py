"""Comparison of a measured column with a computed one: a factor, a delay and a constant.

The comparison does not depend on the model. Both columns may be noisy. The factor of a regression
is then too small, and the inverse of the factor of the reverse regression is too large, so that the
true factor lies between the two [Frisch1934]_. The delay is found by shifting the computed column
until the regression gives a delay of 0, where noise attenuates nothing.

A force is compared with the force that the drive makes of the control, a velocity with the
derivative of the position, an acceleration with the derivative of the velocity or the second
derivative of the position. The usual cause of a factor between them is a unit or a scale, that of a
delay is a filter in the drive or the logger, and that of a constant is the zero of a sensor.
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

# Hz; columns are compared below this frequency, far below the bandwidth of any current loop
_MAX_CUTOFF = 30.0
# fewest samples that are compared, in settling times of the low-pass
_MIN_SETTLING_TIMES = 10
MAX_COLUMN_OFFSET = 0.01  # constant between both columns, relative to the rms of the computed one
# % of the computed column that factor, delay and constant do not explain; with more, the column is
# another signal, as noise in the band is far less
_MAX_DIFFERENCE = 30.0

_ROWS_PER_PERIOD = 4  # of the highest frequency in the band
_MAX_STEPS = 12  # of the search for the delay
_CONVERGED = 1e-3  # step up to which the search has converged, samples
_MAX_DELAY = 50.0  # largest delay that is searched for, samples
_MAX_FORCE_DIFFERENCE = 20.0  # % between the recorded force and the force by the control
_TINY = 1e-300
_MAX_FORCE_LAG = 5e-3  # s, of the recorded force behind the control
# share of the samples at which the control may be beyond the limit, such as spikes
_MAX_LIMIT_EXCESS_SHARE = 1e-3
# properties of a measured column, in the order in which they are corrected
_CORRECTED: tuple[ColumnFault, ...] = ("delay", "factor", "offset")
# names in a finding of the distances in `ColumnComparison.distances`
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
        Measured divided by computed column: the middle of the range that noise allows; null for
        unrelated columns.
    factor_deviation : float
        Half the width of the range of the factor, combined with the standard error of a regression.
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
        Part of a column that the other column, its derivative and a constant do not explain, in
        percent of the column (rms).
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

        Each distance is divided by its tolerance, and is too large above 1. The names are
        ``factor``, ``delay``, ``offset`` for the constant, and ``left`` for the unexplained part.
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
        """Largest of the `distances`; the measured column is wrong if this is more than 1."""
        return max(self.distances.values())


@unless_missing
def compared_columns(columns: Columns) -> ColumnComparison | Missing:
    """Return the comparison of two columns; Missing where the axis hardly moves in the rows.

    The measured column is regressed on the computed one, its derivative and a constant. The
    computed column is shifted by the delay until the regression finds no further delay. If the
    delay leaves the search range, as for unrelated signals, it is set to 0. The reverse regression
    then gives the other end of the range of the factor.

    Parameters
    ----------
    columns : Columns
        Both columns, and the rows to compare.
    """
    computed, measured, rows, step = columns
    order = RowTimes(rows // step)

    def fit(given: Array, target: Array) -> Solution:
        """Return the regression of a column on another, its derivative and a constant."""
        columns = np.column_stack([given, np.gradient(given), np.ones_like(given)])[rows]
        regressor = factor(columns, ("factor", "delay", "offset"), neighbours=order)
        return least_squares(target[rows], regressor)

    delay, shifted = 0.0, computed
    try:
        # Shift of the computed column, up to a regression without a delay.
        fitted = unshifted = fit(computed, measured)
        for _ in range(_MAX_STEPS):
            gain, by_sample, _ = map(float, fitted.theta)
            change = -by_sample / gain if gain else np.inf
            if abs(change) < _CONVERGED:
                break
            if not abs(delay + change) < _MAX_DELAY:
                delay, shifted, fitted = 0.0, computed, unshifted
                break
            delay += change
            shifted = np.asarray(
                scipy.ndimage.shift(computed, delay, order=3, mode="nearest"), dtype=float
            )
            fitted = fit(shifted, measured)
        reverse = fit(measured, shifted)
    except EstimationError:
        return Missing("the axis hardly moves in the compared samples")
    # Range of the factor, from both regressions, and standard errors.
    deviations = np.sqrt(np.diag(Hac(2 * _ROWS_PER_PERIOD).matrix(fitted)))
    factors = float(fitted.theta[0]), 1 / (float(reverse.theta[0]) or _TINY)
    gain = sum(factors) / 2
    correlation_squared = float(fitted.theta[0] * reverse.theta[0])  # partial
    return ColumnComparison(
        factor=gain,
        factor_deviation=float(np.hypot(deviations[0], np.subtract(*factors) / 2)),
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

    The computed column is also differentiated. The rows are decimated samples, which suffices below
    the cut-off. Missing where too few consecutive samples are not masked.

    Parameters
    ----------
    record : Record
        Record without gaps.
    computed, measured : (N,) array
        The two columns.
    times : int
        Number of derivatives of the computed column.
    """
    period = record.period
    cutoff = min(COMPARISON_CUTOFF.value / period, _MAX_CUTOFF)
    settle = round(1 / (cutoff * period))
    used = scipy.ndimage.minimum_filter1d(unmasked(record), 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < _MIN_SETTLING_TIMES * settle:
        return Missing(
            "the record has too few consecutive samples that are not masked. Record a longer motion"
        )
    smooth = SampledFilter(Prefilter(cutoff=cutoff), period)
    computed, measured = smooth.low_passed(computed), smooth.low_passed(measured)
    for _ in range(times):
        computed = np.gradient(computed, period)
        # Means over the two samples that a central difference spans, by Simpson's rule.
        measured[1:-1] = (measured[:-2] + 4 * measured[1:-1] + measured[2:]) / 6
    step = max(settle // _ROWS_PER_PERIOD, 1)
    return computed, measured, np.flatnonzero(used).astype(np.int64)[::step], step


def force_check(axis: GeneratedAxis, record: Record) -> Check | Missing | None:
    """Return the check of the recorded force against the force from the control.

    Both forces pass a low-pass, and are compared by a factor, a delay and a constant. The fault is
    judged with the uncertainty of the declared gain added to that of the factor, because a factor
    within the uncertainty of the gain is no fault. The finding reports the factor as it was
    measured, with the uncertainty of the comparison alone.

    None without both columns. Missing where they cannot be compared.
    """
    if record.force is None or record.control is None:
        return None
    drive, longest = axis.drive, record.longest()
    computed_force = "the force that the drive makes of the control"
    if drive.is_gain:
        computed_force = "gain times control"
    # After a low-pass, the dynamics of the current loop and its sensor do not affect the factor.
    commanded, share_by_gain = _commanded(axis, longest)
    compared = _compared(low_passed(longest, commanded, np.asarray(longest.force)))
    if isinstance(compared, Missing):
        return compared
    difference_percent, found = compared
    lag = found.delay * record.period
    # A relative error of the declared gain changes the factor by the share of the force that scales
    # with the gain.
    deviation = float(np.hypot(found.factor_deviation, drive.relative_sd * share_by_gain))
    with_gain_uncertainty = replace(found, factor_deviation=deviation)
    fault = _fault_of_force(with_gain_uncertainty, difference_percent, lag)
    # The difference is not finite if the force from the control is 0 in all compared rows.
    figure = difference_percent if np.isfinite(difference_percent) else None
    return Check(
        name="force against control",
        status=status_of(fault is None),
        figure=figure,
        threshold=_MAX_FORCE_DIFFERENCE,
        source="difference between the recorded force and the force from the control, in percent "
        f"of {computed_force} (rms), at frequencies far below the bandwidth of a current loop. The "
        "check also fails for a lag of more than 5 ms, for a factor that differs from 1 by more "
        "than 1 % and three standard errors (including that of the gain), and for a constant of "
        "more than 1 % of the force and three standard errors",
        finding=ForceAgainstControl(
            fault=fault,
            difference_percent=difference_percent,
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
    found: ColumnComparison, difference_percent: float, lag: float
) -> Literal["scale", "offset", "other"] | None:
    """Return the kind of the difference between the recorded force and that from the control.

    None where they agree. The first cause that applies is returned: ``other`` for a large
    difference, ``scale`` for a factor, ``other`` for a late force, ``offset`` for a constant.

    Parameters
    ----------
    found : ColumnComparison
        Comparison, with the uncertainty of the declared gain in that of the factor.
    difference_percent : float
        Difference, percent of the force from the control (rms).
    lag : float
        Lag of the recorded force, s.
    """
    far = found.distances
    is_near = difference_percent <= _MAX_FORCE_DIFFERENCE
    is_late = abs(lag) > _MAX_FORCE_LAG
    is_scaled = far["factor"] > 1
    if is_near and is_scaled:
        return "scale"
    if not is_near or is_late:
        return "other"
    return "offset" if far["offset"] > 1 else None


def _gain_of_force(axis: GeneratedAxis, factor: float) -> GainOfForce | None:
    """Return the declared drive gain and the gain that fits the recorded force.

    None for a drive that is more than a gain. `factor` is the recorded force divided by the force
    with the declared gain.
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

    It is at most a note for a record with a force, because only the simulated loop then uses the
    control. None without a control, without a limit, and where all samples are masked.
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
    """Return the force from the control of a record without gaps, (N,), and its share by the gain.

    This is the share of the force that scales with the gain: the relative change of the force by a
    relative change of the drive gain. It is 1 for a force that is proportional to the gain.
    """
    # Inputs of the drive: control, motion and recorded signals.
    velocity = np.gradient(record.position, record.period)  # its noise is filtered with the force
    along = (
        acting_control(axis, np.asarray(record.control), [0], record.period),
        (record.position, velocity, np.gradient(velocity, record.period)),
        recorded_signals(axis, record.provenance.source, record.signals),
    )
    drive = DriveReplay(
        axis=axis, starts=[0], period=record.period, held=True, delay=0.0, mean=False
    )
    commanded = drive.force(*along, by_gain=False)
    by_log_gain = drive.force(*along, by_gain=True)  # derivative by the logarithm of the gain
    # The share is the slope of a regression of this derivative on the force.
    used = unmasked(record)
    power = float(commanded[used] @ commanded[used])
    share_by_gain = float(by_log_gain[used] @ commanded[used]) / power if power else 1.0
    return commanded, share_by_gain


@unless_missing
def _compared(columns: Columns) -> tuple[float, ColumnComparison] | Missing:
    """Return the difference of a measured force from the computed one, and their comparison.

    The difference is the root mean square in percent of the computed force. Behind a gear, the
    residual is not noise. The uncertainty of factor and constant is therefore at least a third of
    the residual. Missing where the columns cannot be compared.
    """
    computed, measured, rows, _ = columns
    found = compared_columns(columns)
    if isinstance(found, Missing):
        return found
    difference_percent = relative_error_percent((measured - computed)[rows], computed[rows])
    unexplained = found.left_percent / 100 / MIN_DISTANCE_FROM_NOISE.value
    found = replace(
        found,
        factor_deviation=max(found.factor_deviation, unexplained),
        offset_deviation=max(found.offset_deviation, unexplained * found.size),
    )
    return difference_percent, found


def compared_motion(
    record: Record, role: str, velocities: Sequence[Array] = ()
) -> ColumnComparison | Missing:
    """Return the comparison of a measured velocity or acceleration with a derivative.

    It is the derivative of the position, or, for an acceleration, of the measured velocity. A
    velocity without a position is compared with the velocity of the simulated loop, where there is
    one. The simulated loop follows the recorded reference nearly independently of the parameters,
    and its velocity has the scale and the zero of the motion.

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
        Missing, with the reason, where there is no such derivative, the record is too short, or the
        axis hardly moves.
    """
    # The column to differentiate, and how many times.
    longest = record.longest()
    by_position = role == "velocity" or record.velocity is None
    basis = longest.position if by_position else np.asarray(longest.velocity)
    times = 2 if role == "acceleration" and by_position else 1
    # The position was not recorded but integrated from the velocity.
    if by_position and record.integrated:
        if role != "velocity" or not velocities:
            return Missing(
                f"no position was recorded for a comparison with the {role}, and no loop can be "
                f"simulated. The scale of the motion relies only on the column of the {role}"
            )
        basis, times = max(velocities, key=len), 0
    return compared_columns(low_passed(longest, basis, np.asarray(getattr(longest, role)), times))


def derivative_check(
    axis: GeneratedAxis, record: Record, role: str, found: ColumnComparison | Missing | None
) -> Check | Missing | None:
    """Return the check of a measured velocity or acceleration against a derivative.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    role : {"velocity", "acceleration"}
        The measured column.
    found : ColumnComparison, Missing or None
        Comparison of the column; None where it was not measured. Missing and None are returned
        unchanged.
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
    # Relative uncertainty of the factor, within which it is that of a usual unit or a sign.
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
