"""Whether the prefilter itself moves the estimate, as a check."""

from .check import Check, passed
from .estimate import FOLLOWING, Estimate

_MOST = 1.0  # deviations
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
    listed = ", ".join(f"{n} by {v.filter_bias:+.2g} {v.unit}" for n, v in moved.items())
    return Check(
        name="filter bias",
        status=passed(not moved),
        figure=worst if worst < float("inf") else None,
        threshold=_MOST,
        source="what the same filter and estimator make of the noise-free loop that is simulated "
        "with the estimate, less the estimate, in deviations",
        meaning="the prefilter moves no parameter by more than its deviation"
        if not moved
        else f"the prefilter itself moves {listed}; the values have it, the 95 % intervals are "
        f"less it: {_ADVICE.get(reversals, _ADVICE[None])}, or subtract it (filter_bias)",
    )


def shift(bias: float | None, deviation: float) -> float:
    """In deviations; infinite for a bias without one."""
    if not bias:
        return 0.0
    return abs(bias) / deviation if deviation > 0 else float("inf")
