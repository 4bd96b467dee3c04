"""Fits and studies as documents: outputs, laws of a control, estimates over the cut-off."""

import math
from collections.abc import Iterator

from axisid.estimation.choices import LOSSES, OUTPUTS, SQUARES
from axisid.estimation.control_law_search import LawSearch
from axisid.estimation.model_selection import Sweep
from axisid.estimation.model_validation import FitValidation, Validation
from axisid.estimation.output_error import OutputFit
from axisid.modeling.declaration import Axis, left_out_text
from axisid.presentation.documents import (
    Cell,
    Document,
    Heading,
    Paragraph,
    QuantityCell,
    Sentence,
    TableBlock,
    TableColumn,
    decimals,
    figure_text,
    paragraph,
    text_columns,
    text_table,
)
from axisid.presentation.result_files import SavedOutputFit, written_output_fit

from .identification import verdict_block
from .record import local_notes, record_facts, records_facts, set_aside_facts

#: Origin of the standard errors, by covariance.
_COVARIANCES = {
    "coloured": "for autoregressive output errors",
    "iid": "for independent output errors",
    "bootstrap": "from simulated replicas of the records",
}


def output_fit_document(fit: OutputFit) -> Document:
    """Return a fit as a document: heading, parameters, residuals, verdict and remarks."""
    return saved_fit_document(
        SavedOutputFit.of("", written_output_fit(fit)), declared=fit.axis.declared
    )


def saved_fit_document(fit: SavedOutputFit, *, declared: Axis | None = None) -> Document:
    """Return the document of a saved fit; `declared` is the axis, which files do not contain."""
    return (
        _heading(fit, declared),
        text_table(
            ["", "unit", "value", "sd", "95 % interval", "start", "remark"],
            (_row(fit, name) for name in fit.names),
            labels=2,
        ),
        _errors(fit),
        verdict_block(fit.checks),
        paragraph(*_remarks(fit)),
    )


def _heading(fit: SavedOutputFit, declared: Axis | None) -> Heading:
    """Return the heading of a fit: axis, records, output, loss and start."""
    written = fit.document
    known = [
        {name: (each[i].value, each[i].sd) for name, each in (written.known or {}).items()}
        for i in range(len(fit.records))
    ]
    units = {p.name: p.unit for p in declared.parameters} if declared else {}
    return Heading(
        facts={
            "axis": fit.name + (f": {declared.title}" if declared and declared.title else ""),
            "left out": left_out_text(declared)
            if declared
            else ", ".join(f"{name} = {value:g}" for name, value in written.left_out.items()),
            **records_facts(fit.records, known, units),
            "output": "; ".join(f"{name}, {OUTPUTS[name]}" for name in fit.outputs)
            + (f" of {written.horizon:g} s" if written.horizon else ""),
            "loss": "" if written.loss == SQUARES else f"{written.loss}, {LOSSES[written.loss]}",
            "start": f"{written.started}; {len(written.iterations)} steps of the search",
        }
    )


def _row(fit: SavedOutputFit, name: str) -> tuple[Cell, ...]:
    """Return the table row of one parameter of a fit."""
    value, written = fit[name], fit.document.parameters[name]
    known, is_told = written.prior, 0 < value.deviation < math.inf
    form = f".{decimals(value.deviation)}f" if is_told else ".6g"
    shown, sd, start = (f"{x:{form}}" for x in (value.value, value.deviation, written.start))
    interval = " to ".join(f"{end:{form}}" for end in value.interval)
    remark = f"known {known.value:g} +- {known.sd:g}" if known else ""
    if written.fixed:
        sd, interval, remark = "-", "-", "fixed"
    elif written.at_bound is not None:
        sd, remark = "-", f"at its {written.at_bound} bound"
    return name, value.unit, shown, sd, interval, start, remark


def _errors(fit: SavedOutputFit) -> TableBlock:
    """Return the table of the residuals of a fit by record and output."""
    several, count = len(fit.records) > 1, len(fit.outputs)
    of_record = [f"{i}  {r.provenance.source}" for i, r in enumerate(fit.records, 1)]
    return text_table(
        (
            *(("residual", "output") if several and count > 1 else ("residual",)),
            "samples",
            *(("rms", "unit") if count > 1 else (f"rms {fit.document.unit}",)),
            "% of output",
        ),
        (
            (
                *((of_record[place // count],) if several else ()),
                *((each.output or fit.output,) if count > 1 or not several else ()),
                str(each.rows),
                f"{each.error:.3g}",
                *((each.unit,) if count > 1 else ()),
                f"{each.percent:.3g}",
            )
            for place, each in enumerate(fit.document.record_errors)
        ),
    )


def _remarks(fit: SavedOutputFit) -> Iterator[str]:
    """Return remarks on separate parameters of records, the search and the standard errors."""
    written = fit.document
    yield from local_notes(fit.local)
    for said in dict.fromkeys(written.remarks):  # two methods may be refused for the same reason
        yield f"The search starts from {written.started} values: {said}"
    yield f"Standard errors (sd): {_COVARIANCES[written.chosen_covariance]}."


_MOST = 8  # laws that are listed


def law_search_document(search: LawSearch) -> Document:
    """Return a law search as a document: laws by residual, and gains and text of the best law."""
    best = search.best
    return (
        Heading(facts=record_facts(search.record)),
        TableBlock(
            columns=(
                *text_columns(["", "law"]),
                TableColumn("gains", align="left"),
                TableColumn("delay"),
                TableColumn("held out", "%"),
                TableColumn("fitted", "%"),
            ),
            rows=tuple(
                (
                    str(i),
                    each.title,
                    ", ".join(each.law.gains),
                    str(each.law.delay),
                    figure_text(each.held_out_percent),
                    figure_text(each.fitted_percent),
                )
                for i, each in enumerate(search.laws[:_MOST], 1)
            ),
            labels=2,
            title="Ready laws with their delay in samples: residual on held-out and on fitted rows",
        ),
        text_table(
            (best.title, "value", "sd"),
            (
                (
                    name,
                    f"{value:.6g}",
                    f"{best.deviations[name]:.2g}" if name in best.deviations else "not identified",
                )
                for name, value in best.law.gains.items()
            ),
        ),
        _conclusion(search),
    )


def _conclusion(search: LawSearch) -> Paragraph:
    """Return the declaration of the best law; if no law explains the control, the reason."""
    if not search.explained:
        return paragraph(f"{search.checks[0].meaning}.")
    best, others = search.best, search.as_well - 1
    more = f"{others} other law{'s' * (others > 1)} with more gains"
    explain = "explain" if others > 1 else "explains"
    return paragraph(
        *([f"{more} {explain} the control equally well."] if others else []),
        *([f"The same control results from {best.same}."] if best.same else []),
        Sentence(lead="in TOML:   ", text=best.toml, filled=False),
        Sentence(lead="in Python: ", text=best.python, filled=False),
    )


def sweep_document(sweep: Sweep) -> Document:
    """Return a sweep as a document: judged estimates by cut-off, recommendation and checks."""
    judged, first = [result.preferred for result in sweep.results], sweep.results[0]
    return (
        Heading(
            facts={
                "axis": first.axis.axis.name,
                "left out": left_out_text(first.axis.declared),
                **records_facts(
                    first.records,
                    [of_one.known for of_one in first.of_records],
                    {p.name: p.unit for p in first.axis.declared.parameters},
                ),
                **set_aside_facts(first.set_aside),
            }
        ),
        TableBlock(
            columns=(
                TableColumn("cut-off", "Hz", "left"),
                TableColumn("decimation"),
                TableColumn("method", align="left"),
                *(TableColumn(q.name, q.unit, parts=("sd",)) for q in judged[0].quantities),
            ),
            rows=tuple(
                (
                    f"{result.prefilter.cutoff:g}",
                    str(result.prefilter.decimate),
                    estimate.method.upper(),
                    *(
                        QuantityCell(f"{value.corrected:.5g}", f"{value.deviation:.2g}")
                        for value in (estimate.parameters[q.name] for q in judged[0].quantities)
                    ),
                )
                for result, estimate in zip(sweep.results, judged, strict=True)
            ),
            title="Values minus the bias of filter and noise (if it is known)",
        ),
        paragraph(
            *(f"No estimate at {cutoff:g} Hz: {why}" for cutoff, why in sweep.failures.items()),
            Sentence(lead="recommended: ", text=f"{sweep.recommendation}.", hang=4),
        ),
        verdict_block(sweep.checks),
    )


def validation_document(validation: Validation) -> Document:
    """Return a validation as a document: errors of each frozen estimate on the second record."""
    record = validation.record
    title = f"Frozen estimates on {record.provenance.source}, {len(record)} samples:"
    heading = Heading(facts={"repaired": record_facts(record)["repaired"]}, title=title)
    return heading, text_table(
        ["validation", "unit", *(v.method.upper() for v in validation)],
        (
            (*name, *("-" if x is None else f"{x:#.4g}".rstrip(".") for x in figures))
            for name, figures in validation.errors.items()
        ),
        labels=2,
        said=tuple(note.sentence for note in validation.notes),
    )


def fit_validation_document(validation: FitValidation) -> Document:
    """Return a fit's validation as a document: its residual on a second record, and checks."""
    record, unit = validation.record, validation.unit
    residual = f"residual {validation.error:.4g} {unit}".rstrip()
    residual += f" (rms), {validation.percent:.3g} % of the {validation.output} (rms)"
    return (
        Heading(
            facts={validation.output: residual},
            title=f"Frozen fit on {record.provenance.source}, {len(record)} samples:",
        ),
        verdict_block(validation.checks),
    )
