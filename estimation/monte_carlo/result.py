"""Result of a study: bias, scatter and intervals of methods over many twins, and checks."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from axisid.estimation.choices import fitted_output
from axisid.estimation.methods import METHODS
from axisid.estimation.simulation import twin_plan
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.support.arrays import Array, Exact, Uncached
from axisid.support.checks import check_among
from axisid.support.presentable import Presentable

from .plan import MonteCarloPlan, interval_covariance
from .runs import (
    DIRECT,
    INTERVALS,
    PHYSICAL,
    SIMULATION,
    STATUSES,
    BlockNumbers,
    Estimand,
    FailedRun,
)
from .study_statistics import CheckFigures, EstimandFigures, Mean, Share, StudyFigures


@dataclass(frozen=True, kw_only=True, eq=False)
class MonteCarlo(StudyFigures, Uncached, Presentable, Exact):
    """Numbers of all runs of a study.

    Attributes
    ----------
    plan : MonteCarloPlan
    numbers : BlockNumbers
        Numbers of the finished runs, in order.
    """

    plan: MonteCarloPlan
    numbers: BlockNumbers

    def __repr__(self) -> str:
        """Return the name of the axis, the number of twins and the methods."""
        return (
            f"Monte-Carlo study of {self.plan.axis.name}: {len(self)} twins by "
            f"{', '.join(self.plan.methods)}"
        )

    def __len__(self) -> int:
        """Return the number of finished runs."""
        return len(self.numbers.runs)

    @property
    def estimands(self) -> tuple[Estimand, ...]:
        """Estimated quantities, length e."""
        return self.numbers.estimands

    @property
    def chosen(self) -> str:
        """Covariance of the printed intervals, one of `COVARIANCES`."""
        return str(self.plan.settings["covariance"])

    @property
    def failures(self) -> tuple[FailedRun, ...]:
        """Failures of runs, of one method or of all, with the reason."""
        return self.numbers.failures

    @property
    def values(self) -> Array:
        """Estimates without bias correction by run and estimand, (R, e); NaN if missing."""
        return self.numbers.numbers[:, :, 0]

    @property
    def corrected(self) -> Array:
        """Estimates minus the bias of filter and noise, if it is known, (R, e); NaN if missing."""
        return self.numbers.numbers[:, :, 1]

    def deviations(self, of: str) -> Array:
        """Return the standard errors by run and estimand, (R, e), of a kind of `INTERVALS`."""
        return self._with_intervals(of)[:, :, 0]

    def intervals(self, of: str) -> Array:
        """Return the bounds of the 95 % intervals, (R, e, 2), of a kind of `INTERVALS`."""
        return self._with_intervals(of)[:, :, 1:]

    def _with_intervals(self, of: str) -> Array:
        """Return standard errors and both bounds, (R, e, 3), of a kind of `INTERVALS`."""
        check_among(("interval", of, INTERVALS))
        first = 2 + 3 * INTERVALS.index(of)
        return self.numbers.numbers[:, :, first : first + 3]

    @cached_property
    def truths(self) -> Array:
        """True values of the estimands, (e,); not a number if the twin lacks the parameter."""
        known = twin_plan(self.plan.twin).true_values
        direct = {method: self._direct_truths(method, known) for method in self.plan.methods}
        truths = []
        for estimand in self.estimands:
            by_name = direct[estimand.method] if estimand.kind == DIRECT else known
            truths.append(by_name.get(estimand.name, np.nan))
        return np.array(truths, dtype=float)

    def _direct_truths(self, method: str, known: Mapping[str, float]) -> dict[str, float]:
        """Return the true parameters of a method's direct model by name.

        Empty for other methods, and if a true value is not known. `known` has the true values of
        the physical parameters by name.
        """
        axis = self.plan.axis
        is_direct = any((each.method, each.kind) == (method, DIRECT) for each in self.estimands)
        if not is_direct or any(name not in known for name in axis.names):
            return {}
        form = METHODS[method].form(axis)
        true = form.regressed(np.array([known[name] for name in axis.names]))
        return dict(zip((q.name for q in form.quantities), true.tolist(), strict=True))

    @cached_property
    def outcomes(self) -> dict[int, tuple[str, str]]:
        """Outcome of each finished run, with the reasons of its failures as text, by run.

        The outcome is ``ok`` without a failure, ``failed`` if the simulation or all methods failed,
        and ``partly`` otherwise.
        """
        failures: dict[int, list[FailedRun]] = {run: [] for run in self.numbers.runs.tolist()}
        for failed in self.failures:
            failures[failed.run].append(failed)
        found = {}
        for run, of_run in failures.items():
            failed_parts = {each.of for each in of_run}
            status = "ok"
            if SIMULATION in failed_parts or failed_parts >= {*self.plan.methods}:
                status = "failed"
            elif failed_parts:
                status = "partly"
            found[run] = status, "; ".join(f"{each.of}: {each.reason}" for each in of_run)
        return found

    @cached_property
    def figures(self) -> tuple[EstimandFigures, ...]:
        """Figures of each estimand over the runs."""
        return tuple(self._figures(index) for index in range(len(self.estimands)))

    def _figures(self, index: int) -> EstimandFigures:
        """Return the figures over the runs of one estimand, given by its index."""
        estimand, truth = self.estimands[index], float(self.truths[index])
        has_estimate = np.isfinite(self.corrected[:, index])
        value, corrected = (each[has_estimate, index] for each in (self.values, self.corrected))
        # The intervals include the error of an uncertain known value. All runs have the same error,
        # so that the share of intervals that cover the true value has no meaning.
        uses_known = estimand.kind == PHYSICAL or fitted_output(estimand.method)
        is_shared = uses_known and any(p.known_sd for p in self.plan.axis.base.known)
        # Standard error and coverage by each kind of interval that some run has.
        deviations, coverage = {}, {}
        for kind in INTERVALS:
            standard_errors = self.deviations(kind)[has_estimate, index]
            has_interval = np.isfinite(standard_errors)
            if not has_interval.any():
                continue
            deviations[kind] = float(np.sqrt(np.mean(standard_errors[has_interval] ** 2)))
            low, high = self.intervals(kind)[has_estimate, index][has_interval].T
            if np.isfinite(truth) and not is_shared:
                coverage[kind] = Share.of_truths((low <= truth) & (truth <= high))
        return EstimandFigures(
            **asdict(estimand),
            truth=truth,
            runs=int(has_estimate.sum()),
            bias=Mean.of_values(corrected - truth),
            raw_bias=Mean.of_values(value - truth),
            scatter=Mean.of_scatter(corrected),
            deviations=deviations,
            coverage=coverage,
        )

    @property
    def judged(self) -> int:
        """Number of runs with a verdict."""
        return int(self.numbers.judged.sum())

    @cached_property
    def check_figures(self) -> tuple[CheckFigures, ...]:
        """Frequency of each status of each check, in the order of the verdict."""
        found, judged = [], self.numbers.statuses[self.numbers.judged]
        for name, statuses in zip(self.numbers.checks, judged.T, strict=True):
            evaluated = statuses[(statuses >= 0) & (statuses != STATUSES.index("not evaluated"))]
            # The first three of `STATUSES`.
            passes, notes, fails = (Share.of_truths(evaluated == each) for each in range(3))
            missing = Share(len(statuses) - len(evaluated), len(statuses))
            found.append(
                CheckFigures(name=name, fails=fails, notes=notes, passes=passes, missing=missing)
            )
        return tuple(found)

    @cached_property
    def objected(self) -> Share:
        """Share of the verdicts with a failed check."""
        failing = self.numbers.statuses[self.numbers.judged] == STATUSES.index("fail")
        return Share.of_truths(np.asarray(failing.any(axis=1)))

    def normalised(self, place: int) -> Array:
        """Return the errors of an estimand in standard errors, (r,).

        There are r runs with both an estimate and a positive standard error. The standard error is
        that of a normal distribution with the same 95 % interval, for any degrees of freedom.

        Parameters
        ----------
        place : int
            Index among the estimands.
        """
        kind = interval_covariance(self.estimands[place].method, self.chosen)
        low, high = self.intervals(kind)[:, place].T
        standard_errors = (high - low) / 2 / float(ndtri((1 + INTERVAL_LEVEL.value) / 2))
        errors = self.corrected[:, place] - self.truths[place]
        has_both = np.isfinite(errors) & (standard_errors > 0)
        return np.asarray(errors[has_both] / standard_errors[has_both])
