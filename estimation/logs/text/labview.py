"""LabVIEW measurement files (`.lvm`) as a plain table: a header with units, and rows of its width.

Two heads, each closed by ``***End_of_Header***``, stand above the names of the columns. The last
name is ``Comment``, a column that rows may leave out or fill.
"""

from collections.abc import Sequence

from axisid.support.errors import DataError

from .dialect import Line

_BEGIN = "LabVIEW Measurement"
_END = "***End_of_Header***"
_UNITS = "Y_Unit_Label"
_COMMENT = "Comment"
_HEAD = 200  # lines in which the heads are looked for
_SEPARATORS = {"Tab": "\t", "Comma": ",", "Semicolon": ";"}


def is_labview(lines: Sequence[Line]) -> bool:
    """Whether filled lines begin as a LabVIEW measurement file does."""
    return bool(lines) and lines[0][1].startswith(_BEGIN)


def plain_lines(source: str, lines: Sequence[Line]) -> tuple[list[Line], tuple[str, ...]]:
    """The table of a LabVIEW measurement file without its heads, and what was assumed.

    Raises
    ------
    DataError
        Its heads have no end, or no names of columns follow.
    """
    ends = [k for k, (_, line) in enumerate(lines[:_HEAD]) if line.startswith(_END)]
    if not ends or ends[-1] + 1 >= len(lines):
        raise DataError(
            f"{source}: the LabVIEW measurement file has no samples below its heads, which "
            f"{_END} closes.",
            code="labview-without-samples",
        )
    head = [line for _, line in lines[: ends[-1]]]
    separator = _separator(head)
    number, line = lines[ends[-1] + 1]
    names = _cells(line, separator)
    labels = next((_cells(x, separator) for x in head if x.startswith(_UNITS)), [])
    units = ["", *labels[1:], *[""] * len(names)]
    body = lines[ends[-1] + 2 :]
    notes = ["LabVIEW measurement file, its heads passed over"]
    if names[-1] == _COMMENT:
        names = names[:-1]
        body, comments = _without_comments(body, separator, len(names))
        notes += [f"comments passed over: {comments}"] if comments else []
    named = [f"{n} [{u}]" if u else n for n, u in zip(names, units, strict=False)]
    return [(number, separator.join(named)), *body], tuple(notes)


def _separator(head: Sequence[str]) -> str:
    """What separates the columns, as the first head says."""
    for line in head:
        for name, separator in _SEPARATORS.items():
            if line.rstrip(f"{separator}\r\n") == f"Separator{separator}{name}":
                return separator
    return "\t"


def _cells(line: str, separator: str) -> list[str]:
    cells = [cell.strip() for cell in line.rstrip("\r\n").split(separator)]
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _without_comments(body: Sequence[Line], separator: str, width: int) -> tuple[list[Line], int]:
    """Lines without the cell after the last column, and how many had one."""
    lines, comments = [], 0
    for number, line in body:
        cells = line.split(separator)
        comments += len(cells) == width + 1 and bool(cells[-1].strip())
        kept = cells[:-1] if len(cells) == width + 1 else cells
        lines.append((number, separator.join(kept)))
    return lines, comments
