"""How much of what an estimate leaves is the model's: what is left again where motion repeats."""

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.moves import LackOfFit
from axisid.estimation.thresholds import MIN_MODEL_SHARE

# HAC deviations by those of noise alone; from there on they are too wide for it
_MIN_HAC_EXCESS = 1.5


def lack_of_fit_check(found: LackOfFit, preferred: Estimate) -> Check:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    unit = left_unit(preferred)
    noise = f"{found.noise:.2g} {unit} is noise"
    return Check(
        name="lack of fit",
        status=passed(not found.is_mostly_model, matters=False),
        figure=100 * found.share,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="percent of the residuals' power that is left again where the reference repeats, "
        "from the products of residuals of different repeats; it counts where noise "
        "repeats as much but for a chance of 1e-3 (HAC over the phases), and where it goes on from "
        "row to row",
        meaning=f"{100 * found.share:.0f} % of what the model leaves is the model: "
        f"{found.repeated:.2g} {unit} ({100 * found.repeated / found.left:.2g} % of the "
        f"{preferred.form.left}) {_again(found)}, {noise}{_too_wide(found)}"
        if found.is_mostly_model
        else f"{found.repeated:.2g} {unit} of what the model leaves {_again(found)} but jumps from "
        f"row to row, as the steps of an encoder do, {noise}"
        if found.is_there and not found.is_smooth
        else f"most of what the model leaves is noise: {found.repeated:.2g} {unit} "
        f"{_again(found)}, {noise}"
        if found.is_there
        else f"what the model leaves is noise: nothing of it {_again(found)}, {noise}",
    )


def left_unit(estimate: Estimate) -> str:
    """Unit of the regression's left side."""
    coordinate = estimate.form.axis.axis.coordinate
    unit = coordinate.acceleration_unit if estimate.is_direct else coordinate.force_unit
    return str(unit)


def _again(found: LackOfFit) -> str:
    """When what is left is left again."""
    if found.period is None:
        return "repeats wherever a move does"
    return f"repeats every {found.period:.4g} s"


def _too_wide(found: LackOfFit) -> str:
    """What HAC deviations are in those of the noise; nothing where they are about the same."""
    ratios = sorted(found.hac_excess.values())
    if ratios[0] < _MIN_HAC_EXCESS or ratios[-1] == np.inf:  # without noise there is no ratio
        return ""
    low, high = f"{ratios[0]:.2g}", f"{ratios[-1]:.2g}"
    times = low if low == high else f"{low} to {high}"
    return (
        f"; HAC deviations are {times} times those of that noise, and say nothing of how far the "
        "model's error moves the parameters"
    )
