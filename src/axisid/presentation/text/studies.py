"""Studies as documents: which laws explain a control, estimates over the cut-off, validations."""

from collections.abc import Sequence

from axisid.estimation.identification import Identification
from axisid.estimation.law_search import ExplainedLaw, LawSearch
from axisid.estimation.studies import FitValidation, Sweep, Validation
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
    text_columns,
)
from axisid.presentation.formulas import figure_text
from axisid.support.errors import Missing

from .identification import verdict_block
from .record import record_facts, set_aside_facts, several_facts

_MOST = 8  # laws that are listed
_NOT_TOLD = ("record", "columns")  # but what was assumed and repaired


def law_search_document(search: LawSearch) -> Document:
    """The laws by what they leave, the gains of the best, and how to declare it."""
    heading = Heading(facts=tuple(record_facts(search.record).items()))
    return heading, _ranking(search), _gains_table(search.best), _conclusion(search)


def _ranking(search: LawSearch) -> Table:
    return Table(
        columns=(
            *text_columns(["", "law"]),
            Column("gains", align="left"),
            Column("delay", "samples"),
            Column("held-out", "%"),
            Column("own", "%"),
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
        title="Ready laws by what they leave of the control, of held-out and of their own rows",
    )


def _gains_table(best: ExplainedLaw) -> Table:
    return Table(
        columns=(*text_columns([best.title]), Column("value"), Column("sd")),
        rows=tuple(
            (
                name,
                f"{value:.6g}",
                f"{best.deviations[name]:.2g}" if name in best.deviations else "not shown",
            )
            for name, value in best.law.gains.items()
        ),
    )


def _conclusion(search: LawSearch) -> Paragraph:
    best = search.best
    if not search.explained:
        return paragraph(f"{search.checks[0].meaning}.", filled=False)
    others = search.as_well - 1
    more = f"{others} other{'s' * (others > 1)} with more gains" if others else ""
    lines = [f"The control is explained as well by {more}."] if more else []
    lines += [f"The same control gives {best.same}."] if best.same else []
    lines += [f"in TOML:   {best.toml}"]
    said = Sentence(lead="declare: ", text=best.python, filled=False)
    return paragraph(*lines, said, filled=False)


def sweep_document(sweep: Sweep) -> Document:
    """Values by cut-off and method, and the recommendation."""
    first = sweep.results[0]
    facts = (
        several_facts(first.of_records, {p.name: p.unit for p in first.axis.declared.parameters})
        if first.of_records
        else record_facts(first.record)
    )
    facts = {
        "left out": left_out_text(first.axis.declared),
        **{name: text for name, text in facts.items() if not name.startswith(_NOT_TOLD)},
    }
    tables: list[Block] = [
        _sweep_table(sweep, quantity.name, quantity.unit, sweep.methods)
        for quantity in first.preferred.quantities
    ]
    facts |= set_aside_facts(first.set_aside)
    return Heading(facts=tuple(facts.items())), *tables, _sweep_remarks(sweep)


def _sweep_table(sweep: Sweep, name: str, unit: str, methods: Sequence[str]) -> Table:
    of_methods = (Column(f"{method.upper()} {name}", unit, parts=("sd",)) for method in methods)
    return Table(
        columns=(Column("cut-off", "Hz", "left"), Column("1 of"), *of_methods),
        rows=tuple(_sweep_row(result, name, methods) for result in sweep.results),
    )


def _sweep_row(result: Identification, name: str, methods: Sequence[str]) -> tuple[Cell, ...]:
    row: list[Cell] = [f"{result.prefilter.cutoff:g}", str(result.prefilter.decimate)]
    for method in methods:
        estimate = result.estimates.get(method)
        value = estimate and estimate.parameters[name]
        texts = (f"{value.corrected:.5g}", f"{value.deviation:.2g}") if value else ("-", "-")
        row.append(Quantity(*texts))
    return tuple(row)


def _sweep_remarks(sweep: Sweep) -> Paragraph:
    lines = ["Values are without the bias of filter and noise, where that is known."]
    lines += [f"{cutoff:g} Hz gave no estimate: {why}" for cutoff, why in sweep.failures.items()]
    if not isinstance(sweep.law, Missing) and not sweep.law.passed:
        lines.append(f"believe nothing before this is mended: {sweep.law.sentence}.")
    said = f"{sweep.recommendation}."
    recommended = Sentence(lead="recommended: ", text=said, filled=False)
    return paragraph(*lines, recommended, filled=False)


def validation_document(validation: Validation) -> Document:
    """What was repaired of the record, and the errors."""
    record = validation.record
    title = f"Frozen estimates on {record.provenance.source}, {len(record)} samples:"
    repaired = ("repaired", record_facts(record)["repaired"])
    return Heading(facts=(repaired,), title=title), validation_table(validation)


def fit_validation_document(validation: FitValidation) -> Document:
    """What a frozen fit leaves of a record, and whether it holds."""
    record, unit = validation.record, validation.unit
    left = f"{validation.error:.4g} {unit}".rstrip() + f", {validation.percent:.3g} % of it"
    title = f"Frozen fit on {record.provenance.source}, {len(record)} samples:"
    facts = ((validation.output, f"leaves {left}"),)
    return Heading(facts=facts, title=title), verdict_block(validation.checks)


def validation_table(validation: Validation) -> Table:
    """The errors by method."""
    return Table(
        columns=text_columns(["validation", "unit", *(v.method.upper() for v in validation)]),
        rows=tuple((*name, *map(_cell, figures)) for name, figures in validation.errors.items()),
        labels=2,
        said=validation.notes,
    )


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
