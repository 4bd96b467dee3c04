"""Estimates held against another record, as a document."""

from axisid.estimation.studies import Validation
from axisid.presentation.blocks import Document, Heading, Table, text_columns

from .record import record_facts


def validation_document(validation: Validation) -> Document:
    """What was repaired of the record, and the errors."""
    record = validation.record
    title = f"Frozen estimates on {record.provenance.source}, {len(record)} samples:"
    repaired = ("repaired", record_facts(record)["repaired"])
    return Heading(facts=(repaired,), title=title), validation_table(validation)


def validation_table(validation: Validation) -> Table:
    """The errors by method."""
    return Table(
        columns=text_columns(["validation", "unit", *(v.method.upper() for v in validation)]),
        rows=tuple((*name, *map(_cell, figures)) for name, figures in validation.errors.items()),
        labels=2,
        said=tuple(validation.notes),
    )


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
