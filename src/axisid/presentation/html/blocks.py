"""Blocks as HTML: tables, lists and sentences without scripts or styles."""

from functools import singledispatch
from html import escape
from types import MappingProxyType

from axisid.presentation.blocks import (
    Block,
    Cell,
    Checks,
    Column,
    Document,
    Heading,
    Judged,
    Listing,
    Notes,
    Paragraph,
    Sentence,
    Table,
    joined,
)
from axisid.presentation.formulas import readable_text, readable_unit

from .prose import prose_html, unbroken

_MARKS = MappingProxyType({"pass": "✓", "note": "○", "fail": "✗", "not evaluated": "-"})


def blocks_html(document: Document) -> str:
    """The blocks of a document one under the other."""
    return "".join(map(block_html, document))


@singledispatch
def block_html(block: Block) -> str:
    """One block."""
    raise TypeError(f"{type(block).__name__} is no block")


@block_html.register
def _(block: Heading) -> str:
    # Names that a file brings stay as they are.
    facts = "".join(
        f"<dt>{escape(name)}</dt><dd>{unbroken(text)}</dd>" for name, text in block.facts if text
    )
    return _titled(block.title) + (f"<dl>{facts}</dl>" if facts else "")


@block_html.register
def table_html(block: Table) -> str:
    """A table, with what is said of it below."""
    caption = f"<caption>{escape(block.title)}</caption>" if block.title else ""
    heads = "".join(_head(column) for column in block.columns)
    rows = "".join(
        "<tr>"
        + "".join(
            _cell(cell, column, labels=not i)
            for i, (cell, column) in enumerate(zip(row, block.columns, strict=True))
        )
        + "</tr>"
        for row in block.rows
    )
    said = "".join(f"<p>{prose_html(sentence)}</p>" for sentence in block.said)
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>{said}"


def _head(column: Column) -> str:
    head = escape(column.head)
    head += f" [{escape(readable_unit(column.unit))}]" if column.unit else ""
    head += f" ± {escape(column.parts[0])}" if column.parts else ""
    return f"<th{_class(column)}>{head}</th>"


def _cell(cell: Cell, column: Column, *, labels: bool) -> str:
    """A cell; what labels a row stays as it is written."""
    if labels:
        return f"<th{_class(column)}>{escape(joined(cell))}</th>"
    more = "" if isinstance(cell, str) else _more(cell.more, column.parts[1:])
    return f"<td{_class(column)}{more}>{escape(readable_text(joined(cell)))}</td>"


def _more(told: tuple[str, ...], heads: tuple[str, ...]) -> str:
    """What else is told of a value: where a pointer rests on it."""
    listed = ", ".join(f"{head} {text}" for head, text in zip(heads, told, strict=True))
    return f' title="{escape(listed)}"' if listed else ""


def _class(column: Column) -> str:
    return ' class="text"' if column.align == "left" else ""


@block_html.register
def _(block: Checks) -> str:
    concluded = f"<p>{prose_html(block.conclusion)}</p>" if block.conclusion else ""
    return f"{concluded}<ul>{''.join(map(_judged, block.judged))}</ul>"


def _judged(judged: Judged) -> str:
    names = escape(", ".join(judged.names))
    if not judged.meaning:
        return f"<li>{_MARKS[judged.status]} {names}</li>"
    lead = "not evaluated, " if judged.status == "not evaluated" else ""
    return f"<li>{_MARKS[judged.status]} <b>{names}</b>: {prose_html(lead + judged.meaning)}</li>"


@block_html.register
def _(block: Notes) -> str:
    listed = "".join(f"<p>[{i}] {prose_html(note)}</p>" for i, note in enumerate(block.notes, 1))
    return f"<details><summary>Notes</summary>{listed}</details>"


@block_html.register
def _(block: Paragraph) -> str:
    return _titled(block.title) + "".join(map(_sentence, block.sentences))


def _sentence(sentence: Sentence) -> str:
    lead = f"<b>{escape(sentence.lead.strip())}</b> " if sentence.lead.strip() else ""
    return f"<p>{lead}{prose_html(sentence.text)}</p>"


@block_html.register
def _(block: Listing) -> str:
    lines = "".join(f"<li><code>{escape(line)}</code></li>" for line in block.lines)
    return f"{_titled(block.title)}<ul>{lines}</ul>"


def _titled(title: str) -> str:
    return f"<p><b>{escape(title)}</b></p>" if title else ""
