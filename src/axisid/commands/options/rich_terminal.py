"""Documents on a terminal, drawn by rich: bold headers, coloured checks, tables that fit the width.

A table that is too wide is divided into several tables between methods.
"""

from collections.abc import Iterator
from types import MappingProxyType
from typing import TextIO

from rich.box import Box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from axisid.presentation.documents import (
    COLUMN_GAP,
    PAGE_WIDTH,
    Block,
    Document,
    Grid,
    Sentence,
    block_lines,
)

_LEAST = 20  # characters; on a narrower terminal, lines wrap
#: By kind of line: style of its lead (the first word), and style of the whole line.
_STYLES = MappingProxyType(
    {
        "lead": ("bold", ""),
        "fail": ("bold red", ""),
        "pass": ("green", ""),
        "note": ("", "dim"),
        "not evaluated": ("", "dim"),
    }
)
#: Frame of a table: blanks between columns, and a rule below the heads.
_RULED = Box("    \n    \n----\n    \n    \n    \n    \n    \n", ascii=True)
_BLANKS = str.maketrans("\t\n\v\f\r", "     ")


def print_dressed(document: Document, stream: TextIO, width: int, *, coloured: bool) -> None:
    """Print a document on a terminal that is `width` characters wide."""
    console = Console(
        file=stream,
        width=max(width, _LEAST),
        color_system="standard" if coloured else None,
        no_color=False,
        force_terminal=True,
        highlight=False,
        markup=False,
        emoji=False,
    )
    drawn = [[*_drawn(block, console)] for block in document]
    for i, lines in enumerate(filter(None, drawn)):
        if i:
            console.print()
        for line in lines:
            console.print(line, soft_wrap=True)  # only lines to be copied may be longer


def _drawn(block: Block, console: Console) -> Iterator[Text]:
    """Yield one block line by line, within the terminal's width except lines to be copied."""
    for line in block_lines(block):
        if isinstance(line, Sentence):
            text = _dressed(line)
            yield from _hanging(text, line.hang, console) if line.filled else [text]
        else:
            for i, page in enumerate(line.pages(console.width, cell_len)):
                if i:
                    yield Text()
                yield from _grid_lines(page, console)


def _dressed(line: Sentence) -> Text:
    """Return a line as text with the styles of its kind."""
    first, whole = _STYLES.get(line.kind, ("", ""))
    text = Text(f"{line.lead}{line.text}".translate(_BLANKS), style=whole)
    text.stylize(first, 0, len(line.lead))
    return text


def _hanging(text: Text, hang: int, console: Console) -> Iterator[Text]:
    """Yield the lines of a text, wrapped at the width of a page or the terminal.

    Lines after the first are indented by `hang` characters.
    """
    width = min(console.width, PAGE_WIDTH)
    first = text.wrap(console, width)[0]
    rest = text[len(first) :]
    first.rstrip()
    yield first
    rest = rest[len(rest.plain) - len(rest.plain.lstrip()) :]
    if rest.plain:
        hang = min(hang, width // 2)
        for line in rest.wrap(console, width - hang):
            line.rstrip()
            yield Text(" " * hang) + line


def _grid_lines(page: Grid, console: Console) -> Iterator[Text]:
    """Yield heads, a rule and rows, each text folded into its column."""
    drawn = Table(
        box=_RULED, show_edge=False, pad_edge=False, padding=(0, COLUMN_GAP - 1, 0, 0), expand=False
    )
    widths = _widths(page, console.width - COLUMN_GAP * (len(page.heads) - 1))
    for head, align, width in zip(page.heads, page.aligns, widths, strict=True):
        drawn.add_column(Text(head), justify=align, width=width, header_style="bold")
    for row in page.rows:
        drawn.add_row(*map(Text, row))
    for segments in console.render_lines(drawn, pad=False):
        line = Text.assemble(*((each.text, each.style or "") for each in segments))
        line.rstrip()
        yield line


def _widths(page: Grid, room: int) -> list[int]:
    """Return the widths of the columns, reduced from the widths of their texts to fit into `room`.

    Columns that can wrap between words are reduced first, always the widest. If no such column is
    left, words are broken.
    """
    columns = [*zip(page.heads, *page.rows, strict=True)]
    widths = [max(map(cell_len, column)) for column in columns]
    words = [
        max(cell_len(word) for text in column for word in [*text.split(), ""]) for column in columns
    ]
    while sum(widths) > room:
        loose = [i for i, width in enumerate(widths) if width > words[i]]
        loose = loose or [i for i, width in enumerate(widths) if width > 1]
        if not loose:
            break
        widths[max(loose, key=widths.__getitem__)] -= 1
    return widths
