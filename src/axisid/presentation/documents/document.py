"""The blocks of a document: what is shown of a result, before it is known where.

Numbers in them are as many digits as a deviation warrants. As text that is printed they have powers
raised, true minus signs, and no ``e``.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from axisid.support.errors import plain_numbers

_MINUS, _TIMES, _THIN = "\u2212", "\u00d7", "\u202f"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = (1e-3, 1e6)  # between them numbers have no power of ten
_GROUPED = 1e4  # from which thousands stand apart
# A sign or a figure that is part of a word, a name or a formula stays as it is.
_NUMBER = re.compile(r"(?<![\w.^*/)+-])([+-]?)(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w^*]|\.\w)")

Align = Literal["left", "right"]
Status = Literal["fail", "note", "not evaluated", "pass"]


@dataclass(frozen=True, slots=True)
class QuantityCell:
    """A value with its deviation, digits as they warrant.

    Attributes
    ----------
    value : str
    deviation : str
        Empty where there is none.
    more : tuple of str
        What else a table with room tells of it, as its column's `parts` say.
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
    kind : str
        Of the estimator, as figures tell them apart: ``ls``, ``iv`` or ``didim``.
    """

    low: float
    centre: float
    high: float
    kind: str


@dataclass(frozen=True, slots=True)
class Intervals:
    """Intervals on one scale, where there is room to draw; text says nothing of them.

    Attributes
    ----------
    intervals : tuple of Interval
    truth : float, optional
        True value of a simulated record.
    """

    intervals: tuple[Interval, ...]
    truth: float | None = None


Cell = str | QuantityCell | Intervals
#: What is in a column, for pages that show it their own way.
Kind = Literal["", "unit", "status", "method", "intervals"]


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of a table.

    Attributes
    ----------
    head : str
    unit : str
        Of everything in it.
    align : {"right", "left"}
    parts : tuple of str
        Heads of the deviation and of what else a `QuantityCell` tells, where each has a column of
        its own. Without them a quantity is one text.
    group : str
        Columns of one group stay beside one another on a narrow terminal, as parts do.
    kind : Kind
        What is in it.
    """

    head: str
    unit: str = ""
    align: Align = "right"
    parts: tuple[str, ...] = ()
    group: str = ""
    kind: Kind = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableBlock:
    """Rows of cells.

    Attributes
    ----------
    columns : tuple of TableColumn
    rows : tuple of tuple of Cell
    labels : int
        The first columns that say what a row is of, repeated where a table is broken.
    title : str
        Above it.
    said : tuple of str
        Sentences below it.
    """

    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]
    labels: int = 1
    title: str = ""
    said: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    """Named facts under one another; those without a text are passed over.

    Attributes
    ----------
    facts : mapping of str to str
        Text by name.
    title : str
        Above them.
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
        Nothing has to be said of what passed.
    """

    status: Status
    names: tuple[str, ...]
    meaning: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Checks:
    """What was checked, the gravest first.

    Attributes
    ----------
    judged : tuple of CheckGroup
    conclusion : str
        Whether to believe it; empty where that is not concluded.
    """

    judged: tuple[CheckGroup, ...]
    conclusion: str = ""


@dataclass(frozen=True, slots=True)
class Notes:
    """Notes that tables refer to by number, from 1."""

    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sentence:
    """A sentence or more, or a line of another block.

    Attributes
    ----------
    text : str
    lead : str
        First words.
    hang : int
        Blanks before its further lines.
    filled : bool
        Whether it is broken at the width of a page, or of a terminal; what is copied is not.
    kind : str
        For colours: ``lead`` where the first words stand out, ``line``, or a `Status`.
    """

    text: str
    lead: str = ""
    hang: int = 0
    filled: bool = True
    kind: str = "lead"


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """Sentences, each on a line of its own, under a title or none."""

    sentences: tuple[Sentence, ...]
    title: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Formulas and facts under a title; none of their words is broken."""

    title: str
    lines: tuple[str, ...]


Block = Heading | TableBlock | Checks | Notes | Paragraph | Listing
Document = tuple[Block, ...]


def text_columns(heads: Iterable[str]) -> tuple[TableColumn, ...]:
    """Columns by their heads: the first to the left, the others, of which one has units, right."""
    kinds: dict[str, Kind] = {"unit": "unit", "status": "status"}
    return tuple(
        TableColumn(head, align="right" if i else "left", kind=kinds.get(head, ""))
        for i, head in enumerate(heads)
    )


def text_table(
    heads: Iterable[str],
    rows: Iterable[Sequence[Cell]],
    *,
    labels: int = 1,
    title: str = "",
    said: tuple[str, ...] = (),
) -> TableBlock:
    """A table whose columns are told by their heads, see `text_columns`."""
    return TableBlock(
        columns=text_columns(heads),
        rows=tuple(map(tuple, rows)),
        labels=labels,
        title=title,
        said=said,
    )


def paragraph(*sentences: str | Sentence, title: str = "") -> Paragraph:
    """A paragraph of sentences, or of plain texts."""
    return Paragraph(
        sentences=tuple(
            Sentence(text=plain_numbers(each)) if isinstance(each, str) else each
            for each in sentences
        ),
        title=title,
    )


def readable_unit(unit: str) -> str:
    """A unit with its powers raised: ``m/s²``."""
    return re.sub(r"(?:\^|\*\*)(-?\d+)", lambda m: m[1].translate(_RAISED), unit)


def readable_text(text: str) -> str:
    """A sentence as it is printed: ``1.2e-06 kg m^2`` gets a true power of ten."""
    numbered = _NUMBER.sub(_number, text.replace(" +-", " ±"))
    return re.sub(r"(?<=[^\W\d_])\^(-?\d+)(?![\w.])", lambda m: m[1].translate(_RAISED), numbered)


def decimals(deviation: float, digits: int = 2, least: int = 0) -> int:
    """Decimal places of a value that show so many digits of its deviation; 4 without one."""
    if not 0 < deviation < math.inf:
        return 4
    return min(max(least, digits - 1 - math.floor(math.log10(deviation))), 12)


def figure_text(value: float, digits: int = 3) -> str:
    """A number of a column to so many digits; a large one is written out, as the others are."""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < _PLAIN[1] else text


def _number(found: re.Match[str]) -> str:
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
