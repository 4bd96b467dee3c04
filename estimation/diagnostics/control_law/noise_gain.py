"""Noise of the position in the recorded control, compared with the output of the declared law.

Without a reference the law cannot be replayed. But at high frequencies the axis hardly follows its
reference, and the law reads mainly the noise and the rounding of the position. Where noise and
rounding dominate, the recorded control contains them, multiplied by the gain of the law, whatever
the reference is. If the ratio of this noise in the recorded control to that in the output of the
declared law is not 1, the position or the control is in another unit, or the drive has another law.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.findings import Finding
from axisid.estimation.records import Record, law_clock
from axisid.estimation.verdict_checks import Check
from axisid.support.arrays import Array

from .control_residuals import compared_with_law

NOISE_GAIN = "noise gain"
_ORDER = 4  # of the differences that act as a high-pass filter
# Squared correlation from which the noise of the position dominates. Measured ratios of correct
# machines with steps in the reference: 0.9 to 20 without this condition, 0.95 to 1.01 with it.
_LEAST_COHERENCE = 0.9
_FEWEST_SAMPLES = 100
# largest ratio of a correct law, and the inverse of the smallest; another unit changes the ratio by
# 6.28 and more, another gain by less
_LARGEST_RATIO = 1.25


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseGain(Finding):
    """Noise of the position in the recorded control, relative to that of the declared law.

    Attributes
    ----------
    ratio : float
        Noise in the recorded control relative to the noise that the declared law makes of the
        position.
    agrees : bool
        Whether the ratio is within its limits.
    """

    ratio: float
    agrees: bool


def noise_gain_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """Return the check of the noise in the recorded control against that in the output of the law.

    None for a record with a reference, because the law itself is then compared, and for a record
    without a control or a recorded position. None also for a law that reads an ideal velocity or
    does not run at the samples, and where the noise of the position does not dominate the control
    at high frequencies.
    """
    law, control = axis.control, record.control
    if law is None or control is None or record.reference is not None or record.integrated:
        return None
    if law.takes_velocity or law_clock(law, record).ratio != 1.0:
        return None
    # The output of the law for a constant reference.
    piece = record.longest()
    held = piece.with_values(reference=np.full(len(piece), piece.position[0]))
    recorded, made, counted, _ = compared_with_law(axis, law, held)
    found = _ratio(recorded, made, counted)
    if found is None:
        return None
    within = 1 / _LARGEST_RATIO <= found <= _LARGEST_RATIO
    return Check(
        name=NOISE_GAIN,
        status="pass" if within else "fail",
        figure=found,
        threshold=_LARGEST_RATIO,
        source="ratio of the noise in the recorded control to the noise in the output of the "
        "declared law, both from the noise of the position. The check fails above the threshold "
        "and below its inverse. Measured ratios of correct machines are 0.95 to 1.01",
        finding=NoiseGain(ratio=found, agrees=within),
    )


def _ratio(control: Array, made: Array, counted: NDArray[np.bool_]) -> float | None:
    """Return the ratio of the recorded control to that of the law at high frequencies.

    It is the factor of a regression of their differences of fourth order. None where these are not
    strongly correlated, or too few samples count.

    Parameters
    ----------
    control, made : (N,) array
        Recorded control, and control of the law.
    counted : (N,) array of bool
        True for the samples that count.
    """
    if not np.all(np.isfinite(made)):
        return None
    used = np.lib.stride_tricks.sliding_window_view(counted, _ORDER + 1).all(axis=1)
    high, of_law = np.diff(control, _ORDER)[used], np.diff(made, _ORDER)[used]
    power, law_power = float(high @ high), float(of_law @ of_law)
    if len(high) < _FEWEST_SAMPLES or not power > 0 or not law_power > 0:
        return None
    common = float(high @ of_law)
    if common**2 >= _LEAST_COHERENCE * power * law_power:
        return common / law_power
    return None
