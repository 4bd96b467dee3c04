"""A table as texts in rows and columns, which plain text and a terminal lay out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from .document import Align, Cell, Column, NotedText, Quantity, Table


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """Texts in rows and columns.

    Attributes
    ----------
    heads : tuple of str
    rows : tuple of tuple of str
    aligns : tuple of Align
    groups : tuple of tuple of int
        Numbers of the columns that belong together.
    labels : int
        How many of the groups label the rows.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    aligns: tuple[Align, ...]
    groups: tuple[tuple[int, ...], ...]
    labels: int

    def part(self, numbers: Sequence[int]) -> "Grid":
        """Some of the columns, each a group of its own."""
        return Grid(
            heads=tuple(self.heads[i] for i in numbers),
            rows=tuple(tuple(row[i] for i in numbers) for row in self.rows),
            aligns=tuple(self.aligns[i] for i in numbers),
            groups=tuple((i,) for i in range(len(numbers))),
            labels=self.labels,
        )


def grid(table: Table) -> Grid:
    """The texts of a table; a column with parts becomes as many columns."""
    columns = [column for column in table.columns for _ in range(1 + len(column.parts))]
    return Grid(
        heads=tuple(head for column in table.columns for head in _heads(column)),
        rows=tuple(
            tuple(
                text
                for cell, column in zip(row, table.columns, strict=True)
                for text in _texts(cell, column)
            )
            for row in table.rows
        ),
        aligns=tuple(column.align for column in columns),
        groups=tuple(_groups(columns)),
        labels=table.labels,
    )


def _groups(columns: Sequence[Column]) -> Iterator[tuple[int, ...]]:
    """Numbers of neighbours that are of one column, or of one group."""

    def key(number: int) -> str | int:
        return columns[number].group or id(columns[number])

    for _, numbers in groupby(range(len(columns)), key):
        yield tuple(numbers)


def _heads(column: Column) -> Iterator[str]:
    yield f"{column.head} [{column.unit}]" if column.unit else column.head
    yield from column.parts


def _texts(cell: Cell, column: Column) -> Iterator[str]:
    """One text for the value and one for each part; what is not told stays empty."""
    texts: tuple[str, ...] = (joined(cell),)
    if isinstance(cell, Quantity) and column.parts:
        texts = (cell.value, cell.deviation, *cell.more)
    yield from texts
    yield from ("",) * (1 + len(column.parts) - len(texts))


def joined(cell: Cell) -> str:
    """A cell as one text."""
    match cell:
        case str():
            return cell
        case Quantity():
            return f"{cell.value} +- {cell.deviation}" if cell.deviation else cell.value
        case NotedText():
            text = f"{cell.text} [{cell.unit}]" if cell.unit else cell.text
            return f"{text} ({cell.note})" if cell.note else text
        case _:
            return ""
