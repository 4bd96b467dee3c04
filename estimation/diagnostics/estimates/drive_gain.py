"""The drive gain that several records tell, against the declared one, as a check."""

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.parameters import GAIN
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.modeling.declaration import Drive

# between identified and declared drive gain; beyond, a known value is of another record
_MAX_GAIN_RATIO = 2.0

NAME = "drive gain"


def gain_check(estimate: Estimate, drive: Drive) -> Check | None:
    """Whether the identified gain is the declared one; None where none is identified.

    The parameters are of the identified gain whatever comes of it.
    """
    if GAIN not in estimate.parameters:
        return None
    value = estimate.parameters[GAIN]
    deviation = float(np.hypot(value.deviation, drive.relative_sd * drive.gain))
    distance = abs(value.corrected - drive.gain) / deviation if deviation > 0 else np.inf
    same = distance <= MIN_DISTANCE_FROM_NOISE.value
    ratio = value.corrected / drive.gain
    near = 1 / _MAX_GAIN_RATIO < ratio < _MAX_GAIN_RATIO
    said = f"the drive gain is {value.corrected:.5g} +- {value.deviation:.2g} {value.unit}"
    if not near:
        said += (
            f", and {drive.gain:g} is declared: check that the known values are in the order of "
            "the records, and their units"
        )
    return Check(
        name=NAME,
        status=passed(same, matters=not near),
        figure=distance if np.isfinite(distance) else None,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="distance of the identified gain from the declared one, in deviations of both; a "
        "note, and a failure where one is twice the other or more, or of the other sign",
        meaning="the identified gain is the declared one"
        if same
        else said
        if not near
        else f"{said}, {100 * (ratio - 1):+.2g} % from the declared {drive.gain:g}: the parameters "
        "are of the identified one; declare it for what is identified without a known force",
    )
