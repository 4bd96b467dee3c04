"""A force column beside a control: the two must belong together, and the control within limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.records import Record
from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import (
    DriveAlong,
    Neighbours,
    Prefilter,
    SampledFilter,
    acting_control,
    drive_force,
    recorded_signals,
)
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    MAX_LIMIT_EXCESS,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.support.arrays import Array, covered, relative_error_percent
from axisid.support.errors import EstimationError

# Hz, up to which force and control are compared: far below any current loop's bandwidth
MAX_FORCE_CUTOFF = 30.0
_MAX_FORCE_DIFFERENCE = 20.0  # % between the recorded force and what the drive makes of the control
_MAX_FORCE_OFFSET = 0.01  # constant between the two, by their root mean square
_MAX_FORCE_LAG = 5e-3  # s, of the recorded force behind the control
# of the samples, at which the control may be beyond the limit: spikes may be
_MAX_LIMIT_EXCESS_SHARE = 1e-3
# samples, by those in which the low-pass settles; fewer are compared without it
MIN_SETTLING_TIMES = 10

_NAME = "force against control"
_OFTEN = 4  # rows in a period of the highest frequency that is left
_LIMIT = "control against limit"


@dataclass(frozen=True, slots=True, kw_only=True)
class _ForceComparison:
    """A force against a commanded one.

    Attributes
    ----------
    apart : float
        Percent of the commanded one.
    scale, deviation : float
        Factor between the two, and how well it is known.
    lag : float
        s.
    offset, offset_deviation : float
        What is constant between the two, in the force's unit; 0 where it cannot be told.
    size : float
        Root mean square of the commanded one.
    """

    apart: float
    scale: float
    deviation: float
    lag: float
    offset: float = 0.0
    offset_deviation: float = 0.0
    size: float = 0.0

    @property
    def is_shifted(self) -> bool:
        """Whether a constant stands out of what else is between the two."""
        least = max(
            _MAX_FORCE_OFFSET * self.size,
            MIN_DISTANCE_FROM_NOISE.value * self.offset_deviation,
        )
        return abs(self.offset) > least


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
    found = _compared(axis, longest)
    vague = float(np.hypot(found.deviation, drive.relative_sd * _factor_by_gain(axis, longest)))
    allowed = max(MAX_SCALE_ERROR.value, MIN_DISTANCE_FROM_NOISE.value * vague)
    scaled = abs(found.scale - 1) > allowed
    near = bool(found.apart <= _MAX_FORCE_DIFFERENCE)
    late = abs(found.lag) > _MAX_FORCE_LAG
    good = near and not scaled and not late and not found.is_shifted
    if good:
        meaning = f"the force column is what {maker} makes of the control"
    elif near and scaled:
        meaning = _scaled(axis, found, maker)
    elif near and not late:
        meaning = _shifted(axis, found, maker)
    else:
        meaning = (
            f"the force column is {found.scale:.3g} times what {maker} makes of the control, "
            f"{1e3 * found.lag:.2g} ms later and {found.apart:.3g} % off it: check the column, its "
            f"unit and timing, and the {'gain' if drive.is_gain else 'drive'}"
        )
    return Check(
        name=_NAME,
        status=passed(good),
        figure=found.apart if np.isfinite(found.apart) else None,
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
    size, most_excess = np.abs(record.control)[_unmasked(record)], MAX_LIMIT_EXCESS.value
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


def _scaled(axis: GeneratedAxis, found: _ForceComparison, maker: str) -> str:
    drive, q = axis.axis.drive, axis.axis.coordinate
    suspect = (
        f"the gain, which would be {found.scale * drive.gain:.4g} {q.force_unit}/{drive.unit} for "
        f"{drive.gain:g}"
        if drive.is_gain
        else f"the drive ({drive.force_text(q)})"
    )
    return (
        f"the force column is {found.scale:.4g} +- {max(found.deviation, 1e-4):.1g} times what "
        f"{maker} makes of the control, and otherwise the same: every parameter is scaled by it. "
        f"Check the force column's scale and {suspect}, or declare how well the gain is known "
        "(relative_sd)"
    )


def _shifted(axis: GeneratedAxis, found: _ForceComparison, maker: str) -> str:
    unit = axis.axis.coordinate.force_unit
    return (
        f"the force column is {found.offset:+.4g} +- {found.offset_deviation:.1g} {unit} beside "
        f"what {maker} makes of the control, and otherwise the same: a constant force, and "
        "friction that differs with the direction, take it up. Check the zero of the force's "
        "sensor, or of the control's converter"
    )


def _factor_by_gain(axis: GeneratedAxis, record: Record) -> float:
    """Slope of the factor by the logarithm of the gain: 1 for a force that is all the gain's."""
    if axis.axis.drive.is_gain:
        return 1.0
    control, velocity = _acting(axis, record), np.gradient(record.position, record.period)
    recorded = recorded_signals(axis, record.provenance.source, record.signals)
    motion = record.position, velocity, recorded
    used = _unmasked(record)
    commanded = drive_force(axis, control, *motion)[used]
    slope = axis.force_by_gain(control, *motion)[used]
    return float(slope @ commanded / (commanded @ commanded))


def _compared(axis: GeneratedAxis, record: Record) -> _ForceComparison:
    """Both low-passed alike, so that what a current loop and its sensor do is no factor.

    The first two derivatives of the command stand for the loop's lag.
    """
    force, control = np.asarray(record.force), _acting(axis, record)
    velocity = np.gradient(record.position, record.period)  # its noise is filtered with the force
    recorded = recorded_signals(axis, record.provenance.source, record.signals)
    drive = DriveAlong(
        axis=axis, starts=[0], period=record.period, held=True, delay=0.0, mean=False
    )
    motion = record.position, velocity, np.gradient(velocity, record.period)
    commanded = drive.force(control, motion, recorded)
    cutoff = min(COMPARISON_CUTOFF.value / record.period, MAX_FORCE_CUTOFF)
    settle = round(1 / (cutoff * record.period))
    used = minimum_filter1d(_unmasked(record), 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < MIN_SETTLING_TIMES * settle:
        return _at_once(force, commanded)
    smooth = SampledFilter(Prefilter(cutoff=cutoff), record.period)
    rows = np.flatnonzero(used)[:: max(settle // _OFTEN, 1)]  # what is slow needs no more
    slow, faster, fastest = (each[rows] for each in smooth.motion(commanded))
    target = smooth.motion(force)[0][rows]
    columns = np.column_stack([slow, faster, fastest, np.ones_like(slow)])
    try:
        names = ("factor", "lag", "second lag", "offset")
        order = Neighbours.of(rows, max(settle // _OFTEN, 1))
        fit = least_squares(target, factor(columns, names, neighbours=order))
    except EstimationError:
        return _at_once(force, commanded)
    scale, behind = float(fit.theta[0]), float(fit.theta[1])
    # What is left is no noise where the force is measured behind a gear: a factor that explains
    # no more than that is none.
    left = float(np.linalg.norm(fit.residuals) / np.linalg.norm(slow))
    statistical = np.sqrt(np.diag(Hac(2 * _OFTEN).matrix(fit)))
    size = float(np.sqrt(np.mean(slow**2)))
    unexplained = left / MIN_DISTANCE_FROM_NOISE.value
    return _ForceComparison(
        apart=relative_error_percent(target - slow, slow),
        scale=scale,
        deviation=max(float(statistical[0]), unexplained),
        lag=-behind / scale if scale else 0.0,
        offset=float(fit.theta[3]),
        offset_deviation=max(float(statistical[3]), unexplained * size),
        size=size,
    )


def _at_once(force: Array, commanded: Array) -> _ForceComparison:
    """As they are; of a few samples no factor can be told."""
    scale = float(commanded @ force / (commanded @ commanded))
    apart = relative_error_percent(force - commanded, commanded)
    return _ForceComparison(apart=apart, scale=scale, deviation=abs(scale - 1), lag=0.0)


def _acting(axis: GeneratedAxis, record: Record) -> Array:
    """The control of which the drive makes its force, of a record of one piece, (N,)."""
    return acting_control(axis, np.asarray(record.control), [0], record.period)


def _unmasked(record: Record) -> NDArray[np.bool_]:
    return ~covered(record.masked, len(record))
