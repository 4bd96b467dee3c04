"""Delimited text of any dialect, decoded and parsed; see `dialect` for how it is recognised."""

import io
import os
from codecs import IncrementalDecoder, getincrementaldecoder
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from pathlib import Path

from axisid.estimation.tables import Repair, Table
from axisid.estimation.thresholds.logs import MIN_ZERO_BYTE_SHARE
from axisid.support.errors import DataError
from axisid.support.remedy import Note, Remedy, Setting

from .columns import Origins, text_columns, without_comments
from .dialect import Line, sniff
from .labview import is_labview, plain_lines
from .tail import complete_lines, cut_notes, without_tail
from .time_stamps import StampHistory
from .twincat import is_twincat, read_twincat

_LOOKED = 2000  # bytes in which zeros tell UTF-16
_PIECE = 1 << 20  # bytes
_HEAD_LINES = 500  # more than what tells the dialect
_LONGEST_LINE = 1_000_000  # characters; a file without lines would be read whole in search of one
_ENDS = 1 << 16  # bytes at the beginning and at the end: more than the rows that tell a cut
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
    encoding = encoding_of(source, [content])
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
    repairs: tuple[Repair, ...] = ()
    doubts: tuple[Note, ...] = ()
    if drop_tail:
        body, repair = without_tail(body, dialect, ended=ended)
        repairs = (repair,)
    else:
        doubts = cut_notes(body, dialect, ended=ended)
    columns = text_columns(source, body, dialect)
    return Table(
        source=source,
        columns=columns,
        texts={name: column.texts for name, column in columns.items() if len(column.texts)},
        notes=dialect.notes + notes,
        doubts=doubts,
        repairs=repairs,
        incomplete=0 if drop_tail else len(body) - complete_lines(body, dialect, ended=ended),
    )


def text_blocks(source: str, raw: io.RawIOBase, rows: int, encoding: str) -> Iterator[Table]:
    """The table of a text file, so many rows at a time; its dialect is that of its beginning.

    Parameters
    ----------
    source : str
        File name, for messages.
    raw : binary stream
        At its beginning.
    rows : int
        Of a block.
    encoding : str
        As `encoding_of` gives it.

    Raises
    ------
    DataError
        It is no text, no table, or of TwinCAT Scope or LabVIEW, whose files are read whole.
    """
    buffered = io.BufferedReader(raw, _PIECE)
    stream = io.TextIOWrapper(buffered, encoding=_CODECS.get(encoding, encoding), newline=None)
    try:
        numbered = ((n, line) for n, line in enumerate(_lines(source, stream), 1) if line.strip())
        head = list(islice(numbered, max(_HEAD_LINES, rows)))
        if is_twincat(head) or is_labview(head):
            written = "an export of TwinCAT Scope" if is_twincat(head) else "a LabVIEW file"
            raise DataError(
                f"{source} is {written}, which is read whole; ",
                Remedy.of(Setting("stream", given=False), "."),
                code="labview-in-blocks",
            )
        dialect = sniff(source, head)
        notes = dialect.notes + _encoding_note(encoding)
        lines = chain(head[dialect.first :], numbered)
        origins: Origins = defaultdict(partial(StampHistory, goes_on=True))
        while block := list(islice(lines, rows)):
            if body := without_comments(block):
                columns = text_columns(source, body, dialect, origins)
                yield Table(source=source, columns=columns, notes=notes)
    except UnicodeDecodeError as error:
        raise NoTextError(source) from error
    finally:
        stream.detach()
        buffered.detach()  # whoever opened the file has more to ask of it


def _lines(source: str, stream: io.TextIOWrapper) -> Iterator[str]:
    """Lines of a length that a table can have."""
    for line in iter(partial(stream.readline, _LONGEST_LINE), ""):
        if len(line) == _LONGEST_LINE:
            raise DataError(
                f"{source} has a line of {_LONGEST_LINE} characters or more, as no table has; "
                "check what it holds."
            )
        yield line


def cut_end_notes(file: Path) -> tuple[Note, ...]:
    """What is said of a text file whose last row looks cut off inside its last number.

    For a file that is read in blocks: its beginning and its end alone are looked at.
    """
    try:
        with file.open("rb") as raw:
            head = raw.read(_ENDS)
            size = raw.seek(0, os.SEEK_END)
            start = raw.seek(max(size - _ENDS, 0) // 2 * 2)
            end = raw.read(_ENDS)
    except OSError:
        return ()  # whoever reads the whole file says what is wrong with it
    # Numbers are the same letters in UTF-8 and in Windows-1252; only the first piece has a mark.
    wide = _utf16(head)
    marked = "utf-16-le" if head[:1] == b"\xff" else "utf-16-be"
    encoding = marked if wide == "utf-16" else wide or "latin-1"
    first, last = (_numbered(piece.decode(encoding, "replace")) for piece in (head, end))
    try:
        dialect = sniff(str(file), first[:-1] if start else first)
    except DataError:
        return ()  # its beginning is too short for it
    body = without_comments(last[1:] if start else first[dialect.first :])
    ended = end.rstrip(b"\0").endswith((b"\n", b"\r"))
    return cut_notes(body, dialect, ended=ended, numbered=False) if body else ()


def _numbered(text: str) -> list[Line]:
    """The filled lines of a text with their numbers."""
    return [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]


def encoding_of(source: str, pieces: Iterable[bytes]) -> str:
    """The encoding that a file's bytes, given in pieces, are taken to have.

    UTF-8, with or without a byte order mark; UTF-16 by its mark or by its zero bytes; else the
    Western Windows code page.

    Raises
    ------
    DataError
        There are zero bytes in it that are not those of UTF-16.
    """
    utf8: IncrementalDecoder | None = getincrementaldecoder("utf-8")()
    for k, piece in enumerate(pieces):
        if k == 0 and (wide := _utf16(piece)):
            return wide
        if b"\0" in piece:
            raise NoTextError(source)
        try:
            if utf8 is not None:
                utf8.decode(piece)
        except UnicodeDecodeError:
            utf8 = None
    try:
        if utf8 is not None:
            utf8.decode(b"", final=True)
            return "utf-8"
    except UnicodeDecodeError:
        pass
    return "cp1252"


def _utf16(head: bytes) -> str:
    """UTF-16 with or without its mark, by the beginning of a file; empty for what is none."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    even, odd = head[:_LOOKED:2].count(0), head[1:_LOOKED:2].count(0)
    half = max(len(head[:_LOOKED]) / 2, 1)
    if max(even, odd) / half <= MIN_ZERO_BYTE_SHARE.value:
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
