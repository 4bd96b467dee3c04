"""The noise of the position as it returns in the control: what the declared law makes of it.

Without a reference the law cannot be replayed, but at high frequencies the axis hardly follows its
reference, and what the law reads there is the noise and the rounding of the position. Where these
dominate, the recorded control has them times the law's gain, whatever the reference is. Another
ratio shows that the position or the control is in another unit, or that the law is another one.
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
_ORDER = 4  # of the differences that leave the high frequencies
# Squared correlation of both from which the noise of the position dominates. Measured without it,
# steps of the reference give ratios from 0.9 to 20 on correct machines, from 0.95 to 1.01 with it.
_LEAST_COHERENCE = 0.9
_FEWEST_SAMPLES = 100
_LARGEST_RATIO = 1.25  # either way; units are apart by 6.28 and more, the gains of a law by less


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseGain(Finding):
    """The noise of the position as it returns in the control.

    Attributes
    ----------
    ratio : float
        Noise in the recorded control by that which the declared law makes of the position.
    agrees : bool
        Whether the ratio is within its limits.
    """

    ratio: float
    agrees: bool


def noise_gain_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """Compare the noise of the position in the control with what the law makes of it.

    None with a reference, by which the law itself is compared, and where the noise of the position
    does not dominate the control at high frequencies.
    """
    law, control = axis.control, record.control
    if law is None or control is None or record.reference is not None or record.integrated:
        return None
    if law.takes_velocity or law_clock(law, record).ratio != 1.0:
        return None
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
        source="measured: 0.95 to 1.01 on correct machines",
        finding=NoiseGain(ratio=found, agrees=within),
    )


def _ratio(control: Array, made: Array, counted: NDArray[np.bool_]) -> float | None:
    """The control's high frequencies over the law's; None where the position does not make them."""
    if not np.all(np.isfinite(made)):
        return None
    used = np.lib.stride_tricks.sliding_window_view(counted, _ORDER + 1).all(axis=1)
    high, of_law = np.diff(control, _ORDER)[used], np.diff(made, _ORDER)[used]
    power, law_power = float(high @ high), float(of_law @ of_law)
    if len(high) < _FEWEST_SAMPLES or not power > 0 or not law_power > 0:
        return None
    common = float(high @ of_law)
    return common / law_power if common**2 >= _LEAST_COHERENCE * power * law_power else None
