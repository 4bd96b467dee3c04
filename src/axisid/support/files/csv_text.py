"""Tables as CSV, in which text stays text."""

import csv
import io
from collections.abc import Iterable

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Rows as CSV; None is an empty cell.

    A text that a spreadsheet would run as a formula gets an apostrophe before it, by which
    spreadsheets know text: serials and names of logs are anybody's.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_as_text, row) for row in rows)
    return text.getvalue()


def _as_text(cell: object) -> object:
    if not isinstance(cell, str):
        return cell
    begins_one = cell.startswith(_FORMULA) and not _is_number(cell)
    # The writer quotes no carriage return, at which readers begin a row.
    return "'" * begins_one + cell.replace("\r", "\n")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
