"""A fit of a simulated output as a document: heading, parameters, errors, verdict, notes."""

import math
from collections.abc import Iterator

from axisid.estimation.choices import LOSSES, OUTPUTS, SQUARES
from axisid.estimation.estimates import Value
from axisid.estimation.fitting import OutputFit
from axisid.modeling.declaration import left_out_text
from axisid.presentation.blocks import (
    Cell,
    Document,
    Heading,
    Notes,
    Quantity,
    Table,
    text_columns,
)
from axisid.presentation.text import listed_facts, quantity, record_facts, verdict_block
from axisid.support.number_text import range_text
from axisid.support.remedy import Wording, as_arguments

#: What each covariance is, for notes.
_COVARIANCES = {
    "coloured": "errors follow an autoregression, of each record its own; sandwich",
    "iid": "independent errors",
    "bootstrap": "as twins with the records' noise scatter",
}


def output_fit_document(fit: OutputFit, *, wording: Wording = as_arguments) -> Document:
    """Heading, parameters, what is left of each record, the verdict and notes."""
    return (
        _heading(fit, wording),
        _parameters(fit),
        _errors(fit),
        verdict_block(fit.checks, wording),
        Notes(tuple(_notes(fit, wording))),
    )


def _heading(fit: OutputFit, wording: Wording) -> Heading:
    told = [record_facts(record, wording) for record in fit.records]
    declared = fit.axis.axis
    facts = {
        "axis": declared.name + (f": {declared.title}" if declared.title else ""),
        "left out": left_out_text(fit.axis.declared),
        **(told[0] if len(told) == 1 else listed_facts(told)),
        "output": "; ".join(f"{name}, {OUTPUTS[name]}" for name in fit.outputs),
        "loss": "" if fit.loss == SQUARES else f"{fit.loss}, {LOSSES[fit.loss]}",
        "start": f"{fit.started}, {len(fit.steps)} steps",
    }
    return Heading(facts=tuple(facts.items()))


def _parameters(fit: OutputFit) -> Table:
    heads = ["", "unit", "value", "sd [1]", "rel. sd", "95 % interval", "start", "remark"]
    rows = tuple(_row(fit, j, name) for j, name in enumerate(fit.names))
    return Table(columns=text_columns(heads), rows=rows, labels=2)


def _row(fit: OutputFit, place: int, name: str) -> tuple[Cell, ...]:
    value, held = fit.values[name], name in fit.fixed or name in fit.at_bound
    shown = _shown(value)
    sd, relative = ("-", "-") if held else (shown.deviation, shown.more[0])
    interval = "-" if name in fit.fixed else range_text(*value.interval, " to ", digits=6)
    start = f"{fit.start[place]:.6g}"
    return name, value.unit, shown.value, sd, relative, interval, start, _remark(fit, name)


def _shown(value: Value) -> Quantity:
    if value.deviation < math.inf:
        return quantity(value)
    return Quantity(f"{value.value:.6g}", "inf", ("-", ""))


def _remark(fit: OutputFit, name: str) -> str:
    if name in fit.fixed:
        return "fixed"
    if name in fit.at_bound:
        return f"at its {fit.at_bound[name]} bound [2]"
    if name in fit.prior:
        mean, sd = fit.prior[name]
        return f"known {mean:g} +- {sd:g}"
    return ""


def _errors(fit: OutputFit) -> Table:
    several, count = len(fit.records) > 1, len(fit.outputs)
    of_record = [f"{i}  {r.provenance.source}" for i, r in enumerate(fit.records, 1)]
    rows = tuple(
        (
            *((of_record[place // count],) if several else ()),
            *((each.output,) if count > 1 or not several else ()),
            str(each.rows),
            f"{each.error:.5g}",
            *((each.unit,) if count > 1 else ()),
            f"{each.percent:.4f}",
            str(each.order),
        )
        for place, each in enumerate(fit.of_records)
    )
    heads = ["left of", "samples", f"error {fit.of_records[0].unit}", "error %", "order [1]"]
    if count > 1:
        both = ["", "output"] if several else ["left of"]
        heads = [*both, "samples", "error", "unit", "error %", "order [1]"]
    return Table(columns=text_columns(heads), rows=rows)


def _compared(fit: OutputFit) -> str:
    if fit.horizon is not None:
        return (
            f"Position under the recorded control less the recorded one, in windows of "
            f"{fit.horizon:g} s. Each has a first position and velocity of its own, which are "
            "fitted with the parameters; percent are of the way from there."
        )
    return (
        f"Simulated less recorded {fit.output} at every sample that is measured and counts; no "
        "filter, no decimation. The loop starts as the record does."
    )


def _steps(fit: OutputFit) -> str:
    if not fit.step:
        return ""
    size = f"{fit.step:.3g} {fit.axis.axis.coordinate.unit}"
    return f"; what simulated loops with an encoder's steps of {size} scatter, where that is more"


def _notes(fit: OutputFit, wording: Wording) -> Iterator[str]:
    others = "; ".join(f"{n} ({_COVARIANCES[n]})" for n in fit.covariances if n != fit.chosen)
    yield (
        f"Standard deviations: {_COVARIANCES[fit.chosen]}; order by Akaike's criterion, up to "
        f"0.1 s{_steps(fit)}. Others in JSON: {others}."
    )
    if fit.at_bound:
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
    for name, own in fit.local.items():
        listed = ", ".join(dict.fromkeys(filter(None, own)))
        yield f"{listed}: {name} of each record, in their order."
    # Instruments and least squares may be refused for one reason.
    said = dict.fromkeys(note.worded(wording) for note in fit.remarks)
    yield from (f"It starts from {fit.started} values: {each}" for each in said)
    yield f"Generated code {fit.axis.signature[:12]}."
