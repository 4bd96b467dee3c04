"""Blocks as plain text: what a pipe and a file get, and `print` of a result."""

import textwrap
from collections.abc import Sequence
from functools import singledispatch
from types import MappingProxyType
from typing import Any

from .document import Align, Block, Checks, Document, Heading, Listing, Notes, Paragraph, Table
from .grid import grid

PAGE_WIDTH = 96  # characters
FACT_WIDTH = 11  # of the names in a heading
#: What a line about checks begins with.
STATUS_HEADS = MappingProxyType(
    {"fail": "FAIL   ", "note": "note   ", "not evaluated": "-      ", "pass": "pass   "}
)


def plain_text(document: Document) -> str:
    """The blocks one under the other, with a blank line between them."""
    texts = [block_text(block) for block in document]
    return "\n\n".join(text for text in texts if text) + "\n"


@singledispatch
def block_text(block: Block) -> str:
    """One block, without a line break at its end."""
    raise TypeError(f"{type(block).__name__} is no block")


@block_text.register
def _(block: Heading) -> str:
    lines = [
        _filled(f"{name:<{FACT_WIDTH}}", text, FACT_WIDTH) for name, text in block.facts if text
    ]
    return _titled(block.title, lines)


@block_text.register
def _(block: Table) -> str:
    texts = grid(block)
    rows = [texts.heads, *texts.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(texts.heads))]
    rule = "-" * (sum(widths) + 2 * (len(widths) - 1))
    head, *others = (_row(row, widths, texts.aligns) for row in rows)
    return _titled(block.title, [head, rule, *others, *block.said])


def _row(row: Sequence[str], widths: Sequence[int], aligns: Sequence[Align]) -> str:
    cells = (
        text.ljust(width) if align == "left" else text.rjust(width)
        for text, width, align in zip(row, widths, aligns, strict=True)
    )
    return "  ".join(cells).rstrip()


@block_text.register
def _(block: Checks) -> str:
    said = [_filled(f"{'verdict':<{FACT_WIDTH}}", block.conclusion, FACT_WIDTH), ""]
    lines = said if block.conclusion else []
    for judged in block.judged:
        head = STATUS_HEADS[judged.status]
        lines.append(_filled(head, judged.text, len(head)))
    return "\n".join(lines)


@block_text.register
def _(block: Notes) -> str:
    heads = [f"[{i}] " for i in range(1, len(block.notes) + 1)]
    return "\n".join(
        _filled(head, note, len(head)) for head, note in zip(heads, block.notes, strict=True)
    )


@block_text.register
def _(block: Paragraph) -> str:
    lines = [
        _filled(each.lead, each.text, each.hang) if each.filled else f"{each.lead}{each.text}"
        for each in block.sentences
    ]
    return _titled(block.title, lines)


@block_text.register
def _(block: Listing) -> str:
    kept = [_filled("  ", line, 6, replace_whitespace=False) for line in block.lines]
    return _titled(block.title, kept)


def _titled(title: str, lines: Sequence[str]) -> str:
    return "\n".join([*filter(None, [title]), *lines])


def _filled(head: str, text: str, hang: int, **how: Any) -> str:
    """A text as wide as a page, after its head, with further lines so many blanks in.

    A word that is longer, such as a path, stays whole.
    """
    return textwrap.fill(
        text,
        PAGE_WIDTH,
        initial_indent=head,
        subsequent_indent=" " * hang,
        break_long_words=False,
        break_on_hyphens=False,
        **how,
    )
