"""Blocks as lines and text tables, and as plain text for pipes and files."""

import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from types import MappingProxyType

from .document import (
    Align,
    Block,
    Cell,
    CheckGroup,
    Checks,
    Document,
    Heading,
    Listing,
    Notes,
    Paragraph,
    QuantityCell,
    Sentence,
    TableBlock,
    TableColumn,
)

PAGE_WIDTH = 96  # characters
_TABLE_WIDTH = 100  # characters of a table; a wider one is split
COLUMN_GAP = 2  # blanks between columns
_FACT_WIDTH = 11  # of the names in a heading
#: Start of a line about checks.
_STATUS_HEADS = MappingProxyType(
    {"fail": "FAIL   ", "note": "note   ", "not evaluated": "-      ", "pass": "pass   "}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A table of texts.

    Attributes
    ----------
    heads : tuple of str
    rows : tuple of tuple of str
    aligns : tuple of Align
        Alignment of each column.
    groups : tuple of tuple of int
        Indices of all columns, in groups that stay together if the table is split.
    labels : int
        Number of groups, from the first, that label the rows and are repeated in a split table.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    aligns: tuple[Align, ...]
    groups: tuple[tuple[int, ...], ...]
    labels: int

    def pages(self, room: int, size: Callable[[str], int] = len) -> "list[Grid]":
        """Return the table, split into several tables if it is wider than `room`.

        Each table has the label columns, and a group stays in one table if it fits.

        Parameters
        ----------
        room : int
            Largest width of a table, in characters.
        size : callable
            Width of a text, in characters.
        """
        labels = [i for group in self.groups[: self.labels] for i in group]
        sizes = [max(map(size, each)) for each in zip(self.heads, *self.rows, strict=True)]

        def fits(numbers: Sequence[int]) -> bool:
            wide = [sizes[i] for i in (*labels, *numbers)]
            return sum(wide) + COLUMN_GAP * (len(wide) - 1) <= room

        pages: list[list[int]] = []
        for group in self.groups[self.labels :]:
            for part in _parts(group, fits):
                if pages and fits([*pages[-1], *part]):
                    pages[-1] += part
                else:
                    pages.append([*part])
        return [self.part([*labels, *page]) for page in pages] or [self]

    def part(self, numbers: Sequence[int]) -> "Grid":
        """Return the table of the columns with the given indices, each in its own group."""
        return Grid(
            heads=tuple(self.heads[i] for i in numbers),
            rows=tuple(tuple(row[i] for i in numbers) for row in self.rows),
            aligns=tuple(self.aligns[i] for i in numbers),
            groups=tuple((i,) for i in range(len(numbers))),
            labels=self.labels,
        )


def _parts(group: Sequence[int], fits: Callable[[Sequence[int]], bool]) -> list[list[int]]:
    """Return the columns of a group in parts that fit on a page, each with the first column.

    A group that fits is one part. A column that does not fit next to the first is alone.

    Parameters
    ----------
    group : sequence of int
        Indices of the columns.
    fits : callable
        True if the columns with the given indices fit on a page.
    """
    first, *others = group
    parts = [[first]]
    for number in others:
        if fits([*parts[-1], number]):
            parts[-1].append(number)
        else:
            parts.append([first, number] if fits([first, number]) else [number])
    return parts


def grid(table: TableBlock) -> Grid:
    """Return a table as texts; a column with parts becomes several columns, in one group."""
    # Drawn intervals have no text.
    kept = [i for i, column in enumerate(table.columns) if column.kind != "intervals"]
    heads: list[str] = []
    columns: list[TableColumn] = []  # of each column of texts
    for column in (table.columns[i] for i in kept):
        heads.append(f"{column.head} [{column.unit}]" if column.unit else column.head)
        heads += column.parts
        columns += [column] * (1 + len(column.parts))
    # Neighbours with the same group, or of the same column, stay together.
    groups = groupby(range(len(columns)), lambda i: columns[i].group or id(columns[i]))
    return Grid(
        heads=tuple(heads),
        rows=tuple(
            tuple(text for i in kept for text in _texts(row[i], table.columns[i]))
            for row in table.rows
        ),
        aligns=tuple(column.align for column in columns),
        groups=tuple(tuple(numbers) for _, numbers in groups),
        labels=table.labels,
    )


def _texts(cell: Cell, column: TableColumn) -> tuple[str, ...]:
    """Return the texts of a cell: its value, and one text for each part of the column.

    Missing parts are empty.
    """
    texts: tuple[str, ...] = (joined(cell),)
    if isinstance(cell, QuantityCell) and column.parts:
        texts = (cell.value, cell.deviation, *cell.more)
    missing = 1 + len(column.parts) - len(texts)
    return (*texts, *[""] * missing)


def joined(cell: Cell) -> str:
    """Return a cell as one text: ``1.5 +- 0.2`` for a quantity, empty for drawn intervals."""
    if isinstance(cell, QuantityCell):
        return f"{cell.value} +- {cell.deviation}" if cell.deviation else cell.value
    return cell if isinstance(cell, str) else ""


def block_lines(block: Block) -> Iterator[Sentence | Grid]:
    """Yield the lines of a block, the title first; a table is one item."""
    if title := getattr(block, "title", ""):
        yield Sentence(text=title)
    match block:
        case Heading():
            yield from (_fact(name, text) for name, text in block.facts.items() if text)
        case TableBlock():
            yield grid(block)
            yield from (Sentence(text=said) for said in block.said)
        case Checks():
            if block.conclusion:
                yield _fact("verdict", block.conclusion)
                yield Sentence(text="")
            yield from map(_judged, block.judged)
        case Notes():
            labelled = [*block.labelled()]
            width = max((len(label) for label, _ in labelled), default=0) + 1
            for label, note in labelled:
                yield Sentence(lead=label.ljust(width), text=note, hang=width, kind="line")
        case Paragraph():
            yield from block.sentences
        case Listing():
            yield from (Sentence(lead="  ", text=line, hang=6, kind="line") for line in block.lines)


def _fact(name: str, text: str) -> Sentence:
    """Return the line of a named fact: the name in a column, then the text."""
    return Sentence(lead=f"{name:<{_FACT_WIDTH}}", text=text, hang=_FACT_WIDTH, kind="line")


def _judged(judged: CheckGroup) -> Sentence:
    """Return the line of a group of checks; names of failed checks are highlighted."""
    head, names = _STATUS_HEADS[judged.status], ", ".join(judged.names)
    lead, text = head, names
    if judged.meaning:
        meaning = f" {judged.statement}."
        if judged.status == "fail":  # the lead is highlighted
            lead, text = f"{head}{names}:", meaning
        else:
            text = f"{names}:{meaning}"
    return Sentence(lead=lead, text=text, hang=len(head), kind=judged.status)


def plain_text(document: Document) -> str:
    """Return the blocks of a document as plain text, with a blank line between them."""
    blocks = ("\n".join(map(_text, block_lines(block))) for block in document)
    return "\n\n".join(filter(None, blocks)) + "\n"


def _text(line: Sentence | Grid) -> str:
    """Return a line wrapped at the page width, or a table; long words, such as paths, stay whole.

    A table that is too wide is split.
    """
    if isinstance(line, Grid):
        return "\n\n".join(map(_table, line.pages(_TABLE_WIDTH)))
    if not line.filled:
        return f"{line.lead}{line.text}"
    return textwrap.fill(
        line.text,
        PAGE_WIDTH,
        initial_indent=line.lead,
        subsequent_indent=" " * line.hang,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _table(texts: Grid) -> str:
    """Return a table as text, with aligned columns and a rule below the heads."""
    rows = [texts.heads, *texts.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(texts.heads))]
    rule = "-" * (sum(widths) + COLUMN_GAP * (len(widths) - 1))
    lines = []
    for row in rows:
        cells = [
            text.ljust(width) if align == "left" else text.rjust(width)
            for text, width, align in zip(row, widths, texts.aligns, strict=True)
        ]
        lines.append((" " * COLUMN_GAP).join(cells).rstrip())
    head, *others = lines
    return "\n".join([head, rule, *others])
