"""Figures of many runs, each with its Monte-Carlo error, and what they tell.

Whoever has them: a study that was made, or its file.
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
from axisid.support.errors import Missing, UsageError, quoted

from .plan import interval_covariance
from .runs import Estimand, FailedRun

_MOST_REASONS = 5  # that are told of what came to nothing
_ROUNDING = 1e-12  # of the truth: a mean error up to it is one of arithmetic


class Share(Struct, frozen=True, rename={"interval": "interval_95"}):
    """How often something happened.

    Attributes
    ----------
    count, of : int
        How often, of how many times that it could.
    interval : (float, float)
        Follows from these.
    """

    count: int
    of: int
    interval: Annotated[
        tuple[float, float], Meta(description="Wilson's, of the probability; 0 to 1 of no time.")
    ] = (0.0, 1.0)

    def __post_init__(self) -> None:
        force_setattr(self, "interval", self.interval_at(INTERVAL_LEVEL.value))

    @classmethod
    def of_truths(cls, truths: NDArray[np.bool_]) -> "Share":
        """How often it is true."""
        return cls(int(np.count_nonzero(truths)), len(truths))

    @property
    def value(self) -> float:
        """The share; not a number of no time."""
        return self.count / self.of if self.of else math.nan

    def interval_at(self, level: float) -> tuple[float, float]:
        """Wilson's interval of a level; 0 to 1 of no time."""
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
    error : float
        Its standard error over the runs; not a number of too few.
    """

    value: MaybeNan
    error: MaybeNan

    @classmethod
    def of_values(cls, values: Array) -> "Mean":
        """The mean of independent values, (n,)."""
        n = len(values)
        error = float(values.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
        return cls(float(values.mean()) if n else math.nan, error)

    @classmethod
    def of_scatter(cls, values: Array) -> "Mean":
        """Their standard deviation; its error allows for tails that are not the normal one's.

        By the variance of a sample's variance, ``(m4 - m2^2 (n - 3)/(n - 1))/n``, and the delta
        method.
        """
        if (n := len(values)) < 2:
            return cls(math.nan, math.nan)
        away = values - values.mean()
        variance, fourth = float(away @ away) / (n - 1), float((away**4).mean())
        deviation = math.sqrt(variance)
        if n < 4 or not deviation:
            return cls(deviation, math.nan)
        spread = max(fourth - variance**2 * (n - 3) / (n - 1), 0.0) / n
        return cls(deviation, math.sqrt(spread) / (2 * deviation))


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimandFigures(Estimand):
    """What the runs tell of one estimand.

    Attributes
    ----------
    method : str
    name : str
    kind : {"parameter", "direct", "physical"}
        As it is identified, of the direct model, or declared and following from others.
    unit : str
    truth : float
        Not a number, or null, where the twins have no such parameter.
    runs : int
        That gave an estimate.
    bias : Mean
        Mean error of the value without the bias of filter and noise.
    raw_bias : Mean
        Mean error of the value itself.
    scatter : Mean
        Standard deviation over the runs.
    deviations : mapping of str to float
        Root mean square of the stated one, by covariance; ``model`` of the model's error.
    coverage : mapping of str to Share
        How often the 95 % interval of each holds the truth; empty without a truth, and of declared
        parameters that follow where a known value has a deviation: all runs share its error.
    """

    truth: MaybeNan
    runs: int
    bias: Mean
    raw_bias: Mean
    scatter: Mean
    deviations: Mapping[str, float]
    coverage: Mapping[str, Share]


class CheckFigures(Struct, frozen=True, kw_only=True, rename={"missing": "not_evaluated"}):
    """How often a check ends in each way, of the runs that were judged.

    Attributes
    ----------
    name : str
    fails, notes, passes : Share
        Of the runs in which it was evaluated: what nobody looked at has not passed.
    missing : Share
        It could not be evaluated, or the run has no such check.
    """

    name: str
    fails: Share
    notes: Share
    passes: Share
    missing: Annotated[Share, Meta(description="Of all that were judged.")]


class StudyFigures(Checked):
    """What follows from the figures of a study."""

    __slots__ = ()

    @property
    @abstractmethod
    def figures(self) -> tuple[EstimandFigures, ...]:
        """What the runs tell of each estimand."""

    @property
    @abstractmethod
    def failures(self) -> tuple[FailedRun, ...]:
        """Runs that gave nothing, of a method or at all, with the reason."""

    @property
    @abstractmethod
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of."""

    @abstractmethod
    def __len__(self) -> int:
        """How many runs were done."""

    @property
    def checks(self) -> tuple[Check, ...]:
        """Whether intervals hold the truth as often as they say, values are biased, runs fail."""
        narrow, wide = (_listed(self.miscovered(narrow=narrow)) for narrow in (True, False))
        shares = [each.coverage for each in self.figures if each.coverage]
        runs, biased, lost = f"{len(self)} runs tell", _listed(self.biased), "; ".join(self._lost())
        untold = Missing("No truth is known")
        return (
            Check.unless(
                "coverage",
                narrow and f"Intervals that hold the truth too rarely: {narrow}",
                f"No interval holds the truth more rarely than it says, as far as {runs}",
            )
            if shares
            else Check.not_evaluated("coverage", untold),
            Check.unless(
                "width",
                wide and f"Intervals that are wider than they need be: {wide}",
                f"No interval is wider than it need be, as far as {runs}",
                matters=False,
            )
            if shares
            else Check.not_evaluated("width", untold),
            Check.unless(
                "bias",
                biased
                and f"Bias beyond chance ({MIN_BIAS.value:g} standard errors of many twins, more "
                f"of few): {biased}",
                f"No bias is beyond chance, as far as {runs}",
            )
            if shares
            else Check.not_evaluated("bias", untold),
            Check.unless("runs", lost, "Every run gave every estimate"),
        )

    def _lost(self) -> Iterator[str]:
        """What came to nothing, with the reasons that occur most."""
        for of, reasons in self.lost.items():
            count = sum(reasons.values())
            listed = list(reasons.items())[:_MOST_REASONS]
            why = "; ".join(f"{n} times: {reason.removesuffix('.')}" for reason, n in listed)
            yield f"{of} came to nothing in {count} of {len(self)} runs: {why}"

    @property
    def biased(self) -> tuple[EstimandFigures, ...]:
        """Where the mean error is beyond its own standard error, and beyond rounding."""
        found = []
        for each in self.figures:
            # Of few runs the standard error is uncertain too: the distance is Student's.
            furthest = stdtrit(each.runs - 1, ndtr(MIN_BIAS.value)) * each.bias.error
            if each.runs > 1 and abs(each.bias.value) > max(furthest, _ROUNDING * abs(each.truth)):
                found.append(each)
        return tuple(found)

    def miscovered(self, *, narrow: bool) -> tuple[EstimandFigures, ...]:
        """Whose intervals hold the truth too rarely, or else are wider than they need be.

        Both beyond the Monte-Carlo error, under what their method states, with 5 % for a mistake in
        any of the estimands (Bonferroni).
        """
        wanted = INTERVAL_LEVEL.value
        stated = [(interval_covariance(each.method, self.chosen), each) for each in self.figures]
        covered = [(each, each.coverage[of]) for of, each in stated if of in each.coverage]
        level = 1 - (1 - wanted) / max(len(covered), 1)
        bounds = [share.interval_at(level) for _, share in covered]
        return tuple(
            each
            for (each, _), (low, high) in zip(covered, bounds, strict=True)
            if (high < wanted if narrow else low > wanted)
        )

    def of(self, method: str, name: str) -> EstimandFigures:
        """The figures of a parameter by a method.

        Raises
        ------
        UsageError
            There is none.
        """
        for found in self.figures:
            if (found.method, found.name) == (method, name):
                return found
        listed = ", ".join(f"{e.method} {e.name}" for e in self.figures)
        raise UsageError(
            f"there is no {quoted(name)} by {quoted(method)}; there are {listed or 'none'}.",
            code="result",
        )

    @property
    def lost(self) -> Mapping[str, Mapping[str, int]]:
        """How many runs gave nothing, by method or what else failed, then by reason."""
        found: dict[str, Counter[str]] = {}
        for failed in self.failures:
            found.setdefault(failed.of, Counter())[failed.reason] += 1
        return {of: dict(counted.most_common()) for of, counted in found.items()}

    def __iter__(self) -> Iterator[EstimandFigures]:
        return iter(self.figures)


def _listed(figures: Iterable[EstimandFigures]) -> str:
    return ", ".join(f"{each.method} {each.name}" for each in figures)
