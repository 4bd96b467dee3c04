"""Studies as documents: candidates, validations, sweeps, laws of a control, and twins."""

from collections.abc import Mapping
from typing import Annotated, Any, cast

from msgspec import UNSET, UnsetType

from axisid.estimation.control_law_search import LawSearch
from axisid.estimation.model_selection import Comparison, Criteria, NestedTest, Sweep
from axisid.estimation.model_validation import MethodValidation, Validation
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
from axisid.estimation.noise_models import Chain
from axisid.estimation.verdict_checks import Levels
from axisid.support.presentable import Presentable

from .diagnosis import written_law
from .estimate import WrittenEstimate, left_out, written_estimate
from .identification import (
    WrittenIdentification,
    WrittenMethodValidation,
    WrittenValidation,
    written_identification,
)
from .json_objects import JsonObject, WrittenKnown, WrittenResult, about, written_as
from .record import (
    WrittenPrefilter,
    WrittenRecord,
    WrittenRequest,
    written_prefilter,
    written_record,
)


class WrittenExplainedLaw(JsonObject, frozen=True, kw_only=True):
    """A ready law with the gains that explain a control best."""

    law: Annotated[str, about("Its name, in `axisid.control` and in TOML.")]
    words: Annotated[Mapping[str, str], about("Its arguments that are no numbers.")]
    gains: Annotated[Mapping[str, float], about("SI, in the control's unit.")]
    sd: Annotated[
        Mapping[str, float],
        about("Of the gains that the record tells apart, for autocorrelated residuals."),
    ]
    delay: Annotated[int, about("Samples between computing a control and logging it.")]
    period: Annotated[float, about("s, of the log.")]
    held_out_percent: Annotated[
        float, about("What it leaves of the control on rows that are held out.")
    ]
    fitted_percent: Annotated[float, about("The same on the rows that its gains are from.")]
    same: Annotated[str, about("What else gives the same control.")]
    toml: Annotated[str, about("How a TOML declaration has it.")]


class WrittenLawSearch(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.law/1"
):
    """What `axisid law --json` writes."""

    axis: str
    unit: Annotated[str, about("Of the control.")]
    explained: Annotated[bool, about("Whether the first leaves as little as the law check allows.")]
    as_well: Annotated[int, about("How many of the first leave as little as the best.")]
    laws: Annotated[
        tuple[WrittenExplainedLaw, ...],
        about("By what they leave; of those that leave as little, few gains first."),
    ]


class WrittenSweep(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.sweep/1"
):
    """What `axisid sweep --json` writes."""

    recommended_cutoff: Annotated[float | None, about("Hz; null where none can be named.")]
    reason: str
    failures: Annotated[
        Mapping[str, str],
        about("Cut-offs that gave no estimate, Hz, with the reason."),
    ]
    results: tuple[WrittenIdentification, ...]


class WrittenHeldOut(JsonObject, frozen=True, kw_only=True):
    """Errors on rows that the estimate was not made from."""

    error_percent: float | None
    squares_by_block: tuple[float | None, ...]


class WrittenCandidate(JsonObject, frozen=True, kw_only=True):
    """One model of a comparison."""

    name: str
    axis: str
    signature: str
    left_out: Annotated[
        Mapping[str, float],
        about("What stands for the parameters that were left out, SI, by name."),
    ]
    estimate: WrittenEstimate
    criteria: Criteria
    held_out_equation: WrittenHeldOut


class WrittenHeldOutBlocks(JsonObject, frozen=True, kw_only=True):
    """How rows were held out."""

    blocks: int
    gap_rows: int


class WrittenComparison(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.comparison/1"
):
    """What `axisid compare --json` writes."""

    record: WrittenRecord
    records: Annotated[
        tuple[WrittenRecord, ...] | UnsetType,
        about("Where there are several, all of them; `record` is the first."),
    ] = UNSET
    known: Annotated[
        Mapping[str, tuple[WrittenKnown, ...]] | UnsetType,
        about("What is known of each record, SI, by name."),
    ] = UNSET
    set_aside: Annotated[
        Mapping[str, str] | UnsetType,
        about("Records that could not be used, with the reason."),
    ] = UNSET
    prefilter: WrittenPrefilter
    method: str
    rows: int
    held_out: WrittenHeldOutBlocks
    candidates: tuple[WrittenCandidate, ...]
    failures: Annotated[
        Mapping[str, str],
        about("Candidates that the record does not identify, with the reason."),
    ]
    tests: tuple[NestedTest, ...]
    same: Annotated[tuple[tuple[str, ...], ...], about("One model in different parameters.")]
    recommended: str | None
    tied: tuple[str, ...]
    reason: str


def written_comparison(comparison: Comparison) -> WrittenComparison:
    """Every candidate, how they were told apart, and which is recommended."""
    c = comparison
    return written_as(
        WrittenComparison,
        c,
        record=written_record(c.record),
        records=UNSET if len(c.records) == 1 else tuple(map(written_record, c.records)),
        known={
            name: tuple(WrittenKnown(value=value, sd=sd) for value, sd in values)
            for name, values in c.known.items()
        }
        or UNSET,
        set_aside=dict(c.set_aside.items()) or UNSET,
        prefilter=written_prefilter(c.data.sampling),
        rows=len(c.candidates[0].estimate.y),
        held_out=WrittenHeldOutBlocks(blocks=c.blocks, gap_rows=c.gap),
        candidates=tuple(
            written_as(
                WrittenCandidate,
                each,
                axis=each.axis.axis.name,
                signature=each.axis.signature,
                left_out=left_out(each.axis),
                estimate=written_estimate(each.estimate),
            )
            for each in c.candidates
        ),
    )


def written_validation(validation: Validation) -> WrittenValidation:
    """Errors by method; what is not finite becomes None."""
    return written_as(
        WrittenValidation,
        validation,
        record=written_record(validation.record),
        methods=tuple(map(_of_method, validation)),
        law_check=written_law(validation.law),
    )


def _of_method(validation: MethodValidation) -> WrittenMethodValidation:
    again = validation.reestimate
    return written_as(
        WrittenMethodValidation,
        validation,
        reason=validation.reason or "",
        anew=again and again.own,
        anew_distances=again and again.distances,
        anew_share_percent=again and again.share_percent,
    )


def written_sweep(sweep: Sweep) -> WrittenSweep:
    """Every identification of a sweep, and which is recommended."""
    return written_as(
        WrittenSweep,
        sweep,
        recommended_cutoff=sweep.recommended,
        failures={f"{cutoff:g}": why for cutoff, why in sweep.failures.items()},
        results=tuple(map(written_identification, sweep.results)),
    )


def written_law_search(search: LawSearch) -> WrittenLawSearch:
    """What ``--json`` writes."""
    return written_as(
        WrittenLawSearch,
        search,
        laws=tuple(
            written_as(
                WrittenExplainedLaw,
                each,
                law=each.function,
                gains=dict(each.law.gains),
                sd=dict(each.deviations),
                delay=each.law.delay,
                period=each.law.period,
            )
            for each in search.laws
        ),
    )


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
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {', '.join(self.methods)}"

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
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return twins.chain or declared_chain(experiment, **cast(Any, twins.noise))


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
