"""The declared control law against what the drive did.

The recorded control is regressed on the law's own terms, computed from the recorded reference and
position. Every factor must be 1. What they are instead tells the fault: millimetres for metres, a
flipped sign, another gain, another clock, a delay.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen import GeneratedAxis

from .arrays import Array, relative_error_percent
from .errors import EstimationError
from .linear import factor, least_squares
from .prefilter import Prefilter
from .record import Record
from .virtual_loop import run_law

#: Percent of the recorded control that a law may leave unexplained.
GOOD_RESIDUAL = 5.0
_SMOOTH = 0.05  # of the sampling frequency
_GOOD_FACTOR = 0.05  # distance from 1
_MOST_SHIFT = 5  # samples
_CLEARLY_BETTER = 0.5  # of the residual without a shift
_SETTLE = 10  # samples in which the law's memory fills


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCheck:
    """The recorded control against the declared law.

    Attributes
    ----------
    factors : dict of str to float
        By product of gains; each is 1 if the law is the drive's.
    residual_percent : float
        ``100 ||control - law|| / ||control||``, with the law as declared.
    fitted_residual_percent : float
        The same with the factors: what no gain explains.
    delay : int
        Samples by which the recorded control follows the declared law best.
    passed : bool
        Whether instruments simulated with this law can be believed.
    meaning : str
        One sentence for the user.
    """

    factors: dict[str, float]
    residual_percent: float
    fitted_residual_percent: float
    delay: int
    passed: bool
    meaning: str


def check_law(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> LawCheck | str:
    """Check an axis's control law against a record; or say why it cannot be checked."""
    law = axis.axis.control
    if law is None:
        return "the axis declares no control law"
    if record.reference is None or record.control is None:
        return "the record has no reference or no control"
    # An ideal velocity is not recorded; a smooth one stands in for it.
    smooth = replace(prefilter, cutoff=min(prefilter.cutoff, _SMOOTH / record.period))
    velocity = smooth.motion(record.position, record.period)[1]
    terms = run_law(axis, record.reference, record.position, velocity)
    used = np.abs(record.control) < axis.axis.drive.limit
    used[:_SETTLE] = False
    if used.sum() < 10 * terms.shape[1]:
        return "the control is at the drive's limit nearly all the time"
    names = [str(f) for f, _ in law.terms]
    shift = _best_shift(terms.sum(axis=1), record.control, used)
    try:
        fit = least_squares(record.control[used], factor(terms[used], names))
    except EstimationError as error:
        return f"its terms cannot be told apart in this record: {error}"
    declared = relative_error_percent(
        (record.control - terms.sum(axis=1))[used], record.control[used]
    )
    factors = dict(zip(names, map(float, fit.theta), strict=True))
    passed = declared < GOOD_RESIDUAL and shift == 0
    return LawCheck(
        factors=factors,
        residual_percent=declared,
        fitted_residual_percent=relative_error_percent(fit.residuals, record.control[used]),
        delay=shift,
        passed=passed,
        meaning=_meaning(factors, declared, shift, law.delay, passed=passed),
    )


def _best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Shift that explains the control clearly better than none, else 0."""
    rows = np.flatnonzero(used)
    rows = rows[(rows >= _MOST_SHIFT) & (rows < len(control) - _MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-_MOST_SHIFT, _MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _CLEARLY_BETTER * errors[0] else 0


def _meaning(
    factors: dict[str, float], residual: float, shift: int, delay: int, *, passed: bool
) -> str:
    if passed:
        return f"the declared law reproduces the recorded control to {residual:.2g} % of its norm"
    listed = ", ".join(f"{name} x {value:.4g}" for name, value in factors.items())
    start = f"the recorded control is not the declared law's ({residual:.3g} % off; {listed}): "
    values = np.array(list(factors.values()))
    common = float(np.median(values))
    if shift:
        return (
            f"{start}it follows by {shift} samples more; declare delay={delay + shift}, or check "
            "the clock"
        )
    if not np.all(np.abs(values / common - 1) < _GOOD_FACTOR):
        return f"{start}check the gains, the velocity filter and the period"
    if abs(common + 1) < _GOOD_FACTOR:
        return f"{start}its sign is flipped; check the sign of the control or of the positions"
    for scale, what in ((1e3, "metres for millimetres"), (1e-3, "millimetres for metres")):
        if abs(common / scale - 1) < _GOOD_FACTOR:
            return f"{start}one unit stands for another, such as {what}"
    return f"{start}every gain is off by one factor; check the control's unit and scaling"
