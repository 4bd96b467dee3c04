"""Delimited text of any dialect, decoded and parsed; see `dialect` for how it is recognised."""

from dataclasses import replace

from axisid.estimation.tables import Table
from axisid.support.errors import DataError

from .columns import text_columns, without_comments
from .dialect import Line, sniff
from .labview import is_labview, plain_lines
from .tail import complete_lines, is_cut, left_out
from .twincat import is_twincat, read_twincat

_MIN_ZERO_BYTE_SHARE = 0.3  # of every second byte is zero: UTF-16 without its mark

_LOOKED = 2000  # bytes in which zeros tell UTF-16
_CODECS = {"utf-8": "utf-8-sig"}  # a mark is no part of the text


def read_text(source: str, content: bytes, *, drop_tail: bool = False) -> Table:
    """Read a text file: delimited text, or what TwinCAT Scope or LabVIEW writes.

    Parameters
    ----------
    source : str
        File name, for messages.
    content : bytes
    drop_tail : bool
        Whether lines at the end that are no rows may be left out.

    Raises
    ------
    DataError
        It is no text, or no table.
    """
    encoding = _encoding_of(source, content)
    text = _decoded(source, content, encoding)
    lines = _numbered(text)
    if is_twincat(lines):
        table = read_twincat(source, lines)
        return replace(table, notes=(*table.notes, *_encoding_note(encoding)))
    notes = _encoding_note(encoding)
    if is_labview(lines):
        lines, more = plain_lines(source, lines)
        notes = (*more, *notes)
    dialect = sniff(source, lines)
    body = without_comments(lines[dialect.first :])
    ended = text.endswith(("\n", "\r"))
    complete = complete_lines(body, dialect, ended=ended)
    whole = complete if drop_tail else len(body) - (not ended and is_cut(body, dialect))
    tail = body[whole:]
    columns = text_columns(source, body[:whole], dialect)
    return Table(
        source=source,
        columns=columns,
        texts={name: column.texts for name, column in columns.items() if len(column.texts)},
        notes=dialect.notes + notes,
        repairs=(left_out(tail),) if drop_tail or tail else (),
        incomplete=whole - complete,
    )


def _numbered(text: str) -> list[Line]:
    """The filled lines of a text with their numbers."""
    return [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]


def _encoding_of(source: str, content: bytes) -> str:
    """The encoding that a file's bytes are taken to have.

    UTF-8, with or without a byte order mark; UTF-16 by its mark or by its zero bytes; else the
    Western Windows code page.

    Raises
    ------
    DataError
        There are zero bytes in it that are not those of UTF-16.
    """
    if wide := _utf16(content):
        return wide
    if b"\0" in content:
        raise NoTextError(source)
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def _utf16(head: bytes) -> str:
    """UTF-16 with or without its mark, by the beginning of a file; empty for what is none."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    even, odd = head[:_LOOKED:2].count(0), head[1:_LOOKED:2].count(0)
    half = max(len(head[:_LOOKED]) / 2, 1)
    if max(even, odd) / half <= _MIN_ZERO_BYTE_SHARE:
        return ""
    return "utf-16-le" if odd > even else "utf-16-be"


def _encoding_note(encoding: str) -> tuple[str, ...]:
    return (f"encoding {encoding}",) if encoding != "utf-8" else ()


def _decoded(source: str, content: bytes, encoding: str) -> str:
    try:
        text = content.decode(_CODECS.get(encoding, encoding))
    except UnicodeDecodeError as error:
        raise NoTextError(source) from error
    if "\0" in text:
        raise NoTextError(source)
    return text


class NoTextError(DataError):
    """A file is no text in an encoding that is known."""

    code = "no-text"

    def __init__(self, source: str) -> None:
        super().__init__(
            f"{source} is no text in UTF-8, UTF-16 or Windows-1252; save it as CSV in UTF-8."
        )
        self.args = (source,)  # for pickle
