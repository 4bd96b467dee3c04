"""A force column beside a control: the two must belong together, and the control within limits."""

import numpy as np
from numpy.typing import NDArray

from axisid.codegen import GeneratedAxis

from .arrays import relative_error_percent
from .check import Check, passed
from .covariance import Hac
from .errors import EstimationError
from .linear import factor, least_squares
from .prefilter import Prefilter
from .record import Record

_NAME = "force against control"
_MOST = 20.0  # percent
_EXACT = 0.01  # distance of the factor from 1
_DEVIATIONS = 3.0
_SMOOTH = 0.02  # of the sampling frequency, far below the bandwidth of any current loop
_SETTLE = round(1 / _SMOOTH)  # samples
_FEWEST = 10 * _SETTLE
_LIMIT = "control against limit"
_BEYOND = 0.02  # of the limit, which a converter's noise does not reach
_RARE = 1e-3  # of the samples, which spikes may be


def force_checks(axis: GeneratedAxis, record: Record) -> tuple[Check, ...]:
    """The recorded force against the drive's gain times the control; nothing without both."""
    if record.force is None or record.control is None:
        return ()
    commanded = axis.axis.drive.gain * record.control
    apart = relative_error_percent(record.force - commanded, commanded)
    scale, deviation = _factor(record.longest(), axis.axis.drive.gain)
    allowed = max(_EXACT, _DEVIATIONS * float(np.hypot(deviation, axis.axis.drive.relative_sd)))
    near, scaled = bool(apart <= _MOST), abs(scale - 1) > allowed
    check = Check(
        name=_NAME,
        status=passed(near and not scaled),
        figure=apart if np.isfinite(apart) else None,
        threshold=_MOST,
        source="difference in percent of gain times control, which a drive's own loop may leave; "
        "fails too where the factor between the two, in what is slow against that loop, is off 1 "
        "by more than 1 % and three deviations, that of the gain among them",
        meaning="the force column is what the drive's gain makes of the control"
        if near and not scaled
        else _scaled(axis, scale, deviation)
        if near
        else f"the force column is {scale:.3g} times what the drive's gain makes of the control, "
        f"and {apart:.3g} % off it: check the column, its unit and timing, and the gain",
    )
    return (check,)


def limit_checks(axis: GeneratedAxis, record: Record) -> tuple[Check, ...]:
    """The recorded control against the drive's limit; nothing without either."""
    drive = axis.axis.drive
    if record.control is None or not np.isfinite(drive.limit):
        return ()
    size = np.abs(record.control)[_unmasked(record)]
    if not size.size:
        return ()
    beyond = size > (1 + _BEYOND) * drive.limit
    share = float(np.mean(beyond))
    good, used = share <= _RARE, record.force is None
    most = float(size.max())
    check = Check(
        name=_LIMIT,
        status=passed(good, matters=used),
        figure=100 * share,
        threshold=100 * _RARE,
        source=f"percent of the samples at which the control is more than {100 * _BEYOND:g} % "
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
    return (check,)


def _scaled(axis: GeneratedAxis, scale: float, deviation: float) -> str:
    unit = f"{axis.axis.coordinate.force_unit}/{axis.axis.drive.unit}"
    gain = axis.axis.drive.gain
    return (
        f"the force column is {scale:.4g} +- {max(deviation, 1e-4):.1g} times what the drive's "
        f"gain makes of the control, and otherwise the same: every parameter is scaled by it. "
        f"Check the force column's scale and the gain, which would be {scale * gain:.4g} {unit} "
        f"for {gain:g}, or declare how well the gain is known (relative_sd)"
    )


def _factor(record: Record, gain: float) -> tuple[float, float]:
    """What the force is times the commanded one, with its deviation.

    Of both low-passed alike, so that neither the lag of a current loop nor the scatter of a current
    sensor is taken for a factor: the first two derivatives of the command stand for the lag.
    """
    force, commanded = np.asarray(record.force), gain * np.asarray(record.control)
    rough = float(commanded @ force / (commanded @ commanded))
    used = _unmasked(record)
    used[:_SETTLE] = used[-_SETTLE:] = False
    if used.sum() < _FEWEST:
        return rough, abs(rough - 1)
    smooth = Prefilter(cutoff=_SMOOTH / record.period)
    slow, faster, fastest = smooth.motion(commanded, record.period)
    target = smooth.motion(force, record.period)[0][used]
    columns = np.column_stack([slow, faster, fastest, np.ones_like(slow)])[used]
    try:
        fit = least_squares(target, factor(columns, ("factor", "lag", "second lag", "offset")))
    except EstimationError:
        return rough, abs(rough - 1)
    scale = float(fit.theta[0])
    # What is left is no noise where the force is measured behind a gear: a factor that explains
    # no more than that is none.
    left = float(np.linalg.norm(fit.residuals) / np.linalg.norm(slow[used]))
    statistical = float(np.sqrt(Hac(2 * _SETTLE).matrix(fit)[0, 0]))
    return scale, max(statistical, left / _DEVIATIONS)


def _unmasked(record: Record) -> NDArray[np.bool_]:
    kept = np.ones(len(record), dtype=bool)
    for start, stop in record.masked:
        kept[start:stop] = False
    return kept
