"""What was fixed, against what the record alone says."""

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Physical, Value, physical_parameters
from axisid.estimation.thresholds import LEVEL
from axisid.modeling.declaration import known_text
from axisid.support.missing import Missing


def fixed_check(estimate: Estimate, level: float = LEVEL.value) -> Check | Missing | None:
    """Whether the record contradicts what was fixed; nothing if nothing could be asked."""
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.base.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine what was fixed, so that it cannot contradict it"
        return Missing(physical.undetermined[-1] if physical.undetermined else why)
    good = physical.p_value >= level
    return Check(
        name="fixed values" if physical.base.known else "physical parameters",
        status=passed(good),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"chi-squared with {physical.dof} degrees of freedom, covariance of the "
        "estimate and declared deviations, less the bias of filter and noise; fails below "
        f"{100 * level:g} %",
        meaning="the record agrees with them" if good else _contradiction(physical, estimate),
    )


def _contradiction(physical: Physical, estimate: Estimate) -> str:
    """What was fixed beside what the record alone says of it, where it says anything."""
    alone = estimate.parameters
    sides = [
        f"{p.name} is fixed at {known_text(p)} {p.unit}"
        + (
            f", the record alone gives {alone[p.name].corrected:.4g} +- {_deviation(alone[p.name])}"
            if p.name in alone
            else ""
        )
        for p in physical.base.known
    ]
    what = f": {'; '.join(sides)}" if sides else ""
    return (
        f"no values of the parameters agree with the record{' and what was fixed' * bool(sides)} "
        f"(chi-squared {physical.statistic:.3g}, degrees of freedom {physical.dof}){what}. "
        f"Check what was fixed, the drive gain and the terms of the model{_unknown_bias(estimate)}"
    )


def _deviation(value: Value) -> str:
    return f"{np.hypot(value.deviation, value.sd_gain):.2g}"


def _unknown_bias(estimate: Estimate) -> str:
    if estimate.filter_bias is not None:
        return ""
    return "; its bias, which could do it too, is not known without a control law"
