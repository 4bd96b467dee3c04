"""A measured column against what it should be, whatever the model: a factor, a delay, a constant.

Either may be noisy. The factor of a regression is then too small, and the inverse of the other
way's too large, so that the truth lies between the two [Frisch1934]_. A delay is found by moving
the computed column until the regression asks for no more: there noise has nothing to attenuate.

A force is held against what the drive makes of the control, a velocity against the position's
derivative, an acceleration against the velocity's. A factor between them is a unit or a scale, a
delay the drive's filter or the logger's, a constant the zero of a sensor.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import Record, advised_interpolation, advised_shift, samples_apart
from axisid.estimation.records.columns import scale_remedy
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
from axisid.support.errors import EstimationError, Missing, first_case, unless_missing

# Hz, up to which columns are compared: far below any current loop's bandwidth
_MAX_CUTOFF = 30.0
# samples, by those in which the low-pass settles; fewer are not compared
_MIN_SETTLING_TIMES = 10
MAX_COLUMN_OFFSET = 0.01  # constant between the two, by the computed one's root mean square
# % of the computed one, left by factor, delay and constant; from there on the column is another
# signal, as noise in the band is far less
_MAX_DIFFERENCE = 30.0

_OFTEN = 4  # rows in a period of the highest frequency that is left
_STEPS, _STILL = 12, 1e-3  # of the search for the delay, samples
_FARTHEST = 50.0  # samples of delay that are looked for
_MAX_FORCE_DIFFERENCE = 20.0  # % between the recorded force and what the drive makes of the control
_TINY = 1e-300
_MAX_FORCE_LAG = 5e-3  # s, of the recorded force behind the control
# of the samples, at which the control may be beyond the limit: spikes may be
_MAX_LIMIT_EXCESS_SHARE = 1e-3


#: Two columns, (N,) each, the rows that tell all of them, and how many samples these are apart.
Columns = tuple[Array, Array, NDArray[np.int64], int]


def unmasked(record: Record) -> NDArray[np.bool_]:
    """Which samples are not masked, (N,)."""
    return ~mask_of(record.masked, len(record))


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnComparison:
    """A measured column against a computed one.

    Attributes
    ----------
    factor : float
        Of the measured one, in the middle of what noise leaves open; null where nothing is alike.
    factor_deviation : float
        Half of what noise leaves open.
    delay : float
        Of the measured one, samples.
    delay_deviation : float
    offset : float
        What is constant between the two, SI.
    offset_deviation : float
    size : float
        Root mean square of the computed one, SI.
    left_percent : float
        What remains of either beside the other, percent of it.
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
        """Of the factor from 1, of delay, constant and what is left, by what each may be."""
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
        """The largest of them; beyond 1 something is wrong."""
        return max(self.distances.values())


@unless_missing
def compared_columns(columns: Columns) -> ColumnComparison | Missing:
    """The one beside the other, in one row of so many; missing where the axis hardly moves there.

    The delay is the one that leaves none to be fitted. Two signals that have nothing to do with
    each other have none.
    """
    computed, measured, rows, step = columns
    order = RowTimes(rows // step)

    def fit(given: Array, target: Array) -> Solution:
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
        return Missing("the axis hardly moves in what is compared")
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
    """Two columns of a record of one piece, low-passed alike, and the rows that tell all of them.

    The computed one is differentiated so many times. Of the samples one in so many is a row: what
    is slow needs no more.
    """
    period = record.period
    cutoff = min(COMPARISON_CUTOFF.value / period, _MAX_CUTOFF)
    settle = round(1 / (cutoff * period))
    used = scipy.ndimage.minimum_filter1d(unmasked(record), 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < _MIN_SETTLING_TIMES * settle:
        return Missing("too few samples that follow one another were measured for it")
    smooth = SampledFilter(Prefilter(cutoff=cutoff), period)
    computed, measured = smooth.low_passed(computed), smooth.low_passed(measured)
    for _ in range(times):
        computed = np.gradient(computed, period)
        # Means over the two samples that a central difference spans, by Simpson's rule.
        measured[1:-1] = (measured[:-2] + 4 * measured[1:-1] + measured[2:]) / 6
    step = max(settle // _OFTEN, 1)
    return computed, measured, np.flatnonzero(used).astype(np.int64)[::step], step


def force_check(axis: GeneratedAxis, record: Record) -> Check | Missing | None:
    """The recorded force against what the drive makes of the control; nothing without both."""
    if record.force is None or record.control is None:
        return None
    drive, longest = axis.drive, record.longest()
    maker, of_maker = (
        ("the drive's gain", "gain times control")
        if drive.is_gain
        else ("the drive", "what the drive makes of the control")
    )
    commanded, by_gain = _commanded(axis, longest)
    # Behind a low-pass, so that what a current loop and its sensor do is no factor.
    compared = _compared(low_passed(longest, commanded, np.asarray(longest.force)))
    if isinstance(compared, Missing):
        return compared
    apart, found = compared
    deviation = float(np.hypot(found.factor_deviation, drive.relative_sd * by_gain))
    far = replace(found, factor_deviation=deviation).distances
    scaled, shifted, q = far["factor"] > 1, far["offset"] > 1, axis.coordinate
    lag, near = found.delay * record.period, apart <= _MAX_FORCE_DIFFERENCE
    late = abs(lag) > _MAX_FORCE_LAG
    good = near and not (scaled or late or shifted)
    suspect = (
        f"the gain, which would be {found.factor * drive.gain:.4g} {q.force_unit}/{drive.unit} "
        f"for {drive.gain:g}"
        if drive.is_gain
        else f"the drive ({drive.force_text(q)})"
    )
    meaning = "the force column is " + first_case(
        (good, f"what {maker} makes of the control"),
        (
            near and scaled,
            f"{found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} "
            f"times what {maker} makes of the control, and otherwise the same: every parameter is "
            f"scaled by it. Check the force column's scale and {suspect}, or declare how well the "
            "gain is known (relative_sd)",
        ),
        (
            near and not late,
            f"{found.offset:+.4g} +- {found.offset_deviation:.1g} "
            f"{q.force_unit} beside what {maker} makes of the control, and otherwise the same: a "
            "constant force, and friction that differs with the direction, take it up. Check the "
            "zero of the force's sensor, or of the control's converter",
        ),
        (
            True,
            f"{found.factor:.3g} times what {maker} makes of the control, "
            f"{1e3 * lag:.2g} ms later and {apart:.3g} % off it: check the column, its "
            f"unit and timing, and the {'gain' if drive.is_gain else 'drive'}",
        ),
    )
    return Check(
        name="force against control",
        status=status_of(good),
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
    drive = axis.drive
    if record.control is None or not np.isfinite(drive.limit):
        return None
    size, most_excess = np.abs(record.control)[unmasked(record)], MAX_LIMIT_EXCESS.value
    if not size.size:
        return None
    share = float(np.mean(size > (1 + most_excess) * drive.limit))
    good, used = share <= _MAX_LIMIT_EXCESS_SHARE, record.force is None
    return Check(
        name="control against limit",
        status=status_of(good, matters=used),
        figure=100 * share,
        threshold=100 * _MAX_LIMIT_EXCESS_SHARE,
        source=f"percent of the samples at which the control is more than {100 * most_excess:g} % "
        "beyond the drive's limit",
        meaning=f"the control stays within the drive's limit of {drive.limit:g} {drive.unit}"
        if good
        else f"the control is beyond the drive's limit of {drive.limit:g} {drive.unit} in "
        f"{100 * share:.2g} % of the samples, up to {size.max():.3g} {drive.unit}: "
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
    """How far a measured force is apart from the computed one, percent, and what is between them.

    What is left is no noise where the force is measured behind a gear: a factor that explains no
    more than that is none.
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
    """Hold a measured velocity or acceleration against the derivative of what was measured before.

    A velocity without a position is held against that of the simulated loop, where there is one:
    it follows the recorded reference, whatever its parameters are but for a little, and has the
    scale and the zero of the motion.

    Parameters
    ----------
    record : Record
        With that column.
    role : {"velocity", "acceleration"}
    velocities : sequence of (N,) array
        Of the loop, by segment.

    Returns
    -------
    ColumnComparison or Missing
        Missing where there is no such derivative, or the record is too short or still to tell.
    """
    longest = record.longest()
    by_position = role == "velocity" or record.velocity is None
    basis = longest.position if by_position else np.asarray(longest.velocity)
    times = 2 if role == "acceleration" and by_position else 1
    if by_position and record.integrated:
        if role != "velocity" or not velocities:
            return Missing(
                f"no position was recorded that the {role} could be held against, and no loop can "
                f"be simulated: the scale of the motion rests on the column of the {role} alone"
            )
        basis, times = max(velocities, key=len), 0
    return compared_columns(low_passed(longest, basis, np.asarray(getattr(longest, role)), times))


def derivative_check(
    axis: GeneratedAxis, record: Record, role: str, found: ColumnComparison | Missing | None
) -> Check | Missing | None:
    """What was found of a measured velocity or acceleration; nothing without the column."""
    if found is None or isinstance(found, Missing):
        return found
    q, way = axis.coordinate, "late" if found.delay >= 0 else "early"
    unit = str(q.velocity_unit if role == "velocity" else q.acceleration_unit)
    against = first_case(
        (
            role == "velocity" and record.integrated,
            "that of the simulated loop, which follows the reference",
        ),
        (role == "velocity", "the position's derivative"),
        (record.velocity is None, "the position's second derivative"),
        (True, "the measured velocity's derivative"),
    )
    told = (
        f"{found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} times, "
        f"{abs(found.delay):.2f} +- {max(found.delay_deviation, 1e-2):.1g} samples {way} and "
        f"{found.offset:+.3g} +- {found.offset_deviation:.1g} {unit}"
    )
    meaning = first_case(
        (
            found.distances["left"] > 1,
            f"is not {against}: {found.left_percent:.3g} % are left whatever factor, delay and "
            f"constant ({told}): check the column (columns {role}=NAME:UNIT)",
        ),
        (
            found.worst > 1,
            f"is {told} beside {against}: {_remedy(record, found, role, unit)}",
        ),
        (True, f"is {against} ({told})"),
    )
    return Check(
        name=f"measured {role}",
        status=status_of(found.worst <= 1),
        figure=found.worst if np.isfinite(found.worst) else None,
        threshold=1.0,
        source="largest of the factor's distance from 1 by "
        f"{MAX_SCALE_ERROR.value:g}, the delay by {MAX_MISALIGNMENT.value:g} samples and "
        f"the constant by {100 * MAX_COLUMN_OFFSET:g} % of the {role}, or by three of their "
        "deviations where these are more",
        meaning=f"the measured {role} {meaning}",
    )


def _remedy(record: Record, found: ColumnComparison, role: str, unit: str) -> str:
    """What sets right what is wrong."""
    far, name = found.distances, record.provenance.columns.get(role, "NAME")
    vague = MIN_DISTANCE_FROM_NOISE.value * found.factor_deviation / (abs(found.factor) or _TINY)
    vague += MAX_SCALE_ERROR.value
    column, of_sign, zero = (
        f"columns {role}={name}:UNIT{change}"
        for change in ("", "*-1", f"{-found.offset:+.3g}{unit}")
    )
    beside = "reference" if role == "velocity" and record.integrated else "position"
    parts = {
        "delay": first_case(
            (
                samples_apart(getattr(record, role)) > 1,
                f"draw it between its values ({advised_interpolation(role)})",
            ),
            (True, advised_shift(role, found.delay, MAX_MISALIGNMENT.value)),
        ),
        "factor": scale_remedy(role, name, unit, found.factor, vague)
        or first_case(
            (abs(found.factor + 1) <= vague, f"turn its sign ({of_sign})"),
            (
                True,
                f"check its unit and scale, and those of the {beside} ({column})",
            ),
        ),
        "offset": f"take off its zero ({zero})",
    }
    return ", and ".join(part for what, part in parts.items() if far[what] > 1)
