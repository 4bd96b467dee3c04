"""What jitter of a record's time stamps does to the estimate, as a check."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.diagnostics.law import LawCheck
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

NAME = "uneven times"
_EVENLY = Remedy.of("resample the log (", Setting("resample", "auto"), ")")


@dataclass(frozen=True, slots=True)
class _Effect:
    """An estimate beside that of the same records at even times."""

    estimate: Estimate
    found: EvenTimes
    shares: Mapping[str, float]
    shifts: Mapping[str, float]

    @classmethod
    def of(cls, problem: Problem, estimate: Estimate) -> "_Effect":
        found = at_even_times(problem, estimate.form, solver_of(estimate))
        return cls(estimate, found, *_moved(found, estimate))

    @property
    def is_real(self) -> bool:
        """Whether the equations are better at even times, so that the samples are off them."""
        return self.found.equation_error_percent < self.found.own_error_percent

    @property
    def is_moved(self) -> bool:
        return self.is_real and max(self.shifts.values()) > MAX_FILTER_BIAS.value

    @property
    def is_large(self) -> bool:
        """Whether a parameter is moved by what matters."""
        return self.is_real and any(
            self.shifts[name] > MAX_FILTER_BIAS.value and abs(share) > NEGLIGIBLE_BIAS.value
            for name, share in self.shares.items()
        )


def uneven_check(
    problem: Problem,
    estimate: Estimate,
    least_squares: Estimate | None = None,
    laws: Sequence[LawCheck | Missing] = (),
) -> Check | Missing | None:
    """Estimates at even times beside those as sampled; None where times are even.

    Parameters
    ----------
    problem : Problem
    estimate : Estimate
        That is judged.
    least_squares : Estimate, optional
        Beside it, which instruments that do not mind jitter are held against.
    laws : sequence of LawCheck or Missing
        Of the records, which the jitter may keep from fitting the samples.
    """
    jitter = max(_jitter(data.record) for data in problem.data)
    if not jitter > MIN_JITTER.value:
        return None
    others = () if least_squares in (None, estimate) else (least_squares,)
    try:
        judged, *beside = (_Effect.of(problem, e) for e in (estimate, *others) if e is not None)
    except (DataError, EstimationError) as error:
        return Missing.of(error.note)
    moved = [each for each in (judged, *beside) if each.is_moved]
    of_law = _off_for_jitter(laws)
    figure = max(max(each.shifts.values()) for each in (judged, *moved))
    status = passed(not moved, matters=any(each.is_large for each in moved))
    return Check(
        name=NAME,
        status="note" if of_law and status == "pass" else status,
        figure=figure if np.isfinite(figure) else None,
        threshold=MAX_FILTER_BIAS.value,
        source="largest change of a parameter where the record is interpolated to even times by "
        "its own stamps, in deviations; no more than a note below 1 % of the value, and none where "
        "the equation error is no smaller at even times",
        meaning=f"the samples are {100 * jitter:.2g} % of a period (rms) off even times: at even "
        f"times by interpolation {_listed(judged)}, and the equation error is "
        f"{judged.found.equation_error_percent:.4g} in place of "
        f"{judged.found.own_error_percent:.4g} %{_whose(real=judged.is_real)}"
        f"{_consequences(moved, judged, of_law)}{': ' if moved else ''}",
        remedy=_EVENLY if moved else None,
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


def _listed(effect: _Effect) -> str:
    told: Sequence[str] = [
        f"{name} is {100 * effect.shares[name]:+.2g} % ({shift:.2g} deviations) away"
        for name, shift in effect.shifts.items()
        if shift > MIN_PRINTED_FILTER_BIAS.value
    ]
    return ", ".join(told) or "no parameter is noticeably another"


def _off_for_jitter(laws: Sequence[LawCheck | Missing]) -> float:
    """How far laws are off the samples as they are that fit but for the jitter, percent."""
    checked = (law for law in laws if isinstance(law, LawCheck))
    return max((law.as_recorded_percent or 0.0 for law in checked), default=0.0)


def _consequences(moved: Sequence[_Effect], judged: _Effect, of_law: float) -> str:
    """What else comes of it: least squares that is moved, and a law that only so is off."""
    said = [f"by {each.estimate.method} {_listed(each)}" for each in moved if each is not judged]
    if of_law:
        said.append(f"for that the control law is {of_law:.2g} % off in the samples as they are")
    return "".join(f"; {each}" for each in said)


def _whose(*, real: bool) -> str:
    if real:
        return ", so that the stamps are when it was sampled"
    return ", so that rather the stamps are uneven than the sampling"
