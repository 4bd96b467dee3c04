"""A fit of a simulated output as a document."""

from msgspec import UNSET

from axisid.estimation.fitting import OutputFit
from axisid.estimation.lacking import amount, sentence
from axisid.estimation.studies import FitValidation
from axisid.presentation.schema import (
    WrittenFitted,
    WrittenFitValidation,
    WrittenKnown,
    WrittenLack,
    WrittenLevels,
    WrittenOutputFit,
    WrittenRecordError,
)
from axisid.support.arrays import finite
from axisid.support.missing import Missing
from axisid.support.remedy import Wording, as_options

from .diagnosis import written_check, written_law
from .identification import left_out, written_record
from .same_members import written_as


def written_fit_validation(validation: FitValidation) -> WrittenFitValidation:
    """What is left of a second record, and whether the fit holds on it."""
    return written_as(
        WrittenFitValidation,
        validation,
        record=written_record(validation.record),
        verdict=tuple(map(written_check, validation.checks)),
    )


def written_output_fit(fit: OutputFit, wording: Wording = as_options) -> WrittenOutputFit:
    """The parameters with all that was asked and found of each, and whether to believe them."""
    return WrittenOutputFit(
        belief=fit.belief,
        axis=fit.axis.axis.name,
        signature=fit.axis.signature,
        left_out=left_out(fit.axis),
        records=tuple(written_record(record, wording) for record in fit.records),
        output=fit.output,
        unit=fit.unit,
        position_unit=str(fit.axis.axis.coordinate.unit),
        encoder_step=fit.step,
        loss=fit.loss,
        started=fit.started,
        parameters={name: _fitted(fit, j, name) for j, name in enumerate(fit.names)},
        covariance=tuple(tuple(map(finite, row)) for row in fit.covariance.tolist()),
        chosen_covariance=fit.chosen,
        error=fit.error,
        error_percent=finite(fit.error_percent),
        percent_beyond_noise=finite(fit.percent_beyond_noise),
        record_errors=tuple(
            written_as(WrittenRecordError, each, noise=noise)
            for each, noise in zip(fit.of_records, fit.noise, strict=True)
        ),
        lacks=_lacks(fit),
        unseen=fit.unseen,
        horizon=UNSET if fit.horizon is None else fit.horizon,
        local=dict(fit.local) or UNSET,
        iterations=tuple(
            dict(zip(fit.names, map(float, step.physical), strict=True)) for step in fit.steps
        ),
        iteration_errors=tuple(step.error for step in fit.steps),
        costs=tuple(cost for cost, _ in fit.ends),
        law_check=written_law(fit.law),
        verdict=tuple(map(written_check, fit.checks)),
        believed=fit.believed,
        levels=written_as(WrittenLevels, fit.levels),
        remarks=tuple(note.worded(wording) for note in fit.remarks),
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
    found = []
    for lacks, axis, record in looked:
        for each in lacks:
            size, deviation, unit = amount(each, axis)
            found.append(
                WrittenLack(
                    subject=sentence(each, axis, record),
                    size=size,
                    deviation=deviation,
                    unit=unit,
                    chance=each.p_value,
                )
            )
    return tuple(found)


def _fitted(fit: OutputFit, place: int, name: str) -> WrittenFitted:
    value, (low, high) = fit.values[name], fit.bounds[name]
    known = fit.prior.get(name)
    return WrittenFitted(
        value=value.value,
        unit=value.unit,
        sd=finite(value.deviation),
        deviations={n: finite(sd) for n, sd in value.deviations.items()},
        interval_95=(finite(value.interval[0]), finite(value.interval[1])),
        start=float(fit.start[place]),
        bounds=(finite(low), finite(high)),
        at_bound=fit.at_bound.get(name),
        fixed=name in fit.fixed,
        prior=None if known is None else WrittenKnown(value=known[0], sd=known[1]),
        law_percent={term: float(move[place]) for term, move in fit.law_moves.items()},
        law_move=None if fit.law_move is None else float(fit.law_move[place]),
    )
