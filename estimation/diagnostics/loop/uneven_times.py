"""What jitter of a record's time stamps does to the estimate, as a check."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, solver_of
from axisid.estimation.problems import EvenTimes, Problem, at_even_times, jitter_of
from axisid.estimation.records import Record
from axisid.estimation.thresholds.diagnostics import (
    MAX_FILTER_BIAS,
    MIN_JITTER,
    NEGLIGIBLE_BIAS,
)
from axisid.estimation.thresholds.estimates import MIN_PRINTED_FILTER_BIAS
from axisid.support.errors import DataError, EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .control_law import LawCheck

NAME = "uneven times"
_EVENLY = Remedy.of("resample the log (", Setting("resample", "auto"), ")")


def uneven_check(
    problem: Problem, estimate: Estimate, laws: Sequence[LawCheck | Missing] = ()
) -> Check | Missing | None:
    """The estimate at even times beside the one as sampled; None where times are even.

    Parameters
    ----------
    problem : Problem
    estimate : Estimate
        That is judged.
    laws : sequence of LawCheck or Missing
        Of the records, which the jitter may keep from fitting the samples.
    """
    jitter = max(_jitter(data.record) for data in problem.data)
    if not jitter > MIN_JITTER.value:
        return None
    try:
        found = at_even_times(problem, estimate.form, solver_of(estimate))
    except (DataError, EstimationError) as error:
        return Missing.of(error.note)
    shares, shifts = _moved(found, estimate)
    worst = max(shifts.values())
    real = found.equation_error_percent < found.own_error_percent
    moved = worst > MAX_FILTER_BIAS.value
    large = any(
        shifts[name] > MAX_FILTER_BIAS.value and abs(share) > NEGLIGIBLE_BIAS.value
        for name, share in shares.items()
    )
    times = f"the samples are {100 * jitter:.2g} % of a period (rms) off even times"
    checked = [law for law in laws if isinstance(law, LawCheck)]
    of_law = max((law.as_recorded_percent or 0.0 for law in checked), default=0.0)
    status = passed(not (moved and real), matters=large)
    return Check(
        name=NAME,
        status="note" if of_law and status == "pass" else status,
        figure=worst if np.isfinite(worst) else None,
        threshold=MAX_FILTER_BIAS.value,
        source="largest change of a parameter where the record is interpolated to even times by "
        "its own stamps, in deviations; no more than a note below 1 % of the value, and none where "
        "the equation error is no smaller at even times",
        meaning=f"{times}: at even times by interpolation {_listed(shares, shifts)}, and the "
        f"equation error is {found.equation_error_percent:.4g} in place of "
        f"{found.own_error_percent:.4g} %{_whose(real=real)}{_consequence(of_law)}"
        f"{': ' if real and moved else ''}",
        remedy=_EVENLY if real and moved else None,
    )


def _jitter(record: Record) -> float:
    """Of a record, root mean square, in periods."""
    return float(np.sqrt(np.mean(jitter_of(record) ** 2))) / record.period


def _moved(found: EvenTimes, estimate: Estimate) -> tuple[dict[str, float], dict[str, float]]:
    """By what share and how many deviations each parameter is another at even times."""
    shares, shifts = {}, {}
    apart = found.physical - estimate.physical
    for (name, value), change in zip(estimate.parameters.items(), apart, strict=True):
        shares[name] = float(change / value.value) if value.value else np.inf
        shifts[name] = abs(float(change)) / value.deviation if value.deviation > 0 else np.inf
    return shares, shifts


def _listed(shares: Mapping[str, float], shifts: Mapping[str, float]) -> str:
    told: Sequence[str] = [
        f"{name} is {100 * shares[name]:+.2g} % ({shift:.2g} deviations) away"
        for name, shift in shifts.items()
        if shift > MIN_PRINTED_FILTER_BIAS.value
    ]
    return ", ".join(told) or "no parameter is noticeably another"


def _consequence(of_law: float) -> str:
    """What the control law has of it, which is right but for this."""
    if not of_law:
        return ""
    return f"; for that the control law is {of_law:.2g} % off in the samples as they are"


def _whose(*, real: bool) -> str:
    if real:
        return ", so that the stamps are when it was sampled"
    return ", so that rather the stamps are uneven than the sampling"
