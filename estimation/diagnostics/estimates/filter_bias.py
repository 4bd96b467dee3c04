"""Whether the prefilter itself moves the estimate, as a check."""

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.thresholds.diagnostics import MAX_FILTER_BIAS, NEGLIGIBLE_FILTER_BIAS
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_LEAVE_OUT = Remedy.of("leave out the reversals (", Setting("reversals", "leave-out"), ")")
_RAISE = Remedy.of("raise the cut-off")


def filter_bias(estimate: Estimate, *, has_reversals: bool) -> Check | Missing:
    """The filter's own bias against the deviations.

    Parameters
    ----------
    estimate : Estimate
    has_reversals : bool
        Whether samples near reversals are in the fit that could do without them.
    """
    if estimate.filter_bias is None:
        return _untold(estimate)
    moved = {n: v for n, v in estimate.parameters.items() if v.shift > MAX_FILTER_BIAS.value}
    worst = max(v.shift for v in estimate.parameters.values())
    large = any(
        abs(v.filter_bias or 0.0) > NEGLIGIBLE_FILTER_BIAS.value * abs(v.value)
        for v in moved.values()
    )
    settled = _is_settled(estimate)
    listed = ", ".join(f"{n} by {v.filter_bias:+.2g} {v.unit}" for n, v in moved.items())
    return Check(
        name="filter bias",
        status=passed(not moved, matters=large and not settled),
        figure=worst if worst < float("inf") else None,
        threshold=MAX_FILTER_BIAS.value,
        source="what the same filter and estimator make of the noise-free loop that is simulated "
        "with the estimate, less the estimate, in deviations; no more than a note below 1 % of the "
        "value, or where the loop that is simulated with the corrected values has the same bias "
        "to a deviation",
        meaning="the prefilter moves no parameter by more than its deviation"
        if not moved
        else f"the prefilter itself moves {listed}; corrected values and 95 % intervals are free "
        f"of it{', as the loop at the corrected values confirms' * settled}; to make it smaller, ",
        remedy=(_LEAVE_OUT if has_reversals else _RAISE) if moved else None,
    )


def _is_settled(estimate: Estimate) -> bool:
    """Whether the bias at the corrected values is that at the estimate, to a deviation."""
    found = estimate.noise_free
    if found is None or found.again is None:
        return False
    deviations = np.array([v.deviation for v in estimate.parameters.values()])
    apart = np.abs(found.again - found.bias)
    return bool(np.all(apart <= MAX_FILTER_BIAS.value * deviations))


def _untold(estimate: Estimate) -> Missing:
    """Why there is no bias: there is no loop, or none that stands for the record."""
    if isinstance(estimate.simulated, NotSimulated):
        return estimate.simulated
    error = estimate.simulation_error_percent
    away = error is not None and error >= MAX_SIMULATION_ERROR.value
    why = "does not follow the record" if away else "could not be simulated"
    return Missing(f"the closed loop {why}")
