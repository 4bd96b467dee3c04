"""The blocks of a document, independent of the output format.

Values are rounded to two digits of their standard error. Printed text has raised powers, true minus
signs, and no ``e``.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from axisid.support.wording import plain_numbers

_MINUS, _TIMES, _THIN = "\u2212", "\u00d7", "\u202f"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = (1e-3, 1e6)  # numbers between these have no power of ten
_GROUPED = 1e4  # from here on thousands are separated
# A sign or a figure that is part of a word, a name or a formula stays as it is.
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
        Further texts for a table with room, named by the `parts` of its column.
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
        Kind of the estimator, for its colour: ``ls``, ``iv`` or ``didim``.
    """

    low: float
    centre: float
    high: float
    kind: str


@dataclass(frozen=True, slots=True)
class Intervals:
    """Intervals drawn on one scale; plain text leaves them out.

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
        `QuantityCell`. If empty, a quantity is one text.
    group : str
        Columns of one group stay together on a narrow terminal, as parts do.
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
    """Notes that tables refer to by number, from 1."""

    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sentence:
    """One or more sentences, or a line of another block.

    Attributes
    ----------
    text : str
    lead : str
        First words.
    hang : int
        Blanks before its further lines.
    filled : bool
        True if the text is wrapped at the width of the page or terminal; False for text to copy.
    kind : str
        For colours: ``lead`` if the first words are highlighted, ``line``, or a `Status`.
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
    """Return columns by their heads: the first aligned left, the others right."""
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
    """Return a table whose columns are given by their heads; see `text_columns`."""
    return TableBlock(
        columns=text_columns(heads),
        rows=tuple(map(tuple, rows)),
        labels=labels,
        title=title,
        said=said,
    )


def paragraph(*sentences: str | Sentence, title: str = "") -> Paragraph:
    """Return a paragraph of sentences or plain texts."""
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
    """Return a sentence in print notation: powers of ten instead of ``1.2e-06``, raised powers."""
    numbered = _NUMBER.sub(_number, text.replace(" +-", " ±"))
    return re.sub(r"(?<=[^\W\d_])\^(-?\d+)(?![\w.])", lambda m: m[1].translate(_RAISED), numbered)


def decimals(deviation: float, digits: int = 2, least: int = 0) -> int:
    """Return decimal places that show `digits` digits of the standard error; 4 without one."""
    if not 0 < deviation < math.inf:
        return 4
    return min(max(least, digits - 1 - math.floor(math.log10(deviation))), 12)


def figure_text(value: float, digits: int = 3) -> str:
    """Return a number rounded to `digits` digits, without exponent below 1e6."""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < _PLAIN[1] else text


def _number(found: re.Match[str]) -> str:
    """Return a number found in a sentence in print notation."""
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
