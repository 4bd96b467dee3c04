"""Estimates held against another record, as text."""

from axisid.estimation.studies import Validation

from .record import record_lines
from .tables import heading_text, text_table


def validation_text(validation: Validation) -> str:
    """The errors as a table of text."""
    record = validation.record
    header = ["validation", "unit", *(v.method.upper() for v in validation)]
    rows = [[*name, *map(_cell, figures)] for name, figures in validation.errors.items()]
    lines = [
        f"Frozen estimates on {record.provenance.source}, {len(record)} samples:",
        *filter(None, [heading_text({"repaired": record_lines(record)["repaired"]})]),
        "",
        text_table(header, rows),
        *validation.notes,
    ]
    return "\n".join(lines) + "\n"


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
