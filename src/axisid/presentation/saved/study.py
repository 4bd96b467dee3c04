"""A study that was written as JSON, read again: its figures, without the numbers of each run."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

from msgspec import UnsetType

from axisid.estimation.monte_carlo import (
    CheckFigures,
    Estimand,
    EstimandFigures,
    FailedRun,
    Mean,
    Share,
    StudyFigures,
    declared_chain,
)
from axisid.estimation.twins import Chain
from axisid.presentation.documents import number
from axisid.presentation.schema import (
    WrittenCheckFigures,
    WrittenEstimand,
    WrittenMean,
    WrittenMonteCarlo,
    WrittenShare,
)
from axisid.support.presentable import Presentable


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedMonteCarlo(StudyFigures, Presentable):
    """A study that was read from a file, with the names of `MonteCarlo`; see `load_result`.

    The numbers of each run are in the file of ``--output`` alone.

    Attributes
    ----------
    file : str
    document : WrittenMonteCarlo
        What the file holds.
    """

    file: str
    document: WrittenMonteCarlo

    def __repr__(self) -> str:
        methods = ", ".join(self.document.methods)
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {methods}"

    def __len__(self) -> int:
        return self.document.done

    @property
    def name(self) -> str:
        """Of the axis."""
        return self.document.axis

    @property
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of."""
        return str(self.document.settings["covariance"])

    @property
    def noise(self) -> Chain:
        """Of the twins."""
        twins = self.document.twins
        if not isinstance(twins.chain, UnsetType):
            return twins.chain
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return declared_chain(experiment, **cast(Any, twins.noise))

    @cached_property
    def figures(self) -> tuple[EstimandFigures, ...]:
        """What the runs tell of each estimand."""
        return tuple(map(_estimand, self.document.estimands))

    @cached_property
    def check_figures(self) -> tuple[CheckFigures, ...]:
        """How often each check ends how."""
        return tuple(map(_check, self.document.checks))

    @property
    def judged(self) -> int:
        """How many runs there is a verdict of."""
        return self.document.judged

    @property
    def objected(self) -> Share:
        """How many of the verdicts any check fails in."""
        return _share(self.document.objected)

    @property
    def failures(self) -> tuple[FailedRun, ...]:
        """Runs that gave nothing, of a method or at all, with the reason."""
        told = self.document.failures
        return tuple(FailedRun(run=e.run, of=e.of, reason=e.reason) for e in told)


def _estimand(written: WrittenEstimand) -> EstimandFigures:
    return EstimandFigures(
        estimand=Estimand(written.method, written.name, written.unit, written.kind),
        truth=number(written.truth),
        runs=written.runs,
        bias=_mean(written.bias),
        raw_bias=_mean(written.raw_bias),
        scatter=_mean(written.scatter),
        deviations=dict(written.deviations),
        coverage={of: _share(share) for of, share in written.coverage.items()},
    )


def _check(written: WrittenCheckFigures) -> CheckFigures:
    return CheckFigures(
        name=written.name,
        fails=_share(written.fails),
        notes=_share(written.notes),
        passes=_share(written.passes),
        missing=_share(written.not_evaluated),
    )


def _mean(written: WrittenMean) -> Mean:
    return Mean(number(written.value), number(written.error))


def _share(written: WrittenShare) -> Share:
    return Share(written.count, written.of)
