"""Which of several estimates is judged: the one to believe."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial

from axisid.estimation.checks import DEFAULT_LEVELS, Levels, unless_faulty
from axisid.estimation.diagnostics.estimates import prefers_instruments
from axisid.estimation.diagnostics.law import LawCheck, check_law
from axisid.estimation.estimates import Estimate, HausmanTest, hausman
from axisid.estimation.problems import Problem
from axisid.estimation.regression import DirectForm
from axisid.support.missing import Missing


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """Which estimate of a result is judged, and what was measured to tell, each thing once.

    Attributes
    ----------
    problem : Problem
        What the estimates were made from.
    estimates : mapping of str to Estimate
        By method.
    levels : Levels
        From when on a check tells something.
    """

    problem: Problem
    estimates: Mapping[str, Estimate]
    levels: Levels = DEFAULT_LEVELS

    @cached_property
    def method(self) -> str:
        """The method that is judged: output error or instruments, else least squares.

        Output error where every record's control is the declared law's, on which it rests, but
        where instruments differ from it and are the more precise; where the control is not the
        law's, or that cannot be told, instruments. The inverse model before the direct one.
        """
        first, by_law = self._best(by_law=False), self._best(by_law=True)
        if by_law == first or not self.laws_hold:
            return first
        apart = self.less("idm-iv", "didim")
        if isinstance(apart, Missing):
            return by_law
        iv, didim = self.estimates[first], self.estimates[by_law]
        return first if prefers_instruments(apart, iv, didim, self.levels) else by_law

    @cached_property
    def laws(self) -> tuple[LawCheck | Missing, ...]:
        """The control law against each record, or why it cannot be checked."""
        return tuple(
            unless_faulty(partial(check_law, data.axis, data.record)) for data in self.problem.data
        )

    @property
    def laws_hold(self) -> bool:
        """Whether every record's control is the declared law's."""
        return all(isinstance(law, LawCheck) and law.passed for law in self.laws)

    def less(self, one: str, other: str) -> Mapping[str, HausmanTest] | Missing:
        """Estimate by one method less that by another, by parameter, or why that is not known."""
        if not {one, other} <= {*self.estimates}:
            return Missing(f"{one} and {other} did not both give an estimate")
        return unless_faulty(partial(hausman, self.estimates[one], self.estimates[other]))

    def _best(self, *, by_law: bool) -> str:
        def preference(method: str) -> tuple[bool, bool, bool]:
            estimate = self.estimates[method]
            other = estimate.by_output_error != by_law
            return estimate.loop_rows is None, other, isinstance(estimate.form, DirectForm)

        return min(self.estimates, key=preference)
