"""A force column beside a control: the two must belong together, and the control within limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import Neighbours, Prefilter
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError

from .check import Check, passed

_NAME = "force against control"
_MOST = 20.0  # percent
_EXACT = 0.01  # distance of the factor from 1
_DEVIATIONS = 3.0
_SMOOTH = 0.02  # of the sampling frequency
_SLOW = 30.0  # Hz, far below the bandwidth of any current loop
_MOST_LAG = 5e-3  # s
_OFTEN = 4  # rows in a period of the highest frequency that is left
_FEWEST = 10  # times the samples in which the low-pass settles
_LIMIT = "control against limit"
_BEYOND = 0.02  # of the limit, which a converter's noise does not reach
_RARE = 1e-3  # of the samples, which spikes may be


@dataclass(frozen=True, slots=True, kw_only=True)
class _Compared:
    """A force against a commanded one: percent apart, factor with deviation, and lag in s."""

    apart: float
    scale: float
    deviation: float
    lag: float


def force_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """The recorded force against the drive's gain times the control; nothing without both."""
    if record.force is None or record.control is None:
        return None
    found = _compared(record.longest(), axis.axis.drive.gain)
    vague = float(np.hypot(found.deviation, axis.axis.drive.relative_sd))
    scaled = abs(found.scale - 1) > max(_EXACT, _DEVIATIONS * vague)
    near, late = bool(found.apart <= _MOST), abs(found.lag) > _MOST_LAG
    good = near and not scaled and not late
    return Check(
        name=_NAME,
        status=passed(good),
        figure=found.apart if np.isfinite(found.apart) else None,
        threshold=_MOST,
        source="difference in percent of gain times control, in what is slow against a current "
        "loop; fails too for a lag beyond 5 ms, and where the factor between the two is off 1 by "
        "more than 1 % and three deviations, that of the gain among them",
        meaning="the force column is what the drive's gain makes of the control"
        if good
        else _scaled(axis, found)
        if near and scaled
        else f"the force column is {found.scale:.3g} times what the drive's gain makes of the "
        f"control, {1e3 * found.lag:.2g} ms later and {found.apart:.3g} % off it: check the "
        "column, its unit and timing, and the gain",
    )


def limit_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """The recorded control against the drive's limit; nothing without either."""
    drive = axis.axis.drive
    if record.control is None or not np.isfinite(drive.limit):
        return None
    size = np.abs(record.control)[_unmasked(record)]
    if not size.size:
        return None
    beyond = size > (1 + _BEYOND) * drive.limit
    share = float(np.mean(beyond))
    good, used = share <= _RARE, record.force is None
    most = float(size.max())
    return Check(
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


def _scaled(axis: GeneratedAxis, found: _Compared) -> str:
    unit = f"{axis.axis.coordinate.force_unit}/{axis.axis.drive.unit}"
    gain = axis.axis.drive.gain
    return (
        f"the force column is {found.scale:.4g} +- {max(found.deviation, 1e-4):.1g} times what the "
        "drive's gain makes of the control, and otherwise the same: every parameter is scaled by "
        f"it. Check the force column's scale and the gain, which would be {found.scale * gain:.4g} "
        f"{unit} for {gain:g}, or declare how well the gain is known (relative_sd)"
    )


def _compared(record: Record, gain: float) -> _Compared:
    """Both low-passed alike, so that what a current loop and its sensor do is no factor.

    The first two derivatives of the command stand for the loop's lag.
    """
    force, commanded = np.asarray(record.force), gain * np.asarray(record.control)
    cutoff = min(_SMOOTH / record.period, _SLOW)
    settle = round(1 / (cutoff * record.period))
    used = minimum_filter1d(_unmasked(record), 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < _FEWEST * settle:
        return _at_once(force, commanded)
    smooth = Prefilter(cutoff=cutoff)
    rows = np.flatnonzero(used)[:: max(settle // _OFTEN, 1)]  # what is slow needs no more
    slow, faster, fastest = (each[rows] for each in smooth.motion(commanded, record.period))
    target = smooth.motion(force, record.period)[0][rows]
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
    statistical = float(np.sqrt(Hac(2 * _OFTEN).matrix(fit)[0, 0]))
    return _Compared(
        apart=relative_error_percent(target - slow, slow),
        scale=scale,
        deviation=max(statistical, left / _DEVIATIONS),
        lag=-behind / scale if scale else 0.0,
    )


def _at_once(force: Array, commanded: Array) -> _Compared:
    """As they are; of a few samples no factor can be told."""
    scale = float(commanded @ force / (commanded @ commanded))
    apart = relative_error_percent(force - commanded, commanded)
    return _Compared(apart=apart, scale=scale, deviation=abs(scale - 1), lag=0.0)


def _unmasked(record: Record) -> NDArray[np.bool_]:
    kept = np.ones(len(record), dtype=bool)
    for start, stop in record.masked:
        kept[start:stop] = False
    return kept
