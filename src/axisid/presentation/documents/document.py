"""The blocks of a document, independent of the output format, and the notation of numbers.

Values are rounded to two digits of their standard error. Text for print (`readable_text`) has
raised powers, true minus signs, and no ``e``.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from axisid.support.wording import plain_numbers

_MINUS, _TIMES, _THIN = "\u2212", "\u00d7", "\u202f"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = (1e-3, 1e6)  # numbers between these have no power of ten
_GROUPED = 1e4  # smallest number with separated thousands
# Sign, figures and exponent of a number; not of one that is part of a word, a name or a formula.
_NUMBER = re.compile(r"(?<![\w.^*/)+-])([+-]?)(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w^*]|\.\w)")

Align = Literal["left", "right"]
Status = Literal["fail", "note", "not evaluated", "pass"]


@dataclass(frozen=True, slots=True)
class QuantityCell:
    """A value with its standard error, as rounded text.

    Attributes
    ----------
    value : str
    deviation : str
        Standard error; empty if there is none.
    more : tuple of str
        Further texts, whose heads are the `parts` of the column after the first.
    """

    value: str
    deviation: str
    more: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Interval:
    """A confidence interval to be drawn.

    Attributes
    ----------
    low, centre, high : float
        Lower end, estimate and upper end.
    kind : str
        Kind of the estimator, for its colour: ``ls``, ``iv`` or ``didim``.
    """

    low: float
    centre: float
    high: float
    kind: str


@dataclass(frozen=True, slots=True)
class Intervals:
    """Intervals drawn on one scale; plain text omits them.

    Attributes
    ----------
    intervals : tuple of Interval
    truth : float, optional
        True value of a simulated record.
    """

    intervals: tuple[Interval, ...]
    truth: float | None = None


Cell = str | QuantityCell | Intervals
#: Content of a column, for pages that format it.
Kind = Literal["", "unit", "status", "method", "intervals"]


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of a table.

    Attributes
    ----------
    head : str
    unit : str
        Unit of all its cells.
    align : {"right", "left"}
    parts : tuple of str
        Heads of the separate columns for the standard error and the further texts of a
        `QuantityCell`. If it is empty, value and standard error are one text.
    group : str
        Neighbouring columns with the same group stay together if a table is split; empty for none.
    kind : Kind
        Content of the column.
    """

    head: str
    unit: str = ""
    align: Align = "right"
    parts: tuple[str, ...] = ()
    group: str = ""
    kind: Kind = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableBlock:
    """A table of cells.

    Attributes
    ----------
    columns : tuple of TableColumn
    rows : tuple of tuple of Cell
    labels : int
        Number of leading columns that label a row; they are repeated if a table is split.
    title : str
        Title above the table.
    said : tuple of str
        Sentences below the table.
    """

    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]
    labels: int = 1
    title: str = ""
    said: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    """Named facts, one per line; a fact without text is omitted.

    Attributes
    ----------
    facts : mapping of str to str
        Text by name.
    title : str
        Title above the facts.
    """

    facts: Mapping[str, str]
    title: str = ""


@dataclass(frozen=True, slots=True)
class CheckGroup:
    """Checks with one outcome.

    Attributes
    ----------
    status : Status
    names : tuple of str
    meaning : str
        Sentence; empty for passed checks.
    """

    status: Status
    names: tuple[str, ...]
    meaning: str = ""

    @property
    def statement(self) -> str:
        """Return the meaning without a full stop; checks that were not evaluated say so first."""
        text = self.meaning.removesuffix(".")
        if self.status != "not evaluated":
            return text
        # The name of a file keeps its first letter.
        word = text.split(maxsplit=1)[0] if text.strip() else ""
        start = text[:1].upper() if word.isalpha() else text[:1]
        return f"not evaluated. {start}{text[1:]}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Checks:
    """Checks, the most severe first.

    Attributes
    ----------
    judged : tuple of CheckGroup
    conclusion : str
        Headline of the verdict; empty if there is none.
    """

    judged: tuple[CheckGroup, ...]
    conclusion: str = ""


@dataclass(frozen=True, slots=True)
class Notes:
    """Notes below tables; tables refer to the first of them by number, from 1.

    Attributes
    ----------
    notes : tuple of str
    numbered : int or None
        Number of notes, from the first, that have a number; None for all.
    """

    notes: tuple[str, ...]
    numbered: int | None = None

    def labelled(self) -> Iterator[tuple[str, str]]:
        """Yield each note after its label: ``[1]``, or a dash for a note without a number."""
        for i, note in enumerate(self.notes, 1):
            has_number = self.numbered is None or i <= self.numbered
            yield f"[{i}]" if has_number else "-", note


@dataclass(frozen=True, slots=True, kw_only=True)
class Sentence:
    """One or more sentences, or a line of another block.

    Attributes
    ----------
    text : str
    lead : str
        Words before the text.
    hang : int
        Number of blanks before the second and further lines.
    filled : bool
        True if the text is wrapped at the width of the page or terminal; False for text to copy.
    kind : str
        For colours: ``lead`` if the lead is highlighted, ``line`` for none, or a `Status`.
    """

    text: str
    lead: str = ""
    hang: int = 0
    filled: bool = True
    kind: str = "lead"


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """Sentences, each on its own line, with an optional title."""

    sentences: tuple[Sentence, ...]
    title: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Formulas and facts under a title."""

    title: str
    lines: tuple[str, ...]


Block = Heading | TableBlock | Checks | Notes | Paragraph | Listing
Document = tuple[Block, ...]


def text_columns(heads: Iterable[str]) -> tuple[TableColumn, ...]:
    """Return columns with the given heads: the first aligned left, the others right."""
    kinds: dict[str, Kind] = {"unit": "unit", "status": "status"}
    return tuple(
        TableColumn(head, align="right" if i else "left", kind=kinds.get(head, ""))
        for i, head in enumerate(heads)
    )


def without_empty_last_column(table: TableBlock) -> TableBlock:
    """Return a table without its last column if this column is empty in every row."""
    if any(row[-1] for row in table.rows):
        return table
    rows = tuple(row[:-1] for row in table.rows)
    return replace(table, columns=table.columns[:-1], rows=rows)


def text_table(
    heads: Iterable[str],
    rows: Iterable[Sequence[Cell]],
    *,
    labels: int = 1,
    title: str = "",
    said: tuple[str, ...] = (),
) -> TableBlock:
    """Return a table whose columns are given by their heads.

    Parameters
    ----------
    heads : iterable of str
        Heads of the columns; the first is aligned left, the others right.
    rows : iterable of sequence of Cell
    labels, title, said
        As in `TableBlock`.
    """
    return TableBlock(
        columns=text_columns(heads),
        rows=tuple(map(tuple, rows)),
        labels=labels,
        title=title,
        said=said,
    )


def paragraph(*sentences: str | Sentence, title: str = "") -> Paragraph:
    """Return a paragraph of sentences or texts; texts get numbers that are written out."""
    return Paragraph(
        sentences=tuple(
            Sentence(text=plain_numbers(each)) if isinstance(each, str) else each
            for each in sentences
        ),
        title=title,
    )


def readable_unit(unit: str) -> str:
    """Return a unit with raised powers: ``m/s²``."""
    return re.sub(r"(?:\^|\*\*)(-?\d+)", lambda m: m[1].translate(_RAISED), unit)


def readable_text(text: str) -> str:
    """Return a sentence in print notation: ``±``, raised powers, and 10⁻⁶ instead of ``e-06``."""
    numbered = _NUMBER.sub(_number, text.replace(" +-", " ±"))
    return re.sub(r"(?<=[^\W\d_])\^(-?\d+)(?![\w.])", lambda m: m[1].translate(_RAISED), numbered)


def decimals(deviation: float, digits: int = 2, least: int = 0) -> int:
    """Return the number of decimal places that shows a standard error with `digits` digits.

    It is at least `least` and at most 12. Without a finite, positive standard error it is 4.
    """
    if not 0 < deviation < math.inf:
        return 4
    return min(max(least, digits - 1 - math.floor(math.log10(deviation))), 12)


def figure_text(value: float, digits: int = 3) -> str:
    """Return a number rounded to `digits` digits, without exponent below 1e6."""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < _PLAIN[1] else text


def _number(found: re.Match[str]) -> str:
    """Return a number that was found in a sentence in print notation."""
    sign, figures, exponent = found.groups()
    sign = sign.replace("-", _MINUS)
    if exponent is None:
        return sign + figures
    value = float(f"{figures}e{exponent}")
    if value and not _PLAIN[0] <= value < _PLAIN[1]:
        return f"{sign}{figures} {_TIMES} 10{str(int(exponent)).translate(_RAISED)}"
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    plain = f"{value:,.{places}f}" if value >= _GROUPED else f"{value:.{places}f}"
    return sign + plain.replace(",", _THIN)
