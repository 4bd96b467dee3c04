"""Whether the prefilter itself moves the estimate, as a check."""

from axisid.estimation.estimates import FOLLOWING, Estimate

from .check import Check, passed

_MOST = 1.0  # deviations
_LARGE = 0.01  # of the value
_ADVICE = {
    None: "leave out the reversals (--reversals leave-out)",
    "leave-out": "raise the cut-off",
}


def filter_bias(estimate: Estimate, reversals: str | None = None) -> Check:
    """The filter's own bias against the deviations; the advice depends on the reversals."""
    if estimate.filter_bias is None:
        error = estimate.simulation_error_percent
        simulated = error is not None and error >= FOLLOWING
        why = "does not follow the record" if simulated else "could not be simulated"
        return Check.missing("filter bias", f"the closed loop {why}")
    moved = {
        n: v for n, v in estimate.parameters.items() if shift(v.filter_bias, v.deviation) > _MOST
    }
    worst = max(shift(v.filter_bias, v.deviation) for v in estimate.parameters.values())
    large = any(abs(v.filter_bias or 0.0) > _LARGE * abs(v.value) for v in moved.values())
    listed = ", ".join(f"{n} by {v.filter_bias:+.2g} {v.unit}" for n, v in moved.items())
    return Check(
        name="filter bias",
        status=passed(not moved, matters=large),
        figure=worst if worst < float("inf") else None,
        threshold=_MOST,
        source="what the same filter and estimator make of the noise-free loop that is simulated "
        "with the estimate, less the estimate, in deviations; no more than a note below 1 % of the "
        "value",
        meaning="the prefilter moves no parameter by more than its deviation"
        if not moved
        else f"the prefilter itself moves {listed}; corrected values and 95 % intervals are free "
        f"of it; to make it smaller, {_ADVICE.get(reversals, _ADVICE[None])}",
    )


def shift(bias: float | None, deviation: float) -> float:
    """In deviations; infinite for a bias without one."""
    if not bias:
        return 0.0
    return abs(bias) / deviation if deviation > 0 else float("inf")
