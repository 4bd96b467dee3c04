"""Studies of twins as documents, written and read again."""

from collections.abc import Mapping
from typing import Annotated, Any, cast

from msgspec import UNSET, UnsetType

from axisid.estimation.bootstrap import Chain
from axisid.estimation.diagnostic_checks import Levels
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
from axisid.support.presentable import Presentable

from .json_objects import JsonObject, WrittenResult, about, written_as
from .record import WrittenRequest


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


class SavedMonteCarlo(
    StudyFigures,
    Presentable,
    WrittenResult,
    frozen=True,
    kw_only=True,
    tag_field="schema",
    tag="axisid.monte_carlo/1",
    rename={"name": "axis", "figures": "estimands", "check_figures": "checks"},
):
    """What `axisid study --json` writes."""

    # With the names of `MonteCarlo`, but for the numbers of each run, which ``--output`` has.
    name: str
    signature: str
    twins: WrittenTwins
    runs: Annotated[int, about("Asked for.")]
    done: Annotated[int, about("Fewer where the study was ended early.")]
    seed: int
    methods: tuple[str, ...]
    prefilter: Annotated[WrittenRequest, about("As the twins' rate has it.")]
    settings: Annotated[Mapping[str, str | int | None], about("What else was asked of identify.")]
    levels: Annotated[Levels | UnsetType, about("Left out in files of earlier versions.")] = UNSET
    figures: tuple[EstimandFigures, ...]
    judged: Annotated[int, about("Runs with a verdict.")]
    objected: Annotated[Share, about("Verdicts in which any check fails.")]
    check_figures: tuple[CheckFigures, ...]
    failures: tuple[FailedRun, ...]

    def __repr__(self) -> str:
        methods = ", ".join(self.methods)
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {methods}"

    def __len__(self) -> int:
        return self.done

    @property
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of."""
        return str(self.settings["covariance"])

    @property
    def noise(self) -> Chain:
        """Of the twins."""
        twins = self.twins
        if not isinstance(twins.chain, UnsetType):
            return twins.chain
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return declared_chain(experiment, **cast(Any, twins.noise))


def written_study(result: MonteCarlo) -> SavedMonteCarlo:
    """What a study tells without the numbers of its runs, which is all that tables show."""
    plan = result.plan
    experiment = Chain.of_experiment(plan.twin.axis)
    return SavedMonteCarlo(
        written_belief=result.belief,
        name=plan.axis.axis.name,
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
        figures=result.figures,
        judged=result.judged,
        objected=result.objected,
        check_figures=result.check_figures,
        failures=result.failures,
    )
