"""Tables, headings and wrapped sentences of plain text."""

import textwrap
from collections.abc import Iterable, Mapping, Sequence

Row = Sequence[str]
_WIDTH = 96


def text_table(header: Row, rows: Iterable[Row]) -> str:
    """Align columns: the first to the left, the others to the right."""
    lines = [list(header), *map(list, rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]

    def text(line: Row) -> str:
        cells = [line[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(line[1:], widths[1:], strict=True)]
        return "  ".join(cells).rstrip()

    rule = "-" * (sum(widths) + 2 * (len(widths) - 1))
    return "\n".join([text(lines[0]), rule, *map(text, lines[1:])])


def heading_text(lines: Mapping[str, str]) -> str:
    """Named lines under one another, without those that say nothing."""
    return "\n".join(
        textwrap.fill(
            text,
            _WIDTH,
            initial_indent=f"{name:<11}",
            subsequent_indent=" " * 11,
            break_on_hyphens=False,
            break_long_words=False,
        )
        for name, text in lines.items()
        if text
    )


def wrapped(head: str, text: str, hang: int | None = None) -> str:
    """A text as wide as a page, hanging from its head, or by so many blanks."""
    return textwrap.fill(
        text,
        _WIDTH,
        initial_indent=head,
        subsequent_indent=" " * (len(head) if hang is None else hang),
        break_on_hyphens=False,
    )


def numbered(number: int, note: str) -> str:
    """A note of a table."""
    return wrapped(f"[{number}] ", note)
