"""Studies of twins as documents, written and read again."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, cast

from msgspec import UNSET, UnsetType

from axisid.estimation.checks import Levels
from axisid.estimation.monte_carlo import (
    CheckFigures,
    EstimandFigures,
    FailedRun,
    MonteCarlo,
    Share,
    StudyFigures,
    declared_chain,
    declared_figures,
)
from axisid.estimation.twins import Chain
from axisid.support.presentable import Presentable

from .record import WrittenRequest
from .values import JsonObject, WrittenResult, about, read_as, written_as


class WrittenTwins(JsonObject, frozen=True, kw_only=True):
    """What was simulated."""

    axis: str
    signature: str
    right: Annotated[bool, about("Whether what was identified is what was simulated.")]
    noise: Annotated[
        Mapping[str, float | bool | None],
        about(
            "By the names of the options; of several autoregressions the deviation of their sum. "
            "In files without a chain null is the experiment's, or none."
        ),
    ]
    chain: Annotated[
        Chain | UnsetType, about("The same whole, SI; left out in files of earlier versions.")
    ] = UNSET
    position_noise: Annotated[float, about("The experiment's, in the coordinate's unit.")]
    resolution: Annotated[float, about("Likewise; 0 for none.")]
    unit: Annotated[str, about("Of the coordinate.")]
    drive_unit: str


class WrittenMonteCarlo(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.monte_carlo/1"
):
    """What `axisid study --json` writes."""

    axis: str
    signature: str
    twins: WrittenTwins
    runs: Annotated[int, about("Asked for.")]
    done: Annotated[int, about("Fewer where the study was ended early.")]
    seed: int
    methods: tuple[str, ...]
    prefilter: Annotated[WrittenRequest, about("As the twins' rate has it.")]
    settings: Annotated[Mapping[str, str | int | None], about("What else was asked of identify.")]
    levels: Annotated[Levels | UnsetType, about("Left out in files of earlier versions.")] = UNSET
    estimands: tuple[EstimandFigures, ...]
    judged: Annotated[int, about("Runs with a verdict.")]
    objected: Annotated[Share, about("Verdicts in which any check fails.")]
    checks: tuple[CheckFigures, ...]
    failures: tuple[FailedRun, ...]


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedMonteCarlo(StudyFigures, Presentable):
    """A study that was read from a file, with the names of `MonteCarlo`; see `load_result`.

    The numbers of each run are in the file of ``--output`` alone.

    Attributes
    ----------
    document : WrittenMonteCarlo
        What the file holds.
    name : str
        Of the axis.
    check_figures : tuple of CheckFigures
        How often each check ends how.
    judged : int
        How many runs there is a verdict of.
    objected : Share
        How many of the verdicts any check fails in.
    """

    document: WrittenMonteCarlo
    name: str
    check_figures: tuple[CheckFigures, ...]
    judged: int
    objected: Share

    @classmethod
    def of_document(cls, written: WrittenMonteCarlo) -> "SavedMonteCarlo":
        """What a document tells."""
        return read_as(
            cls,
            written,
            document=written,
            name=written.axis,
            check_figures=written.checks,
        )

    def __repr__(self) -> str:
        methods = ", ".join(self.document.methods)
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {methods}"

    def __len__(self) -> int:
        return self.document.done

    @property
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of."""
        return str(self.document.settings["covariance"])

    @property
    def figures(self) -> tuple[EstimandFigures, ...]:
        """What the runs tell of each estimand."""
        return self.document.estimands

    @property
    def failures(self) -> tuple[FailedRun, ...]:
        """Runs that gave nothing, of a method or at all, with the reason."""
        return self.document.failures

    @property
    def noise(self) -> Chain:
        """Of the twins."""
        twins = self.document.twins
        if not isinstance(twins.chain, UnsetType):
            return twins.chain
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return declared_chain(experiment, **cast(Any, twins.noise))


def written_study(result: MonteCarlo) -> WrittenMonteCarlo:
    """What ``--json`` writes."""
    plan = result.plan
    experiment = Chain.of_experiment(plan.twin.axis)
    return WrittenMonteCarlo(
        written_belief=result.belief,
        axis=plan.axis.axis.name,
        signature=plan.axis.signature,
        twins=WrittenTwins(
            axis=plan.twin.axis.name,
            signature=plan.twin.signature,
            right=plan.is_right,
            noise=declared_figures(plan.noise),
            chain=plan.noise,
            position_noise=experiment.position,
            resolution=experiment.position_step,
            unit=plan.twin.axis.coordinate.unit,
            drive_unit=plan.twin.axis.drive.unit,
        ),
        runs=plan.runs,
        done=len(result),
        seed=plan.seed,
        methods=plan.methods,
        prefilter=written_as(WrittenRequest, plan.prefilter),
        settings=dict(plan.settings),
        levels=plan.levels,
        estimands=result.figures,
        judged=result.judged,
        objected=result.objected,
        checks=result.check_figures,
        failures=result.failures,
    )


def study_facts(result: MonteCarlo) -> SavedMonteCarlo:
    """What a study tells without the numbers of its runs, which is all that tables show."""
    return SavedMonteCarlo.of_document(written_study(result))
