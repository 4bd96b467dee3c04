"""Estimates held against another record, as a document."""

from axisid.estimation.studies import FitValidation, Validation
from axisid.presentation.blocks import Document, Heading, Table, text_columns
from axisid.support.remedy import Wording, as_arguments

from .identification import verdict_block
from .record import record_facts


def validation_document(validation: Validation, *, wording: Wording = as_arguments) -> Document:
    """What was repaired of the record, and the errors."""
    record = validation.record
    title = f"Frozen estimates on {record.provenance.source}, {len(record)} samples:"
    repaired = ("repaired", record_facts(record, wording)["repaired"])
    return Heading(facts=(repaired,), title=title), validation_table(validation, wording)


def fit_validation_document(
    validation: FitValidation, *, wording: Wording = as_arguments
) -> Document:
    """What a frozen fit leaves of a record, and whether it holds."""
    record, unit = validation.record, validation.unit
    left = f"{validation.error:.4g} {unit}".rstrip() + f", {validation.percent:.3g} % of it"
    title = f"Frozen fit on {record.provenance.source}, {len(record)} samples:"
    facts = ((validation.output, f"leaves {left}"),)
    return Heading(facts=facts, title=title), verdict_block(validation.checks, wording)


def validation_table(validation: Validation, wording: Wording) -> Table:
    """The errors by method."""
    return Table(
        columns=text_columns(["validation", "unit", *(v.method.upper() for v in validation)]),
        rows=tuple((*name, *map(_cell, figures)) for name, figures in validation.errors.items()),
        labels=2,
        said=tuple(note.worded(wording) for note in validation.notes),
    )


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
