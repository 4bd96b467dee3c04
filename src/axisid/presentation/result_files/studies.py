"""Comparisons, validations, sweeps, law searches and Monte-Carlo studies as documents."""

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
    """A built-in law with the gains that fit the control best."""

    law: Annotated[str, about("Name in `axisid.control` and in TOML.")]
    words: Annotated[Mapping[str, str], about("Arguments that are not numbers.")]
    gains: Annotated[Mapping[str, float], about("SI, with the unit of the control.")]
    sd: Annotated[
        Mapping[str, float],
        about("Standard errors of the identified gains, for autocorrelated residuals."),
    ]
    delay: Annotated[int, about("Samples between computing a control and logging it.")]
    period: Annotated[float, about("Sampling period of the log, s.")]
    held_out_percent: Annotated[float, about("Residual on held-out rows, relative to the control.")]
    fitted_percent: Annotated[float, about("Residual on the fitted rows, relative to the control.")]
    same: Annotated[str, about("Other laws with the same control.")]
    toml: Annotated[str, about("Declaration in TOML.")]


class WrittenLawSearch(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.law/1"
):
    """Document written by `axisid law --json`."""

    axis: str
    unit: Annotated[str, about("Unit of the control.")]
    explained: Annotated[
        bool, about("True if the residual of the first law is within the limit of the law check.")
    ]
    as_well: Annotated[
        int, about("Number of laws, from the first, with an equally small residual.")
    ]
    laws: Annotated[
        tuple[WrittenExplainedLaw, ...],
        about("Sorted by residual; among equal residuals, laws with fewer gains first."),
    ]


class WrittenSweep(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.sweep/1"
):
    """Document written by `axisid sweep --json`."""

    recommended_cutoff: Annotated[float | None, about("Hz; null if none is recommended.")]
    reason: str
    failures: Annotated[
        Mapping[str, str],
        about("Cut-offs without an estimate, Hz, with the reason."),
    ]
    results: tuple[WrittenIdentification, ...]


class WrittenHeldOut(JsonObject, frozen=True, kw_only=True):
    """Errors on held-out rows."""

    error_percent: float | None
    squares_by_block: tuple[float | None, ...]


class WrittenCandidate(JsonObject, frozen=True, kw_only=True):
    """One model of a comparison."""

    name: str
    axis: str
    signature: str
    left_out: Annotated[
        Mapping[str, float],
        about("Values of the parameters that were left out, SI, by name."),
    ]
    estimate: WrittenEstimate
    criteria: Criteria
    held_out_equation: WrittenHeldOut


class WrittenHeldOutBlocks(JsonObject, frozen=True, kw_only=True):
    """Blocks of held-out rows."""

    blocks: int
    gap_rows: int


class WrittenComparison(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.comparison/1"
):
    """Document written by `axisid compare --json`."""

    record: WrittenRecord
    records: Annotated[
        tuple[WrittenRecord, ...] | UnsetType,
        about("All records, if there are several; `record` is the first."),
    ] = UNSET
    known: Annotated[
        Mapping[str, tuple[WrittenKnown, ...]] | UnsetType,
        about("Known values of each record, SI, by name."),
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
    same: Annotated[
        tuple[tuple[str, ...], ...],
        about("Candidates that are the same model with different parameters."),
    ]
    recommended: str | None
    tied: tuple[str, ...]
    reason: str


def written_comparison(comparison: Comparison) -> WrittenComparison:
    """Return the document of a comparison: candidates, tests and recommendation."""
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
    """Return the document of a validation on a second record; non-finite numbers become None."""
    return written_as(
        WrittenValidation,
        validation,
        record=written_record(validation.record),
        methods=tuple(map(_of_method, validation)),
        law_check=written_law(validation.law),
    )


def _of_method(validation: MethodValidation) -> WrittenMethodValidation:
    """Return the validation of one method as part of a document."""
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
    """Return the document of a sweep: identifications and recommendation."""
    return written_as(
        WrittenSweep,
        sweep,
        recommended_cutoff=sweep.recommended,
        failures={f"{cutoff:g}": why for cutoff, why in sweep.failures.items()},
        results=tuple(map(written_identification, sweep.results)),
    )


def written_law_search(search: LawSearch) -> WrittenLawSearch:
    """Return the document of a law search."""
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
    """Simulated twins of a study."""

    axis: str
    signature: str
    right: Annotated[bool, about("True if the identified model is the simulated one.")]
    noise: Annotated[
        Mapping[str, float | bool | None],
        about(
            "By the names of the options; for several autoregressions the standard deviation of "
            "their sum. In files without `chain`, null means the value of the experiment, or none."
        ),
    ]
    chain: Annotated[
        Chain | UnsetType,
        about("Complete noise model, SI; absent in files of earlier versions."),
    ] = UNSET
    position_noise: Annotated[
        float, about("Position noise of the experiment, in the unit of the coordinate.")
    ]
    resolution: Annotated[float, about("Encoder step of the experiment, in that unit; 0 for none.")]
    unit: Annotated[str, about("Unit of the coordinate.")]
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
    """Document written by `axisid study --json`."""

    # It has the attributes of `MonteCarlo`, except for the numbers of each run (``--output``).
    name: str
    signature: str
    twins: WrittenTwins
    runs: Annotated[int, about("Requested number of runs.")]
    done: Annotated[int, about("Completed runs; fewer if the study was ended early.")]
    seed: int
    methods: tuple[str, ...]
    prefilter: Annotated[
        WrittenRequest, about("Requested prefilter, at the sampling rate of the twins.")
    ]
    settings: Annotated[Mapping[str, str | int | None], about("Other settings of identify.")]
    levels: Annotated[Levels | UnsetType, about("Absent in files of earlier versions.")] = UNSET
    figures: tuple[EstimandFigures, ...]
    judged: Annotated[int, about("Number of runs with a verdict.")]
    objected: Annotated[Share, about("Share of verdicts with a failed check.")]
    check_figures: tuple[CheckFigures, ...]
    failures: tuple[FailedRun, ...]

    def __repr__(self) -> str:
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {', '.join(self.methods)}"

    def __len__(self) -> int:
        return self.done

    @property
    def chosen(self) -> str:
        """Return the covariance of the printed intervals, by its name in `COVARIANCES`."""
        return str(self.settings["covariance"])

    @property
    def noise(self) -> Chain:
        """Return the noise of the twins; files of earlier versions have only some of its sizes."""
        twins = self.twins
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return twins.chain or declared_chain(experiment, **cast(Any, twins.noise))


def written_study(result: MonteCarlo) -> SavedMonteCarlo:
    """Return the document of a study, which tables need: figures, not the numbers of each run."""
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
