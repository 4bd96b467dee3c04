"""Blocks drawn by rich: headers bold, checks in colours, tables broken between methods."""

from collections.abc import Callable, Iterator, Sequence
from functools import singledispatch
from types import MappingProxyType
from typing import TextIO

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from axisid.presentation.blocks import (
    FACT_WIDTH,
    PAGE_WIDTH,
    STATUS_HEADS,
    Block,
    CheckGroup,
    Checks,
    Document,
    Grid,
    Heading,
    Listing,
    Notes,
    Paragraph,
    Sentence,
    Table,
    grid,
)

_GAP = 2  # blanks between columns
_LEAST = 20  # columns; what is narrower is left to the terminal
_HANG = 4  # blanks before what is left of a line that a terminal is too narrow for
_HEAD_STYLES = MappingProxyType({"fail": "bold red", "pass": "green"})
_LINE_STYLES = MappingProxyType({"note": "dim", "not evaluated": "dim"})
_BLANKS = str.maketrans("\t\n\v\f\r", "     ")


def print_dressed(document: Document, stream: TextIO, width: int, *, coloured: bool) -> None:
    """Print a document on a terminal of so many columns."""
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
    drawn = [lines for block in document if (lines := list(block_lines(block, console)))]
    for i, lines in enumerate(drawn):
        if i:
            console.print()
        for line in lines:
            console.print(line)


@singledispatch
def block_lines(block: Block, console: Console) -> Iterator[Text]:
    """One block, line by line, each within the terminal's width."""
    del console
    raise TypeError(f"{type(block).__name__} is no block")


@block_lines.register
def _(block: Heading, console: Console) -> Iterator[Text]:
    yield from _titled(block.title, console)
    for name, text in block.facts:
        if text:
            yield from _hanging(_text(f"{name:<{FACT_WIDTH}}{text}"), FACT_WIDTH, console)


@block_lines.register
def _(block: Table, console: Console) -> Iterator[Text]:
    yield from _titled(block.title, console)
    for i, page in enumerate(_pages(grid(block), console.width)):
        if i:
            yield Text()
        yield from _grid_lines(page, console)
    for said in block.said:
        yield from _hanging(_text(said), _HANG, console, most=console.width)


@block_lines.register
def _(block: Checks, console: Console) -> Iterator[Text]:
    if block.conclusion:
        concluded = _text(f"{'verdict':<{FACT_WIDTH}}{block.conclusion}")
        yield from _hanging(concluded, FACT_WIDTH, console)
        yield Text()
    for judged in block.judged:
        yield from _hanging(_judged(judged), len(STATUS_HEADS[judged.status]), console)


def _judged(judged: CheckGroup) -> Text:
    """What failed stands out by name, what passed by its head alone; the rest steps back."""
    head = STATUS_HEADS[judged.status]
    text = _text(f"{head}{judged.text}")
    failed = f"{head}{', '.join(judged.names)}:" if judged.status == "fail" else head
    text.stylize(_HEAD_STYLES.get(judged.status, ""), 0, len(failed))
    text.stylize(_LINE_STYLES.get(judged.status, ""))
    return text


@block_lines.register
def _(block: Notes, console: Console) -> Iterator[Text]:
    for i, note in enumerate(block.notes, 1):
        head = f"[{i}] "
        yield from _hanging(_text(f"{head}{note}"), len(head), console)


@block_lines.register
def _(block: Paragraph, console: Console) -> Iterator[Text]:
    yield from _titled(block.title, console)
    for sentence in block.sentences:
        yield from _sentence_lines(sentence, console)


def _sentence_lines(sentence: Sentence, console: Console) -> Iterator[Text]:
    text = _text(f"{sentence.lead}{sentence.text}")
    text.stylize("bold", 0, len(sentence.lead.rstrip()))
    if sentence.filled:
        yield from _hanging(text, sentence.hang, console)
    else:
        yield from _hanging(text, _HANG, console, most=console.width)


@block_lines.register
def _(block: Listing, console: Console) -> Iterator[Text]:
    yield from _titled(block.title, console)
    for line in block.lines:
        yield from _hanging(_text(f"  {line}"), 6, console)


def _titled(title: str, console: Console) -> Iterator[Text]:
    if title:
        yield from _hanging(_text(title), _HANG, console, most=console.width)


def _text(text: str) -> Text:
    return Text(text.translate(_BLANKS))


def _hanging(text: Text, hang: int, console: Console, most: int = PAGE_WIDTH) -> Iterator[Text]:
    """A text in lines as wide as a page or the terminal, all but the first so many blanks in."""
    width = min(console.width, most)
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


def _pages(whole: Grid, room: int) -> list[Grid]:
    """One table or several, each with the labels; what a column tells stays beside its value."""
    labels = [i for group in whole.groups[: whole.labels] for i in group]
    sizes = [max(map(cell_len, column)) for column in _columns(whole)]

    def fits(numbers: Sequence[int]) -> bool:
        wide = [sizes[i] for i in (*labels, *numbers)]
        return sum(wide) + _GAP * (len(wide) - 1) <= room

    pages: list[list[int]] = []
    for group in whole.groups[whole.labels :]:
        for part in _parts(group, fits):
            if pages and fits([*pages[-1], *part]):
                pages[-1] += part
            else:
                pages.append([*part])
    return [whole.part([*labels, *page]) for page in pages]


def _parts(group: Sequence[int], fits: Callable[[Sequence[int]], bool]) -> list[list[int]]:
    """Neighbours together, or the first of them beside as many of the others as it has room for."""
    first, *others = group
    parts = [[first]]
    for number in others:
        if fits([*parts[-1], number]):
            parts[-1].append(number)
        else:
            parts.append([first, number] if fits([first, number]) else [number])
    return parts


def _columns(whole: Grid) -> Iterator[tuple[str, ...]]:
    yield from zip(whole.heads, *whole.rows, strict=True)


def _grid_lines(page: Grid, console: Console) -> Iterator[Text]:
    widths = _widths(page, console.width - _GAP * (len(page.heads) - 1))
    for line in _row_lines(page.heads, page, widths, console, low=True):
        line.stylize("bold")
        yield line
    yield Text("-" * (sum(widths) + _GAP * (len(widths) - 1)))
    for row in page.rows:
        yield from _row_lines(row, page, widths, console)


def _row_lines(
    row: Sequence[str], page: Grid, widths: Sequence[int], console: Console, *, low: bool = False
) -> Iterator[Text]:
    """One row, each text folded into its column, the shorter ones at the top or low."""
    cells = [Text(text).wrap(console, width) for text, width in zip(row, widths, strict=True)]
    most = max(map(len, cells))
    for i in range(most):
        parts = []
        for lines, width, align in zip(cells, widths, page.aligns, strict=True):
            at = i - (most - len(lines)) if low else i
            part = lines[at] if 0 <= at < len(lines) else Text()
            part.rstrip()
            part.align(align, width)
            parts.append(part)
        line = Text(" " * _GAP).join(parts)
        line.rstrip()
        yield line


def _widths(page: Grid, room: int) -> list[int]:
    """As wide as their texts, or narrower by the widest that has blanks to break at."""
    columns = [*_columns(page)]
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
