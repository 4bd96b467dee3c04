"""Blocks and sentences as HTML without scripts or styles; command-line options are not broken."""

import re
from html import escape
from types import MappingProxyType

from axisid.support.wording import range_text

from .document import (
    Block,
    Cell,
    CheckGroup,
    Checks,
    Document,
    Heading,
    Intervals,
    Listing,
    Notes,
    Paragraph,
    QuantityCell,
    TableBlock,
    TableColumn,
    readable_text,
    readable_unit,
)
from .plain import joined

_WIDTH, _HEIGHT, _EDGE = 170.0, 26.0, 6.0  # of the drawing of intervals, and its margins, px
_SCALE = 12.0  # height of the scale below the intervals, px
# Arrows and options, with their argument, that have no line break.
_WHOLE = re.compile(r"(->|--[a-z](?:-?[a-z0-9])*(?: [a-z]+-[a-z]+| [A-Z]+(?:=[\w+-]+)?)?)")
_SIGNS = MappingProxyType({"pass": "✓", "note": "○", "fail": "✗", "not evaluated": "·"})
#: Classes of the signs, for pages that colour them.
STATUS_CLASSES = MappingProxyType(
    {"pass": "pass", "note": "noted", "fail": "fail", "not evaluated": "missing"}
)


def intervals_html(drawn: Intervals) -> str:
    """Return a drawing of intervals above one another with a scale, as SVG.

    The true value is a dotted line. The result is empty if all ends are equal or one of them is not
    finite.
    """
    ends = [
        *(end for each in drawn.intervals for end in (each.low, each.high)),
        *([] if drawn.truth is None else [drawn.truth]),
    ]
    low, span = min(ends), max(ends) - min(ends)
    if not 0 < span < float("inf"):
        return ""

    def place(x: float) -> str:
        """Return the horizontal place of a value in the drawing, px."""
        return f"{_EDGE + (x - low) / span * (_WIDTH - 2 * _EDGE):.1f}"

    at = "" if drawn.truth is None else place(drawn.truth)
    marks = f'<line class="truth" x1="{at}" x2="{at}" y1="1" y2="25"/>' if at else ""
    for i, each in enumerate(drawn.intervals, 1):
        y = f"{_HEIGHT * i / (len(drawn.intervals) + 1):.1f}"
        marks += (
            f'<g class="{each.kind}">'
            f'<line x1="{place(each.low)}" x2="{place(each.high)}" y1="{y}" y2="{y}"/>'
            f'<circle cx="{place(each.centre)}" cy="{y}" r="3"/></g>'
        )
    # Colours and size are for pages without a style of their own.
    return (
        f'<svg class="interval" viewBox="0 0 {_WIDTH:g} {_HEIGHT + _SCALE:g}" '
        f'stroke="currentColor" fill="currentColor" width="170" role="img">{marks}'
        f"{_scale_html(low, low + span)}</svg>"
    )


def _scale_html(low: float, high: float) -> str:
    """Return the scale of a drawing, with the smallest and the largest value at its ends."""
    first, last = range_text(low, high, "|", digits=3).split("|")
    bottom = _HEIGHT + _SCALE - 1
    return (
        f'<line class="axis" x1="{_EDGE:g}" x2="{_WIDTH - _EDGE:g}" y1="{_HEIGHT:g}" '
        f'y2="{_HEIGHT:g}"/>'
        f'<text x="{_EDGE:g}" y="{bottom:g}" font-size="10" stroke="none">{first}</text>'
        f'<text x="{_WIDTH - _EDGE:g}" y="{bottom:g}" font-size="10" stroke="none" '
        f'text-anchor="end">{last}</text>'
    )


def prose_html(sentence: str) -> str:
    """Return sentences as HTML, with a full stop at the end; no letter changes its case."""
    text = readable_text(sentence.rstrip())
    return unbroken(text if text.endswith((".", "?", "!")) else f"{text}.")


def unbroken(text: str) -> str:
    """Return text as HTML without line breaks inside command-line options or arrows."""
    # Every second part is a match.
    return "".join(
        f'<span class="option">{escape(part)}</span>' if i % 2 else escape(part)
        for i, part in enumerate(_WHOLE.split(text))
    )


def blocks_html(document: Document) -> str:
    """Return all blocks of a document as HTML."""
    return "".join(map(block_html, document))


def block_html(block: Block) -> str:
    """Return one block as HTML."""
    above = escape(getattr(block, "title", ""))
    title = f"<p><b>{above}</b></p>" if above else ""
    match block:
        case Heading():
            # Facts may contain names from a file, so their text is not reformatted.
            facts = "".join(
                f"<dt>{escape(name)}</dt><dd>{unbroken(text)}</dd>"
                for name, text in block.facts.items()
                if text
            )
            return title + (f"<dl>{facts}</dl>" if facts else "")
        case TableBlock():
            said = "".join(f'<p class="note">{prose_html(sentence)}</p>' for sentence in block.said)
            return table_html(block) + said
        case Checks():
            concluded = f"<p>{prose_html(block.conclusion)}</p>" if block.conclusion else ""
            return concluded + checks_html(block.judged)
        case Notes():
            listed = "".join(
                f"<p>{label} {prose_html(note)}</p>" for label, note in block.labelled()
            )
            return f"<details><summary>Notes</summary>{listed}</details>"
        case Paragraph():
            lines = ""
            for each in block.sentences:
                lead = each.lead.strip()
                highlighted = f"<b>{escape(lead)}</b> " if lead else ""
                lines += f"<p>{highlighted}{prose_html(each.text)}</p>"
            return title + lines
        case Listing():
            lines = "".join(f"<li><code>{escape(line)}</code></li>" for line in block.lines)
            return f"{title}<ul>{lines}</ul>"


def table_html(table: TableBlock) -> str:
    """Return a table as HTML, with its title as caption and without the sentences below it."""
    caption = f"<caption>{escape(table.title)}</caption>" if table.title else ""
    heads = "".join(map(_head, table.columns))
    body = ""
    for row in table.rows:
        cells = zip(row, table.columns, strict=True)
        filled = (_cell(cell, column, is_label=not j) for j, (cell, column) in enumerate(cells))
        body += f"<tr>{''.join(filled)}</tr>"
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


def _head(column: TableColumn) -> str:
    """Return the head of a column as HTML: text, unit, and the head of the standard error."""
    head = escape(column.head).replace("+-", "±")
    head += f" [{escape(readable_unit(column.unit))}]" if column.unit else ""
    head += f" ± {escape(column.parts[0])}" if column.parts else ""
    if column.kind == "method":  # with the colour of its estimator, as in the intervals
        kind = column.head.lower().rsplit("-", 1)[-1]
        head = f'<span class="swatch-{escape(kind)}">●</span> {head}'
    kind = "unit" if column.kind == "unit" else "text" if column.align == "left" else ""
    return f'<th class="{kind}">{head}</th>' if kind else f"<th>{head}</th>"


def _cell(cell: Cell, column: TableColumn, *, is_label: bool) -> str:
    """Return a cell as HTML; the label of a row is not reformatted."""
    kind = column.kind or ("text" if column.align == "left" else "")
    attributes = f' class="{kind}"' if kind else ""
    if isinstance(cell, Intervals):
        return f"<td{attributes}>{intervals_html(cell)}</td>"
    text = joined(cell)
    if is_label and not column.kind:
        return f"<th{attributes}>{escape(text)}</th>"
    if isinstance(cell, QuantityCell) and cell.more:  # further texts become a tooltip
        parts = zip(column.parts[1:], cell.more, strict=False)
        tooltip = ", ".join(f"{head} {part}" for head, part in parts)
        attributes += f' title="{escape(tooltip)}"'
    shown = sign_html(text) if column.kind == "status" else escape(readable_text(text))
    return f"<td{attributes}>{shown}</td>"


def checks_html(judged: tuple[CheckGroup, ...]) -> str:
    """Return groups of checks as an HTML list."""
    return f'<ul class="checks">{"".join(map(_judged, judged))}</ul>'


def _judged(judged: CheckGroup) -> str:
    """Return a group of checks as an item of an HTML list, with its sign."""
    names = escape(", ".join(judged.names))
    if judged.meaning:
        names = f"<b>{names[:1].upper()}{names[1:]}:</b> {prose_html(judged.statement)}"
    return f"<li>{sign_html(judged.status)} <span>{names}</span></li>"


def sign_html(status: str) -> str:
    """Return the sign of a status as HTML, such as a tick for ``pass``."""
    return f'<span class="sign {STATUS_CLASSES[status]}" title="{status}">{_SIGNS[status]}</span>'
