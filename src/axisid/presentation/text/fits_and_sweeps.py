"""Fits, searches of control laws, sweeps over the cut-off and validations as documents."""

import math
from collections.abc import Iterator

from axisid.estimation.choices import (
    CONTROL,
    FORCE,
    INSTRUMENTS_START,
    LEAST_SQUARES_START,
    LOSSES,
    NOMINAL_START,
    OPEN_LOOP,
    POSITION,
    SQUARES,
)
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
    without_empty_last_column,
)
from axisid.presentation.result_files import SavedOutputFit, written_output_fit

from .identification import plus_minus_notes, verdict_block
from .record import local_notes, record_facts, records_facts, set_aside_facts

#: Description of the standard errors of a fit, by covariance.
_COVARIANCES = {
    "coloured": "for autoregressive output errors",
    "iid": "for independent output errors",
    "bootstrap": "from simulated replicas of the records",
}


#: Fitted and recorded quantity by output.
_FITTED = {
    CONTROL: "the control of the simulated loop is fitted to the recorded control",
    POSITION: "the position of the simulated loop is fitted to the recorded position, which needs "
    "the exact control law",
    FORCE: "the force of the simulated drive is fitted to the recorded force",
    OPEN_LOOP: "the position that is simulated with the recorded control is fitted to the recorded "
    "position, in windows",
}
#: Start values of the search, by start.
_STARTS = {
    INSTRUMENTS_START: "estimate by instrumental variables",
    LEAST_SQUARES_START: "least-squares estimate",
    NOMINAL_START: "nominal values",
}


def output_fit_document(fit: OutputFit) -> Document:
    """Return a fit as a document: heading, parameters, residuals, verdict and remarks."""
    return saved_fit_document(
        SavedOutputFit.of("", written_output_fit(fit)), declared=fit.axis.declared
    )


def saved_fit_document(fit: SavedOutputFit, *, declared: Axis | None = None) -> Document:
    """Return the document of a saved fit.

    Parameters
    ----------
    fit : SavedOutputFit
    declared : Axis, optional
        Fitted axis, which files do not contain; without it the document has no title and no units
        of known values.
    """
    parameters = text_table(
        ["", "unit", "value", "sd", "95 % interval", "start", "remark"],
        (_row(fit, name) for name in fit.names),
        labels=2,
    )
    return (
        _heading(fit, declared),
        without_empty_last_column(parameters),
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
    axis = fit.name
    units: dict[str, str] = {}
    if declared is not None:
        units = {p.name: p.unit for p in declared.parameters}
        left_out = left_out_text(declared)
        if declared.title:
            axis = f"{fit.name}: {declared.title}"
    else:
        left_out = ", ".join(f"{name} = {value:g}" for name, value in written.left_out.items())
    output = "; ".join(f"{name}: {_FITTED[name]}" for name in fit.outputs)
    if written.horizon:
        output += f" of {written.horizon:g} s"
    return Heading(
        facts={
            "axis": axis,
            "left out": left_out,
            **records_facts(fit.records, known, units),
            "output": output,
            "loss": "" if written.loss == SQUARES else f"{written.loss}, {LOSSES[written.loss]}",
            "start": f"{_STARTS.get(written.started, written.started)}; the search took "
            f"{len(written.iterations)} step{'s' * (len(written.iterations) != 1)}",
        }
    )


def _row(fit: SavedOutputFit, name: str) -> tuple[Cell, ...]:
    """Return the table row of one parameter of a fit, with the digits of its standard error."""
    value, written = fit[name], fit.document.parameters[name]
    prior, has_deviation = written.prior, 0 < value.deviation < math.inf
    form = f".{decimals(value.deviation)}f" if has_deviation else ".6g"
    shown, sd, start = (f"{x:{form}}" for x in (value.value, value.deviation, written.start))
    interval = " to ".join(f"{end:{form}}" for end in value.interval)
    remark = f"known {prior.value:g} +- {prior.sd:g}" if prior else ""
    if written.fixed:
        sd, interval, remark = "-", "-", "fixed"
    elif written.at_bound is not None:
        sd, remark = "-", f"at its {written.at_bound} bound"
    return name, value.unit, shown, sd, interval, start, remark


def _errors(fit: SavedOutputFit) -> TableBlock:
    """Return the table of the residuals of a fit by record and output.

    With several records a column names the record. The output has a column unless all rows have the
    same one; the unit has one if there are several outputs.
    """
    has_records, count = len(fit.records) > 1, len(fit.outputs)
    has_outputs, has_units = count > 1 or not has_records, count > 1
    heads: list[str] = []
    if has_records:
        heads.append("record")
    if has_outputs:
        heads.append("output")
    heads.append("samples")
    if has_units:
        heads += ["rms residual", "unit"]
    else:
        heads.append(f"rms residual [{fit.document.unit}]")
    heads.append("residual [% of output]")
    sources = [f"{i}  {r.provenance.source}" for i, r in enumerate(fit.records, 1)]
    rows = []
    for i, each in enumerate(fit.document.record_errors):  # by record, and in each by output
        row: list[str] = []
        if has_records:
            row.append(sources[i // count])
        if has_outputs:
            row.append(each.output or fit.output)
        row += [str(each.rows), f"{each.error:.3g}"]
        if has_units:
            row.append(each.unit)
        row.append(f"{each.percent:.3g}")
        rows.append(row)
    return text_table(heads, rows)


def _remarks(fit: SavedOutputFit) -> Iterator[str]:
    """Yield remarks on separate parameters of records, the search and the standard errors."""
    written = fit.document
    yield from local_notes(fit.local)
    for remark in dict.fromkeys(written.remarks):  # two methods may be refused for the same reason
        start = _STARTS.get(written.started, written.started)
        yield f"The search starts from the {start}: {remark}"
    yield from plus_minus_notes(fit.checks)
    yield f"Standard errors (sd): {_COVARIANCES[written.chosen_covariance]}."


_MOST = 8  # laws that are listed


def law_search_document(search: LawSearch) -> Document:
    """Return a law search as a document: laws by residual, gains and declaration of the best."""
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
            title="Built-in control laws",
            said=(
                "The delay is in samples. Held out, fitted: rms residual on the held-out and on "
                "the fitted rows, relative to the control (rms).",
            ),
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
    """Return the declaration of the best law, and other laws that are equally good.

    If no law explains the control, it is the reason instead.
    """
    if not search.explained:
        return paragraph(f"{search.checks[0].meaning}.")
    best, others = search.best, search.as_well - 1
    sentences: list[str] = []
    if others == 1:
        sentences.append("1 other law with more gains explains the control equally well.")
    elif others:
        sentences.append(f"{others} other laws with more gains explain the control equally well.")
    if best.same:
        sentences.append(f"The same control results from {best.same}.")
    return paragraph(
        *sentences,
        Sentence(lead="in TOML:   ", text=best.toml, filled=False),
        Sentence(lead="in Python: ", text=best.python, filled=False),
    )


def sweep_document(sweep: Sweep) -> Document:
    """Return a sweep as a document: judged estimates by cut-off, recommendation and checks."""
    judged, first = [result.preferred for result in sweep.results], sweep.results[0]
    sentences: list[str | Sentence] = [
        f"No estimate at {cutoff:g} Hz: {why}" for cutoff, why in sweep.failures.items()
    ]
    sentences.append(Sentence(lead="recommended: ", text=f"{sweep.recommendation}.", hang=4))
    if sweep.recommended is not None:
        recommended = judged[sweep.cutoffs.index(sweep.recommended)]
        sentences.append(
            f"The verdict below applies to the {recommended.method.upper()} estimate with the "
            f"recommended cut-off of {sweep.recommended:g} Hz."
        )
    return (
        Heading(
            facts={
                "axis": first.axis.axis.name,
                "left out": left_out_text(first.axis.declared),
                **records_facts(
                    first.records,
                    [member.known for member in first.of_records],
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
            title="Values minus the bias of filter and noise",
            said=(
                "If the bias of a value is unknown, it is not subtracted. method: the reported "
                "method at this cut-off, whose values and standard errors (sd) follow.",
            ),
        ),
        paragraph(*sentences),
        verdict_block(sweep.checks),
        paragraph(*plus_minus_notes(sweep.checks)),
    )


def validation_document(validation: Validation) -> Document:
    """Return a validation as a document: errors of each frozen estimate on the second record.

    The errors have one column for each method, and sentences of the checks below.
    """
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
    """Return a fit's validation as a document: residual on the second record, and checks."""
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
