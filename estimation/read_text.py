"""Delimited text of any dialect, decoded and parsed; see `dialect` for how it is recognised."""

from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path

from .dialect import sniff
from .errors import DataError
from .read_twincat import is_twincat, read_twincat
from .table import Table
from .text_columns import Origins, text_columns

_NUL_SHARE = 0.3
_HEAD = 1 << 16  # bytes that tell the encoding of a file too large to be read whole
_HEAD_LINES = 500  # more than what tells the dialect


def read_text(source: str, content: bytes) -> Table:
    """Read a text file: delimited text, or what TwinCAT Scope exports.

    Parameters
    ----------
    source : str
        File name, for messages.
    content : bytes

    Raises
    ------
    DataError
        It is no text, or no table.
    """
    text, encoding = decode(source, content)
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    if is_twincat(lines):
        return read_twincat(source, lines)
    dialect = sniff(source, lines)
    columns = text_columns(source, lines[dialect.first :], dialect)
    notes = dialect.notes + ((f"encoding {encoding}",) if encoding != "utf-8" else ())
    return Table(source=source, columns=columns, notes=notes)


def text_blocks(file: Path, rows: int) -> Iterator[Table]:
    """The table of a text file, so many rows at a time; its dialect is that of its beginning.

    Raises
    ------
    DataError
        It is no text, no table, or an export of TwinCAT Scope, which is read whole.
    """
    source = str(file)
    with file.open("rb") as raw:
        encoding = decode(source, raw.read(_HEAD).rpartition(b"\n")[0])[1]
    plain = "utf-8-sig" if encoding == "utf-8" else encoding
    with file.open(encoding=plain, newline=None) as stream:
        try:
            numbered = ((n, line) for n, line in enumerate(stream, 1) if line.strip())
            head = list(islice(numbered, _HEAD_LINES))
            if is_twincat(head):
                raise DataError(f"{source} is an export of TwinCAT Scope; leave --stream out.")
            dialect = sniff(source, head)
            lines = chain(head[dialect.first :], numbered)
            origins: Origins = {}
            while block := list(islice(lines, rows)):
                columns = text_columns(source, block, dialect, origins)
                yield Table(source=source, columns=columns, notes=dialect.notes)
        except UnicodeDecodeError as error:
            raise _no_text(source) from error


def decode(source: str, content: bytes) -> tuple[str, str]:
    """Text of a file and the encoding it is taken to have.

    UTF-8, with or without a byte order mark; UTF-16 by its mark or by its zero bytes; else the
    Western Windows code page.
    """
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if content.startswith(mark):
            return _strictly(source, content, encoding), encoding
    even, odd = content[:2000:2].count(0), content[1:2000:2].count(0)
    half = max(len(content[:2000]) / 2, 1)
    if odd / half > _NUL_SHARE or even / half > _NUL_SHARE:
        encoding = "utf-16-le" if odd > even else "utf-16-be"
        return _strictly(source, content, encoding), encoding
    if b"\0" in content:
        raise _no_text(source)
    try:
        return content.decode("utf-8-sig"), "utf-8"
    except UnicodeDecodeError:
        pass
    return _strictly(source, content, "cp1252"), "cp1252"


def _strictly(source: str, content: bytes, encoding: str) -> str:
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        raise _no_text(source) from error
    if "\0" in text:
        raise _no_text(source)
    return text


def _no_text(source: str) -> DataError:
    return DataError(
        f"{source} is no text in UTF-8, UTF-16 or Windows-1252; save it as CSV in UTF-8, or give "
        "the file the ending of its format (.mat, .parquet, .npz, .mf4, .tdms, .bag)."
    )
