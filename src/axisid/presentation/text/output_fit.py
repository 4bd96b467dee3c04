"""A fit of a simulated output as a document: heading, parameters, errors, verdict, notes."""

import math
from collections.abc import Iterator

from axisid.estimation.choices import LOSSES, OUTPUTS, SQUARES
from axisid.estimation.estimates import Value
from axisid.estimation.fitting import OutputFit
from axisid.modeling.declaration import Axis, left_out_text
from axisid.presentation.blocks import (
    Cell,
    Document,
    Heading,
    Notes,
    Quantity,
    Table,
    text_columns,
)
from axisid.presentation.documents import written_output_fit
from axisid.presentation.saved import SavedOutputFit
from axisid.presentation.schema import WrittenFitted
from axisid.support.errors import range_text

from .estimate import quantity
from .identification import verdict_block
from .record import listed_facts, record_facts

#: What each covariance is, for notes.
_COVARIANCES = {
    "coloured": "errors follow an autoregression, of each record its own; sandwich",
    "iid": "independent errors",
    "bootstrap": "as twins with the records' noise scatter",
}


def output_fit_document(fit: OutputFit) -> Document:
    """Heading, parameters, what is left of each record, the verdict and notes."""
    facts = SavedOutputFit.of("", written_output_fit(fit))
    return saved_fit_document(facts, declared=fit.axis.declared)


def saved_fit_document(fit: SavedOutputFit, *, declared: Axis | None = None) -> Document:
    """The same of what a file has; `declared` is the axis, which no file has."""
    return (
        _heading(fit, declared),
        _parameters(fit),
        _errors(fit),
        verdict_block(fit.checks),
        Notes(tuple(_notes(fit))),
    )


def _heading(fit: SavedOutputFit, declared: Axis | None) -> Heading:
    told = [record_facts(record) for record in fit.records]
    written = fit.document
    facts = {
        "axis": fit.name + (f": {declared.title}" if declared and declared.title else ""),
        "left out": left_out_text(declared)
        if declared
        else ", ".join(f"{name} = {value:g}" for name, value in written.left_out.items()),
        **(told[0] if len(told) == 1 else listed_facts(told)),
        "output": "; ".join(f"{name}, {OUTPUTS[name]}" for name in fit.outputs),
        "loss": "" if written.loss == SQUARES else f"{written.loss}, {LOSSES[written.loss]}",
        "start": f"{written.started}, {len(written.iterations)} steps",
    }
    return Heading(facts=tuple(facts.items()))


def _parameters(fit: SavedOutputFit) -> Table:
    heads = ["", "unit", "value", "sd [1]", "rel. sd", "95 % interval", "start", "remark"]
    rows = tuple(_row(fit, name) for name in fit.names)
    return Table(columns=text_columns(heads), rows=rows, labels=2)


def _row(fit: SavedOutputFit, name: str) -> tuple[Cell, ...]:
    value, written = fit[name], fit.document.parameters[name]
    held = written.fixed or written.at_bound is not None
    shown = _shown(value)
    sd, relative = ("-", "-") if held else (shown.deviation, shown.more[0])
    interval = "-" if written.fixed else range_text(*value.interval, " to ", digits=6)
    start = f"{written.start:.6g}"
    return name, value.unit, shown.value, sd, relative, interval, start, _remark(written)


def _shown(value: Value) -> Quantity:
    if value.deviation < math.inf:
        return quantity(value)
    return Quantity(f"{value.value:.6g}", "inf", ("-", ""))


def _remark(written: WrittenFitted) -> str:
    if written.fixed:
        return "fixed"
    if written.at_bound is not None:
        return f"at its {written.at_bound} bound [2]"
    return f"known {written.prior.value:g} +- {written.prior.sd:g}" if written.prior else ""


def _errors(fit: SavedOutputFit) -> Table:
    several, count = len(fit.records) > 1, len(fit.outputs)
    of_record = [f"{i}  {r.provenance.source}" for i, r in enumerate(fit.records, 1)]
    rows = tuple(
        (
            *((of_record[place // count],) if several else ()),
            *((each.output or fit.output,) if count > 1 or not several else ()),
            str(each.rows),
            f"{each.error:.5g}",
            *((each.unit,) if count > 1 else ()),
            f"{each.percent:.4f}",
            str(each.order),
        )
        for place, each in enumerate(fit.document.record_errors)
    )
    heads = ["left of", "samples", f"error {fit.document.unit}", "error %", "order [1]"]
    if count > 1:
        both = ["", "output"] if several else ["left of"]
        heads = [*both, "samples", "error", "unit", "error %", "order [1]"]
    return Table(columns=text_columns(heads), rows=rows)


def _compared(fit: SavedOutputFit) -> str:
    if fit.document.horizon:
        return (
            f"Position under the recorded control less the recorded one, in windows of "
            f"{fit.document.horizon:g} s. Each has a first position and velocity of its own, "
            "which are fitted with the parameters; percent are of the way from there."
        )
    return (
        f"Simulated less recorded {fit.output} at every sample that is measured and counts; no "
        "filter, no decimation. The loop starts as the record does."
    )


def _steps(fit: SavedOutputFit) -> str:
    written = fit.document
    if not written.encoder_step:
        return ""
    size = f"{written.encoder_step:.3g} {written.position_unit}"
    return f"; what simulated loops with an encoder's steps of {size} scatter, where that is more"


def _notes(fit: SavedOutputFit) -> Iterator[str]:
    written, first = fit.document, fit[fit.names[0]]
    chosen = written.chosen_covariance
    others = "; ".join(f"{n} ({_COVARIANCES[n]})" for n in first.deviations if n != chosen)
    yield (
        f"Standard deviations: {_COVARIANCES[chosen]}; order by Akaike's criterion, up to "
        f"0.1 s{_steps(fit)}. Others in JSON: {others}."
    )
    if any(each.at_bound for each in written.parameters.values()):
        yield (
            "At a bound the interval is one-sided: of a normal distribution about what the errors "
            "alone would give, cut off there. The others' deviations are those without the bound."
        )
    if len(fit.outputs) > 1:
        yield (
            "Outputs count by the inverse of what is left of each, or as asked; an autoregression "
            "of them all has what their errors have in common."
        )
    yield _compared(fit)
    for name, own in (written.local or {}).items():
        listed = ", ".join(dict.fromkeys(filter(None, own)))
        yield f"{listed}: {name} of each record, in their order."
    # Instruments and least squares may be refused for one reason.
    said = dict.fromkeys(written.remarks)
    yield from (f"It starts from {written.started} values: {each}" for each in said)
    yield f"Generated code {written.signature[:12]}."
