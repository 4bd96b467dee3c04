"""Fits and studies as documents: candidates, validations, sweeps, and laws of a control."""

from dataclasses import asdict

from msgspec import UNSET

from axisid.estimation.fitting import OutputFit
from axisid.estimation.law_search import ExplainedLaw, LawSearch
from axisid.estimation.misspecification import sentence
from axisid.estimation.parameters import KnownValues
from axisid.estimation.studies import (
    Candidate,
    Comparison,
    FitValidation,
    MethodValidation,
    Sweep,
    Validation,
)
from axisid.presentation.schema import (
    WrittenCandidate,
    WrittenComparison,
    WrittenExplainedLaw,
    WrittenFitted,
    WrittenFitValidation,
    WrittenHeldOutBlocks,
    WrittenKnown,
    WrittenLack,
    WrittenLawSearch,
    WrittenMethodValidation,
    WrittenOutputFit,
    WrittenRecordError,
    WrittenSweep,
    WrittenValidation,
)
from axisid.support.arrays import finite
from axisid.support.errors import Missing

from .diagnosis import written_law
from .identification import (
    left_out,
    written_estimate,
    written_identification,
    written_prefilter,
    written_record,
)
from .same_members import written_as


def written_comparison(comparison: Comparison) -> WrittenComparison:
    """Every candidate, how they were told apart, and which is recommended."""
    c = comparison
    return written_as(
        WrittenComparison,
        c,
        record=written_record(c.record),
        records=UNSET if len(c.records) == 1 else tuple(map(written_record, c.records)),
        known={each.name: _known(each) for each in c.known} or UNSET,
        set_aside=dict(c.set_aside.items()) or UNSET,
        prefilter=written_prefilter(c.data.sampling),
        rows=len(c.candidates[0].estimate.y),
        held_out=WrittenHeldOutBlocks(blocks=c.blocks, gap_rows=c.gap),
        candidates=tuple(map(_candidate, c.candidates)),
    )


def _known(known: KnownValues) -> tuple[WrittenKnown, ...]:
    pairs = zip(known.values, known.deviations, strict=True)
    return tuple(WrittenKnown(value=value, sd=sd) for value, sd in pairs)


def _candidate(candidate: Candidate) -> WrittenCandidate:
    return written_as(
        WrittenCandidate,
        candidate,
        axis=candidate.axis.axis.name,
        signature=candidate.axis.signature,
        left_out=left_out(candidate.axis),
        estimate=written_estimate(candidate.estimate),
        no_simulation=candidate.reason,
    )


def written_validation(validation: Validation) -> WrittenValidation:
    """Errors by method; what is not finite becomes None."""
    return written_as(
        WrittenValidation,
        validation,
        record=written_record(validation.record),
        methods=tuple(map(_method, validation)),
        law_check=written_law(validation.law),
    )


def _method(validation: MethodValidation) -> WrittenMethodValidation:
    difference = validation.reestimate
    again = None if difference is None else difference.apart
    return written_as(
        WrittenMethodValidation,
        validation,
        reason=validation.reason or "",
        anew=None
        if again is None
        else dict(zip(again.names, map(finite, again.own.tolist()), strict=True)),
        anew_distances=None
        if again is None
        else dict(zip(again.names, map(finite, again.distances.tolist()), strict=True)),
        anew_share_percent=None if again is None else finite(again.share_percent),
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
    return written_as(WrittenLawSearch, search, laws=tuple(map(_law, search.laws)))


def _law(each: ExplainedLaw) -> WrittenExplainedLaw:
    return written_as(
        WrittenExplainedLaw,
        each,
        law=each.function,
        gains=dict(each.law.gains),
        sd=dict(each.deviations),
        delay=each.law.delay,
        period=each.law.period,
    )


def written_fit_validation(validation: FitValidation) -> WrittenFitValidation:
    """What is left of a second record, and whether the fit holds on it."""
    return written_as(
        WrittenFitValidation,
        validation,
        record=written_record(validation.record),
        verdict=validation.checks,
    )


def written_output_fit(fit: OutputFit) -> WrittenOutputFit:
    """The parameters with all that was asked and found of each, and whether to believe them."""
    return written_as(
        WrittenOutputFit,
        fit,
        axis=fit.axis.axis.name,
        signature=fit.axis.signature,
        left_out=left_out(fit.axis),
        records=tuple(written_record(record) for record in fit.records),
        position_unit=str(fit.axis.axis.coordinate.unit),
        encoder_step=fit.step,
        parameters={name: _fitted(fit, j, name) for j, name in enumerate(fit.names)},
        chosen_covariance=fit.chosen,
        record_errors=tuple(
            WrittenRecordError(**asdict(each), noise=noise)
            for each, noise in zip(fit.of_records, fit.noise, strict=True)
        ),
        lacks=_lacks(fit),
        horizon=UNSET if fit.horizon is None else fit.horizon,
        local=dict(fit.local) or UNSET,
        iterations=tuple(
            dict(zip(fit.names, map(float, step.physical), strict=True)) for step in fit.steps
        ),
        iteration_errors=tuple(step.error for step in fit.steps),
        costs=tuple(cost for cost, _ in fit.ends),
        law_check=written_law(fit.law),
        verdict=fit.checks,
    )


def _lacks(fit: OutputFit) -> tuple[WrittenLack, ...] | None:
    """Of all records in which it was looked for; None where it was in none."""
    looked = [
        (lacks, axis, record)
        for lacks, axis, record in zip(fit.lacks, fit.axes, fit.records, strict=True)
        if not isinstance(lacks, Missing)
    ]
    if not looked:
        return None
    return tuple(
        WrittenLack(
            subject=sentence(each, axis, record),
            size=each.size,
            deviation=each.deviation,
            unit=each.unit,
            chance=each.p_value,
        )
        for lacks, axis, record in looked
        for each in lacks
    )


def _fitted(fit: OutputFit, place: int, name: str) -> WrittenFitted:
    value, (low, high) = fit.values[name], fit.bounds[name]
    known = fit.prior.get(name)
    return written_as(
        WrittenFitted,
        value,
        sd=finite(value.deviation),
        start=float(fit.start[place]),
        bounds=(finite(low), finite(high)),
        at_bound=fit.at_bound.get(name),
        fixed=name in fit.fixed,
        prior=None if known is None else WrittenKnown(value=known[0], sd=known[1]),
        law_percent={term: float(move[place]) for term, move in fit.law_moves.items()},
        law_move=None if fit.law_move is None else float(fit.law_move[place]),
    )
