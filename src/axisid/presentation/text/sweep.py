"""Estimates over the cut-off as a document."""

from collections.abc import Sequence

from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep
from axisid.modeling.declaration import left_out_text
from axisid.presentation.blocks import (
    Block,
    Cell,
    Column,
    Document,
    Heading,
    Paragraph,
    Quantity,
    Sentence,
    Table,
    paragraph,
)
from axisid.support.missing import Missing
from axisid.support.remedy import Wording, as_arguments

from .record import record_facts, set_aside_facts, several_facts

_NOT_TOLD = ("record", "columns")  # but what was assumed and repaired


def sweep_document(sweep: Sweep, *, wording: Wording = as_arguments) -> Document:
    """Values by cut-off and method, and the recommendation."""
    first = sweep.results[0]
    facts = (
        several_facts(
            first.of_records, {p.name: p.unit for p in first.axis.declared.parameters}, wording
        )
        if first.of_records
        else record_facts(first.record, wording)
    )
    facts = {
        "left out": left_out_text(first.axis.declared),
        **{name: text for name, text in facts.items() if not name.startswith(_NOT_TOLD)},
    }
    tables: list[Block] = [
        _table(sweep, quantity.name, quantity.unit, sweep.methods)
        for quantity in first.preferred.quantities
    ]
    facts |= set_aside_facts(first.set_aside, wording)
    return Heading(facts=tuple(facts.items())), *tables, _remarks(sweep, wording)


def _table(sweep: Sweep, name: str, unit: str, methods: Sequence[str]) -> Table:
    of_methods = (Column(f"{method.upper()} {name}", unit, parts=("sd",)) for method in methods)
    return Table(
        columns=(Column("cut-off", "Hz", "left"), Column("1 of"), *of_methods),
        rows=tuple(_row(result, name, methods) for result in sweep.results),
    )


def _row(result: Identification, name: str, methods: Sequence[str]) -> tuple[Cell, ...]:
    row: list[Cell] = [f"{result.prefilter.cutoff:g}", str(result.prefilter.decimate)]
    for method in methods:
        estimate = result.estimates.get(method)
        value = estimate and estimate.parameters[name]
        texts = (f"{value.corrected:.5g}", f"{value.deviation:.2g}") if value else ("-", "-")
        row.append(Quantity(*texts))
    return tuple(row)


def _remarks(sweep: Sweep, wording: Wording) -> Paragraph:
    lines = ["Values are without the bias of filter and noise, where that is known."]
    lines += [
        f"{cutoff:g} Hz gave no estimate: {why.worded(wording)}"
        for cutoff, why in sweep.failures.items()
    ]
    if not isinstance(sweep.law, Missing) and not sweep.law.passed:
        law = sweep.law.note.worded(wording)
        lines.append(f"believe nothing before this is mended: {law}.")
    said = f"{sweep.recommendation}."
    recommended = Sentence(lead="recommended: ", text=said, filled=False)
    return paragraph(*lines, recommended, filled=False)
