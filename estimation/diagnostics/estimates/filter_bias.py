"""Whether the prefilter itself moves the estimate, as a check."""

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.problems import NoiseFree
from axisid.estimation.thresholds.diagnostics import MAX_FILTER_BIAS, NEGLIGIBLE_FILTER_BIAS
from axisid.estimation.thresholds.estimates import (
    MAX_SIMULATION_ERROR,
    MIN_PRINTED_FILTER_BIAS,
)
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_LEAVE_OUT = Remedy.of("leave out the reversals (", Setting("reversals", "leave-out"), ")")
_RAISE = Remedy.of("raise the cut-off")
_REFERENCE = Remedy.of("record the reference, from which instruments are made")
_QUIETER = Remedy.of("give the loop a position with less noise, which shakes what friction holds")
#: What moves the parameters: the filter alone, or with the noise of a record without a reference.
_CAUSES = {
    False: "the prefilter itself moves",
    True: "the prefilter and the noise of the position move",
}
_NOTHING = {
    False: "the prefilter moves no",
    True: "neither the prefilter nor the noise of the position moves a",
}


def filter_bias(estimate: Estimate, *, has_reversals: bool) -> Check | Missing:
    """The filter's own bias against the deviations.

    Parameters
    ----------
    estimate : Estimate
    has_reversals : bool
        Whether samples near reversals are in the fit that could do without them.
    """
    if estimate.noise_free is not None and estimate.noise_free.doubt:
        return _doubted(estimate, estimate.noise_free, has_reversals=has_reversals)
    if estimate.filter_bias is None:
        return _untold(estimate)
    moved = {n: v for n, v in estimate.parameters.items() if v.shift > MAX_FILTER_BIAS.value}
    worst = max(v.shift for v in estimate.parameters.values())
    large = any(
        abs(v.filter_bias or 0.0) > NEGLIGIBLE_FILTER_BIAS.value * abs(v.value)
        for v in moved.values()
    )
    settled = estimate.noise_free is not None and estimate.noise_free.settled
    noisy = estimate.noise_free is not None and estimate.noise_free.has_noise
    listed = ", ".join(f"{n} by {v.filter_bias:+.2g} {v.unit}" for n, v in moved.items())
    return Check(
        name="filter bias",
        status=passed(not moved, matters=large and not settled),
        figure=worst if worst < float("inf") else None,
        threshold=MAX_FILTER_BIAS.value,
        source="what the same filter and estimator make of the noise-free loop that is simulated "
        "with the estimate, less the estimate, in deviations; no more than a note below 1 % of the "
        "value, or where it was found again at the corrected values and stands still",
        meaning=f"{_NOTHING[noisy]} parameter by more than its deviation"
        if not moved
        else f"{_CAUSES[noisy]} {listed}; corrected values and 95 % intervals are free "
        f"of it{', as the loop at the corrected values confirms' * settled}; to make it smaller, ",
        remedy=_of_noise(estimate)
        if moved and noisy
        else _advice(has_reversals=has_reversals)
        if moved
        else None,
    )


def _doubted(estimate: Estimate, quiet: NoiseFree, *, has_reversals: bool) -> Check:
    """A bias of the noise-free loop that the record does not have."""
    values = estimate.parameters
    shifts = {
        name: abs(bias) / value.deviation if value.deviation > 0 else float("inf")
        for (name, value), bias in zip(values.items(), quiet.bias, strict=True)
    }
    worst = max(shifts.values())
    moved = {
        name: bias
        for name, bias in zip(values, quiet.bias, strict=True)
        if shifts[name] > MIN_PRINTED_FILTER_BIAS.value or shifts[name] == worst
    }
    large = any(
        abs(bias) > NEGLIGIBLE_FILTER_BIAS.value * abs(values[name].value)
        for name, bias in moved.items()
    )
    listed = ", ".join(f"{n} by {bias:+.2g} {values[n].unit}" for n, bias in moved.items())
    return Check(
        name="filter bias",
        status=passed(good=False, matters=large),
        figure=None if worst == float("inf") else worst,
        threshold=MIN_PRINTED_FILTER_BIAS.value,
        source="what the same filter and estimator make of the noise-free loop, in deviations; "
        "corrected where it settles, unless the record's residuals have less than half of that "
        "error (HAC, 5 %); no more than a note below 1 % of the value",
        meaning=f"{_CAUSES[quiet.has_noise]} {listed} on the simulated loop, but {quiet.doubt}: "
        "nothing is corrected, and intervals may miss by as much; ",
        remedy=_advice(has_reversals=has_reversals),
    )


def _advice(*, has_reversals: bool) -> Remedy:
    return _LEAVE_OUT if has_reversals else _RAISE


def _of_noise(estimate: Estimate) -> Remedy:
    """What makes less of noise: that in the regressor, in the loop, or where the axis turns."""
    if estimate.Z is not None:
        return _LEAVE_OUT
    return _QUIETER if estimate.by_output_error else _REFERENCE


def _untold(estimate: Estimate) -> Missing:
    """Why there is no bias: there is no loop, or none that stands for the record."""
    if isinstance(estimate.simulated, NotSimulated):
        return estimate.simulated
    error = estimate.simulation_error_percent
    away = error is not None and error >= MAX_SIMULATION_ERROR.value
    why = "does not follow the record" if away else "could not be simulated"
    return Missing(f"the closed loop {why}")
