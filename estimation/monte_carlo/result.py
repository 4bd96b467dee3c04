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
        return (
            f"Monte-Carlo study of {self.plan.axis.name}: {len(self)} twins by "
            f"{', '.join(self.plan.methods)}"
        )

    def __len__(self) -> int:
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
        return self._stated(of)[:, :, 0]

    def intervals(self, of: str) -> Array:
        """Return the bounds of the 95 % intervals, (R, e, 2), of a kind of `INTERVALS`."""
        return self._stated(of)[:, :, 1:]

    def _stated(self, of: str) -> Array:
        """Return standard errors and bounds, (R, e, 3), of a kind of `INTERVALS`."""
        check_among(("interval", of, INTERVALS))
        place = 2 + 3 * INTERVALS.index(of)
        return self.numbers.numbers[:, :, place : place + 3]

    @cached_property
    def truths(self) -> Array:
        """True values of the estimands, (e,); not a number if the twin lacks the parameter."""
        known = twin_plan(self.plan.twin).true_values
        direct = {method: self._direct_truths(method, known) for method in self.plan.methods}
        truths = [
            (direct[each.method] if each.kind == DIRECT else known).get(each.name, np.nan)
            for each in self.estimands
        ]
        return np.array(truths, dtype=float)

    def _direct_truths(self, method: str, known: Mapping[str, float]) -> dict[str, float]:
        """Return the true parameters of a method's direct model by name; empty if not known.

        `known` has the true values of the physical parameters by name.
        """
        axis = self.plan.axis
        shown = any((each.method, each.kind) == (method, DIRECT) for each in self.estimands)
        if not shown or any(name not in known for name in axis.names):
            return {}
        form = METHODS[method].form(axis)
        true = form.regressed(np.array([known[name] for name in axis.names]))
        return dict(zip((q.name for q in form.quantities), true.tolist(), strict=True))

    @cached_property
    def outcomes(self) -> dict[int, tuple[str, str]]:
        """Outcome of each finished run, ``ok``, ``partly`` or ``failed``, with the reasons."""
        failures: dict[int, list[FailedRun]] = {run: [] for run in self.numbers.runs.tolist()}
        for failed in self.failures:
            failures[failed.run].append(failed)
        found = {}
        for run, of_run in failures.items():
            lost = {each.of for each in of_run}
            whole = SIMULATION in lost or lost >= {*self.plan.methods}
            status = "failed" if whole else "partly" if lost else "ok"
            found[run] = status, "; ".join(f"{each.of}: {each.reason}" for each in of_run)
        return found

    @cached_property
    def figures(self) -> tuple[EstimandFigures, ...]:
        """Figures of each estimand over the runs."""
        return tuple(self._figures(place) for place in range(len(self.estimands)))

    def _figures(self, place: int) -> EstimandFigures:
        """Return the figures over the runs of one estimand, given by its index."""
        estimand, truth = self.estimands[place], float(self.truths[place])
        there = np.isfinite(self.corrected[:, place])
        value, corrected = (each[there, place] for each in (self.values, self.corrected))
        # All runs share the error of a known value, which the intervals include.
        follows = estimand.kind == PHYSICAL or fitted_output(estimand.method)
        is_shared = follows and any(p.known_sd for p in self.plan.axis.base.known)
        deviations, coverage = {}, {}
        for of in INTERVALS:
            stated = self.deviations(of)[there, place]
            known = np.isfinite(stated)
            if not known.any():
                continue
            deviations[of] = float(np.sqrt(np.mean(stated[known] ** 2)))
            low, high = self.intervals(of)[there, place][known].T
            if np.isfinite(truth) and not is_shared:
                coverage[of] = Share.of_truths((low <= truth) & (truth <= high))
        return EstimandFigures(
            **asdict(estimand),
            truth=truth,
            runs=int(there.sum()),
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
        """Return the errors of an estimand in standard errors of its method, (r,).

        They are of the r runs that have both. The standard error is that of a normal distribution
        with the same 95 % interval, for any degrees of freedom.

        Parameters
        ----------
        place : int
            Index among the estimands.
        """
        low, high = self.intervals(interval_covariance(self.estimands[place].method, self.chosen))[
            :, place
        ].T
        stated = (high - low) / 2 / float(ndtri((1 + INTERVAL_LEVEL.value) / 2))
        errors = self.corrected[:, place] - self.truths[place]
        there = np.isfinite(errors) & (stated > 0)
        return np.asarray(errors[there] / stated[there])
