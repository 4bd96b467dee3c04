"""Which of several estimates is judged: the one to believe."""

from collections.abc import Mapping
from functools import partial

from axisid.estimation.diagnostics.estimates import prefers_instruments
from axisid.estimation.diagnostics.law import LawCheck, check_law
from axisid.estimation.estimates import Estimate
from axisid.estimation.noise import second_opinion
from axisid.estimation.problems import Problem
from axisid.estimation.regression import DirectForm


def preferred_method(problem: Problem, estimates: Mapping[str, Estimate]) -> str:
    """The method that is judged: output error or instruments, else least squares; inverse first.

    Output error where every record's control is the declared law's, on which it rests, but where
    instruments differ from it and are the more precise; where the control is not the law's, or that
    cannot be told, instruments.
    """

    def preference(method: str, *, by_law: bool = False) -> tuple[bool, bool, bool]:
        estimate = estimates[method]
        measured = estimate.loop_rows is None
        return measured, estimate.by_output_error != by_law, isinstance(estimate.form, DirectForm)

    first = min(estimates, key=preference)
    by_law = min(estimates, key=partial(preference, by_law=True))
    if by_law == first or not _laws_hold(problem):
        return first
    iv, didim = estimates[first], estimates[by_law]
    apart = second_opinion(iv, didim) if iv.Z is not None else {}
    return first if prefers_instruments(apart, iv, didim) else by_law


def _laws_hold(problem: Problem) -> bool:
    laws = (check_law(data.axis, data.record) for data in problem.data)
    return all(isinstance(law, LawCheck) and law.passed for law in laws)
