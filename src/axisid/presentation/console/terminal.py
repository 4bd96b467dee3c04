"""Results on a terminal: the same text with emphasis, and within the terminal's width.

The text is made without knowing of terminals; on a pipe it is printed as it is. A few styles and
two widths do not need a library of their own: click brings the styles.
"""

import os
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import Any

import click

_RULE = re.compile(r"-{3,}")
_STYLES: dict[str, dict[str, Any]] = {
    "pass   ": {"fg": "green"},
    "FAIL   ": {"fg": "red", "bold": True},
}
_DIM = ("-      ", "note   ")
_HANG = 4
_LEAST = 40  # columns; what is narrower is left to the terminal


def show_text(text: str) -> None:
    """Print a result: as it is on a pipe, dressed for a terminal."""
    if not is_terminal(sys.stdout):
        click.echo(text, nl=False)
        return
    fitted = fit(text, shutil.get_terminal_size().columns)
    click.echo(fitted if os.environ.get("NO_COLOR") else emphasised(fitted), nl=False)


def is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal that knows colours and can erase a line."""
    dumb = os.environ.get("TERM", "dumb") == "dumb"
    return stream is not None and not dumb and bool(stream.isatty())


def emphasised(text: str) -> str:
    """Headers bold, the verdict in colours; without them it is the same text."""
    lines, dim = text.split("\n"), False
    for i, line in enumerate(lines):
        following = lines[i + 1] if i + 1 < len(lines) else ""
        dim = line.startswith(_DIM) or (dim and line.startswith(" "))
        head = next((head for head in _STYLES if line.startswith(head)), "")
        if _RULE.fullmatch(following) and line:
            lines[i] = click.style(line, bold=True)
        elif dim:
            lines[i] = click.style(line, dim=True)
        elif head:
            said = re.match(r"FAIL   [^:]*:?", line)
            marked = said[0] if said else head
            lines[i] = click.style(marked, **_STYLES[head]) + line[len(marked) :]
        elif line.startswith("recommended:"):
            lines[i] = click.style("recommended:", bold=True) + line[len("recommended:") :]
    return "\n".join(lines)


def fit(text: str, width: int) -> str:
    """Break what is wider than a terminal: paragraphs by words, tables between columns."""
    lines = text.split("\n")
    if width < _LEAST or max(map(len, lines)) <= width:
        return text
    made: list[str] = []
    while lines:
        if len(lines) > 1 and _RULE.fullmatch(lines[1]):
            rows = _table(lines)
            made += _split(rows, width) if len(lines[1]) > width else rows
            lines = lines[len(rows) :]
        else:
            paragraph = _paragraph(lines) if len(lines[0]) > width else lines[:1]
            made += _refilled(paragraph, width) if len(lines[0]) > width else paragraph
            lines = lines[len(paragraph) :]
    return "\n".join(made)


def _table(lines: Sequence[str]) -> list[str]:
    """Header, rule and rows, up to a blank line or a sentence."""
    end = 2
    while end < len(lines) and lines[end] and len(lines[end]) <= len(lines[1]):
        if lines[end].endswith("."):
            break
        end += 1
    return list(lines[:end])


def _split(table: Sequence[str], width: int) -> list[str]:
    """One table under the other, each with the labels; what a column says stays with its head."""
    spans = _columns(table)
    heads = [table[0][a:b].strip() for a, b in spans]
    labels = 2 if heads[1:2] == ["unit"] else 1

    def wide(columns: Sequence[int]) -> int:
        return sum(b - a for a, b in (spans[i] for i in (*range(labels), *columns)))

    pages: list[list[int]] = []
    for group in _groups(heads, labels):
        for part in [group] if wide(group) <= width else [[column] for column in group]:
            if pages and wide([*pages[-1], *part]) <= width:
                pages[-1] += part
            else:
                pages.append(list(part))
    made = [_page(table, [spans[i] for i in (*range(labels), *page)]) for page in pages]
    return [line for page in made for line in ("", *page)][1:] or list(table)


def _columns(table: Sequence[str]) -> list[tuple[int, int]]:
    """Where columns begin and end: two blanks or more in every row part them."""
    header, rule, *rows = table
    blank = [not any(line[i : i + 1].strip() for line in (header, *rows)) for i in range(len(rule))]
    edges, position = [0], 0
    for is_blank, run in groupby(blank):
        length = len(list(run))
        if is_blank and length > 1 and position:
            edges.append(position + length)
        position += length
    return list(pairwise([*edges, len(rule)]))


def _groups(heads: Sequence[str], labels: int) -> list[list[int]]:
    """Columns that share a header (``sd``) belong to the one with its own before them."""
    groups: list[list[int]] = []
    for i in range(labels, len(heads)):
        if groups and heads.count(heads[i]) > 1:
            groups[-1].append(i)
        else:
            groups.append([i])
    return groups


def _page(table: Sequence[str], spans: Sequence[tuple[int, int]]) -> list[str]:
    wide = ["".join(line[a:b].ljust(b - a) for a, b in spans).rstrip() for line in table]
    return [wide[0], "-" * max(len(line) for line in (wide[0], *wide[2:])), *wide[2:]]


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _paragraph(lines: Sequence[str]) -> list[str]:
    """A line and those that hang under it, all alike, up to a table."""
    end = 1
    hang = _indent(lines[1]) if len(lines) > 1 else 0
    while end < len(lines) and lines[end] and _indent(lines[end]) == hang > _indent(lines[0]):
        if end + 1 < len(lines) and _RULE.fullmatch(lines[end + 1]):
            break
        end += 1
    return list(lines[:end])


def _refilled(paragraph: Sequence[str], width: int) -> list[str]:
    first = paragraph[0]
    hang = _indent(paragraph[1]) if len(paragraph) > 1 else max(_indent(first), _HANG)
    return textwrap.wrap(
        " ".join([first, *(line.strip() for line in paragraph[1:])]),
        width,
        subsequent_indent=" " * hang,
        break_on_hyphens=False,
        break_long_words=False,
    )
