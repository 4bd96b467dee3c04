"""Figures of a study, each with its Monte-Carlo error, and checks of them.

They apply to a study and to a study that was read from a file.
"""

import math
from abc import abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from msgspec.structs import force_setattr
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

from axisid.estimation.thresholds import INTERVAL_LEVEL, MIN_BIAS
from axisid.estimation.verdict_checks import Check, Checked
from axisid.support.arrays import Array, MaybeNan
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.wording import quoted

from .plan import interval_covariance
from .runs import Estimand, FailedRun

_MOST_REASONS = 5  # reasons that are reported for failures
_ROUNDING = 1e-12  # of the true value; a mean error up to it is rounding


class Share(Struct, frozen=True, rename={"interval": "interval_95"}):
    """Frequency of an event.

    Attributes
    ----------
    count, of : int
        Number of events, and number of trials.
    interval : (float, float)
        95 % interval of the probability, by Wilson; 0 to 1 without trials.
    """

    count: int
    of: int
    interval: Annotated[
        tuple[float, float],
        Meta(description="Wilson interval of the probability; 0 to 1 without trials."),
    ] = (0.0, 1.0)

    def __post_init__(self) -> None:
        """Set the interval from the counts."""
        force_setattr(self, "interval", self.interval_at(INTERVAL_LEVEL.value))

    @classmethod
    def of_truths(cls, truths: NDArray[np.bool_]) -> "Share":
        """Return the share of True among truth values, (n,)."""
        return cls(int(np.count_nonzero(truths)), len(truths))

    @property
    def value(self) -> float:
        """Relative frequency; not a number without trials."""
        return self.count / self.of if self.of else math.nan

    def interval_at(self, level: float) -> tuple[float, float]:
        """Return Wilson's interval of the probability at a confidence level.

        It is 0 to 1 without trials.
        """
        from scipy.stats import binomtest

        if not self.of:
            return 0.0, 1.0
        found = binomtest(self.count, self.of).proportion_ci(level, "wilson")
        return float(found.low), float(found.high)


@dataclass(frozen=True, slots=True)
class Mean:
    """A figure with its standard error over the runs.

    Attributes
    ----------
    value : float
        The figure: a mean, or a standard deviation.
    error : float
        Standard error over the runs; not a number for too few runs.
    """

    value: MaybeNan
    error: MaybeNan

    @classmethod
    def of_values(cls, values: Array) -> "Mean":
        """Return the mean of independent values, (n,), with its standard error ``s/sqrt(n)``."""
        n = len(values)
        error = float(values.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
        return cls(float(values.mean()) if n else math.nan, error)

    @classmethod
    def of_scatter(cls, values: Array) -> "Mean":
        """Return the standard deviation of values, (n,), with its standard error.

        The error is valid for any distribution: the variance of the sample variance is
        ``(m4 - s^4 (n - 3)/(n - 1))/n`` with the fourth central moment m4, and the delta method
        divides its root by ``2 s``.
        """
        n = len(values)
        if n < 2:
            return cls(math.nan, math.nan)
        centred = values - values.mean()
        variance, fourth = float(centred @ centred) / (n - 1), float((centred**4).mean())
        deviation = math.sqrt(variance)
        if n < 4 or not deviation:
            return cls(deviation, math.nan)
        variance_of_variance = max(fourth - variance**2 * (n - 3) / (n - 1), 0.0) / n
        return cls(deviation, math.sqrt(variance_of_variance) / (2 * deviation))


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimandFigures(Estimand):
    """Figures of one estimand over the runs.

    Attributes
    ----------
    method : str
    name : str
    kind : {"parameter", "direct", "physical"}
        An identified parameter; a parameter of the direct model; a declared parameter that follows
        from other parameters.
    unit : str
    truth : float
        True value; not a number, or null, if the twins lack the parameter.
    runs : int
        Number of runs with an estimate.
    bias : Mean
        Mean error of the corrected value, which is the value minus its estimated bias by filter and
        noise.
    raw_bias : Mean
        Mean error of the value, which is not corrected for its estimated bias.
    scatter : Mean
        Standard deviation of the corrected value over the runs.
    deviations : mapping of str to float
        Root mean square of the standard error, by kind of interval: a covariance, or ``model`` for
        the model error.
    coverage : mapping of str to Share
        Share of the 95 % intervals that cover the true value, by kind of interval. Empty without a
        true value, and for parameters that follow from an uncertain known value, because all runs
        have the same error of that value.
    """

    truth: MaybeNan
    runs: int
    bias: Mean
    raw_bias: Mean
    scatter: Mean
    deviations: Mapping[str, float]
    coverage: Mapping[str, Share]


class CheckFigures(Struct, frozen=True, kw_only=True, rename={"missing": "not_evaluated"}):
    """Frequency of each status of a check over the runs with a verdict.

    Attributes
    ----------
    name : str
    fails, notes, passes : Share
        Share of the runs in which the check was evaluated.
    missing : Share
        Share of the runs without the check, or in which it could not be evaluated.
    """

    name: str
    fails: Share
    notes: Share
    passes: Share
    missing: Annotated[Share, Meta(description="Share of all runs with a verdict.")]


class StudyFigures(Checked):
    """Base class of a study and of a saved study: checks of their figures."""

    __slots__ = ()

    @property
    @abstractmethod
    def figures(self) -> tuple[EstimandFigures, ...]:
        """Figures of each estimand over the runs."""

    @property
    @abstractmethod
    def failures(self) -> tuple[FailedRun, ...]:
        """Failures of runs, of one method or of all, with the reason."""

    @property
    @abstractmethod
    def chosen(self) -> str:
        """Covariance of the printed intervals, one of `COVARIANCES`."""

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of finished runs."""

    @property
    def checks(self) -> tuple[Check, ...]:
        """Checks of the coverage and width of intervals, of bias, and of failed runs.

        Coverage, width and bias are not evaluated without true values.
        """
        failed = "; ".join(self._sentences_on_failures())
        of_runs = Check.unless("runs", failed, "Every run gave every estimate")
        if not any(each.coverage for each in self.figures):
            unknown = Missing("No true value is known")
            names = ("coverage", "width", "bias")
            return (*(Check.not_evaluated(name, unknown) for name in names), of_runs)
        runs = f"in {len(self)} runs"
        # Sentences of failed checks; empty for a check that passes.
        narrow = _listed(self.miscovered(narrow=True))
        if narrow:
            narrow = f"These intervals cover the true value too rarely: {narrow}"
        wide = _listed(self.miscovered(narrow=False))
        if wide:
            wide = f"These intervals are wider than necessary: {wide}"
        biased = _listed(self.biased)
        if biased:
            biased = (
                f"These estimates have a significant bias: {biased}. The limit is "
                f"{MIN_BIAS.value:g} standard errors of the mean for many twins, and more for few"
            )
        return (
            Check.unless(
                "coverage",
                narrow,
                f"No interval has a coverage significantly below 95 % {runs}",
            ),
            Check.unless(
                "width",
                wide,
                f"No interval has a coverage significantly above 95 % {runs}",
                matters=False,
            ),
            Check.unless("bias", biased, f"No bias is significant {runs}"),
            of_runs,
        )

    def _sentences_on_failures(self) -> Iterator[str]:
        """Yield a sentence on the failures of each method, with the most frequent reasons."""
        for of, reasons in self.lost.items():
            count = sum(reasons.values())
            most_frequent = list(reasons.items())[:_MOST_REASONS]
            why = "; ".join(
                f"{number} times: {reason.removesuffix('.')}" for reason, number in most_frequent
            )
            yield f"{of} failed in {count} of {len(self)} runs: {why}"

    @property
    def biased(self) -> tuple[EstimandFigures, ...]:
        """Figures with a significant bias, larger than rounding."""
        found = []
        for each in self.figures:
            # For few runs the standard error is uncertain, hence a quantile of Student's t.
            limit = stdtrit(each.runs - 1, ndtr(MIN_BIAS.value)) * each.bias.error
            if each.runs > 1 and abs(each.bias.value) > max(limit, _ROUNDING * abs(each.truth)):
                found.append(each)
        return tuple(found)

    def miscovered(self, *, narrow: bool) -> tuple[EstimandFigures, ...]:
        """Return the figures whose intervals cover the true value too rarely, or too often.

        The intervals are those of the printed covariance. The difference from 95 % is significant
        beyond the Monte-Carlo error; the probability of a wrong result in any of the estimands is
        5 % (Bonferroni).

        Parameters
        ----------
        narrow : bool
            True for too narrow intervals, False for too wide ones.
        """
        wanted = INTERVAL_LEVEL.value
        # Coverage of the printed intervals, for the estimands that have it.
        covered: list[tuple[EstimandFigures, Share]] = []
        for each in self.figures:
            kind = interval_covariance(each.method, self.chosen)
            if kind in each.coverage:
                covered.append((each, each.coverage[kind]))
        # Its interval, at a level for all estimands together.
        level = 1 - (1 - wanted) / max(len(covered), 1)
        found = []
        for each, share in covered:
            low, high = share.interval_at(level)
            if (narrow and high < wanted) or (not narrow and low > wanted):
                found.append(each)
        return tuple(found)

    def of(self, method: str, name: str) -> EstimandFigures:
        """Return the figures of a parameter by a method.

        Raises
        ------
        UsageError
            The study has no such estimand.
        """
        for found in self.figures:
            if (found.method, found.name) == (method, name):
                return found
        raise UsageError(
            f"the study has no estimates of {quoted(name)} by {quoted(method)}. Choose from "
            f"{_listed(self.figures) or 'none'}.",
            code="result",
        )

    @property
    def lost(self) -> Mapping[str, Mapping[str, int]]:
        """Number of failed runs, by method or kind of failure, then by reason."""
        found: dict[str, Counter[str]] = {}
        for failed in self.failures:
            found.setdefault(failed.of, Counter())[failed.reason] += 1
        return {of: dict(counted.most_common()) for of, counted in found.items()}

    def __iter__(self) -> Iterator[EstimandFigures]:
        """Iterate over the figures of the estimands."""
        return iter(self.figures)


def _listed(figures: Iterable[EstimandFigures]) -> str:
    """Return methods and names of estimands as a list."""
    return ", ".join(f"{each.method} {each.name}" for each in figures)
