"""Files that are read and written: regular ones, complete, unchanged while read, as JSON and CSV.

Every output states in its first or last bytes which command made it: a result by its schema, a page
and figures by their creator, exported and generated code by its first lines.
"""

import csv
import errno
import hashlib
import io
import json
import math
import os
import re
import secrets
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from .errors import DataError, EstimationError, UsageError


@contextmanager
def opened_regular(path: Path) -> Iterator[io.BufferedReader]:
    """Open a regular file for reading; a link is followed.

    Raises
    ------
    OSError
        It cannot be read, or is a pipe, a socket, a device or a folder.
    """
    # Without O_NONBLOCK the opening of a pipe waits for who writes to it.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        with open(descriptor, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(descriptor)


def read_regular(path: Path) -> bytes:
    """Return the content of a regular file; a link is followed.

    Raises
    ------
    OSError
        It cannot be read, or is a pipe, a socket, a device or a folder.
    """
    with opened_regular(path) as file:
        return file.read()


def axis_file(name: str) -> tuple[Path, str]:
    """Return the file that an axis argument names, and the variable of ``FILE.py:VARIABLE``.

    The variable is empty if none is named.
    """
    head, python, variable = name.partition(".py:")
    return Path(f"{head}.py" if python else name), variable


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file completely or not at all, through a temporary file in the same folder.

    Text is written as UTF-8. A link is followed. A device or a pipe is written to, not replaced. An
    existing file keeps its mode; a new one gets the user's default.

    Raises
    ------
    OSError
        The file system refuses; the file is unchanged.
    """
    # Names of files may hold bytes that are no text.
    data = content.encode(errors="replace") if isinstance(content, str) else content
    if path.exists() and not path.is_file():
        path.write_bytes(data)  # by this name: that of an open pipe leads nowhere
        return
    try:
        path = path.resolve()
    except RuntimeError as error:  # before Python 3.13
        raise OSError(errno.ELOOP, "the link points to itself") from error
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "the file is read-only")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def write_file(path: Path, content: str | bytes) -> Path:
    """Write a file as `replace_file` does, and return its path.

    Raises
    ------
    UsageError
        The file system refuses; the file is unchanged.
    """
    try:
        replace_file(path, content)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}.", code="file") from error
    return path


def write_by_ending(
    path: Path, writers: Mapping[str, Callable[[], str | bytes]], refused: str, code: str
) -> Path:
    """Write the content that belongs to the ending of a file's name, and return the path.

    Parameters
    ----------
    path : Path
    writers : mapping of str to callable
        Function that makes the content, by ending.
    refused : str
        Beginning of the message on another ending.
    code : str
        Code of that error.

    Raises
    ------
    UsageError
        The ending is another one, or the file system refuses.
    """
    if path.suffix not in writers:
        raise UsageError(f"{refused}. Give a name that ends in {', '.join(writers)}.", code=code)
    return write_file(path, writers[path.suffix]())


#: Identity of a file at one time: device, number, size and time of change.
Stamp = tuple[int, int, int, int]


def stamps(path: Path) -> dict[Path, Stamp]:
    """Return the stamp of a file, or of every file of a folder, by path.

    Raises
    ------
    OSError
        A file cannot be read.
    """
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    return {
        file: (s.st_dev, s.st_ino, s.st_size, s.st_mtime_ns)
        for file in files
        for s in [file.stat()]
    }


def digest_of(files: list[Path]) -> str:
    """Return the SHA-256 of the contents of regular files, one after the other."""
    digest = hashlib.sha256()
    for file in files:
        with opened_regular(file) as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


@contextmanager
def unchanged(path: Path) -> Iterator[list[Path]]:
    """Yield a file, or the files of a folder, and check afterwards that none has changed.

    Raises
    ------
    OSError
        A file cannot be read.
    DataError
        A file changed meanwhile.
    """
    before = stamps(path)
    yield list(before)
    if stamps(path) != before:
        raise DataError(
            f"{path} changed while it was read. Wait until the program that writes it has closed "
            "it, or read a copy.",
            code="log-file",
        )


#: Words of messages on how a result is written to a file.
HOW_SAVED = "written with --json, or by save()"
#: Instruction for a file that is not a result.
GIVE_RESULT = f"Give the file of a result of identify, {HOW_SAVED}."
#: Instruction for a file that was changed or cut off.
WRITE_AGAIN = f"Identify again to get a result {HOW_SAVED}."

_LARGEST = 64_000_000  # bytes; a result has some ten thousand


def read_result(file: Path) -> bytes:
    """Return the bytes of a file that has the size of a result.

    Raises
    ------
    DataError
        It cannot be read, is not a regular file, or is larger than 64 MB.
    """
    try:
        with opened_regular(file) as stream:
            content = stream.read(_LARGEST + 1)
    except (OSError, ValueError) as error:  # no name has a null
        why = getattr(error, "strerror", None) or error
        raise DataError(
            f"{file} cannot be read: {why}. {GIVE_RESULT}", code="result-file"
        ) from error
    if len(content) > _LARGEST:
        raise DataError(
            f"{file} is larger than {_LARGEST // 10**6} MB, so it is not a result. {GIVE_RESULT}"
        )
    return content


def json_text(document: Mapping[str, Any]) -> str:
    """Return a result as JSON on several lines, with its `digest` if it has a schema.

    Raises
    ------
    EstimationError
        A number in it is infinite or NaN.
    """
    try:
        if "schema" in document:
            document = {**document, "digest": digest(document)}
        return json.dumps(document, indent=2, allow_nan=False) + "\n"
    except ValueError as error:
        place, value = next(_not_finite(document, ""))
        raise EstimationError(
            f"the result cannot be written as JSON, because {place} is {value}. A value exceeds "
            "floating point. Check the equation of motion over the positions and speeds of the "
            "record, and its units.",
            code="result-file",
        ) from error


def digest(document: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a document without its digest.

    Numbers are written as floats, because other programs write 1.0 as 1.
    """
    others = {name: value for name, value in document.items() if name != "digest"}
    floats = json.loads(json.dumps(others), parse_int=float)
    return hashlib.sha256(json.dumps(floats, sort_keys=True).encode()).hexdigest()


def is_unchanged(document: Mapping[str, Any]) -> bool:
    """Return whether a document is unchanged since it was written; True if it has no digest."""
    return "digest" not in document or document["digest"] == digest(document)


def toml_text(text: str) -> str:
    """Return a text as a basic string of TOML: as in JSON, with DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _not_finite(value: Any, place: str) -> Iterator[tuple[str, float]]:
    """Yield the path and the value of each number that JSON cannot represent."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place, value
    items = enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, inner in value.items() if isinstance(value, Mapping) else items:
        yield from _not_finite(inner, f"{place}.{key}" if place else str(key))


_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV; None is an empty cell.

    A text that a spreadsheet would run as a formula gets an apostrophe before it, which
    spreadsheets read as a mark of text. Serial numbers and names of logs can contain anything.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_as_text, row) for row in rows)
    return text.getvalue()


def _as_text(cell: object) -> object:
    """Return a cell; a text that begins like a formula gets an apostrophe before it."""
    if not isinstance(cell, str):
        return cell
    begins_one = cell.startswith(_FORMULA)
    with suppress(ValueError):
        float(cell)
        begins_one = False
    # The writer quotes no carriage return, at which readers begin a row.
    return "'" * begins_one + cell.replace("\r", "\n")


_LOOKED_AT = 8192  # bytes at either end

_SCHEMA = rb'\s*\{\s*"schema":\s*"axisid\.(?:%s)/\d'
_EXPORTED = (
    rb"\W{0,4}Feed-forward of the axis ",  # after what begins a comment
    rb"# (?:Replaces the table \[parameters\]|Base parameters\. The axis is)",
    rb"# (?:For the axis's declaration, in place|Base parameters: the axis is)",  # earlier versions
    rb"axis,method,parameter,unit,value,sd_hac,",
    rb"% \w+: value and standard (?:error|deviation) \(",
    _SCHEMA % b"parameters",
)
#: Regular expression of the beginning of a file, by kind.
_BEGINS = {
    "identify": _SCHEMA % b"identification|stream",
    "sweep": _SCHEMA % b"sweep",
    "law": _SCHEMA % b"law",
    "compare": _SCHEMA % b"comparison",
    "fit": _SCHEMA % b"fit",
    "compare-results": _SCHEMA % b"result_comparison",
    "study": _SCHEMA % b"monte_carlo",
    "export": b"|".join(_EXPORTED),
    "generate": rb'\s*\{\s*"axis":\s*"\w+",\s*"schema":',
    "fleet": _SCHEMA % b"fleet",
    "fleet-table": rb"name,log,axis,serial,",
    "paper-distributions": rb"\d+ twins, appropriate filter",
    "twin-manifest": rb"log,axis,serial,(?:date,)?true ",
    "trend": _SCHEMA % b"trend",
    "trend-table": rb"axis,serial,result,place,",
    "paper": rb"[^\n]* samples of [^\n]* ms\ntrue values: ",
}
#: Regular expression of a text near the beginning or end of a file, by kind.
_HOLDS = {
    "study-runs": rb"axisid\.monte_carlo",
    "report": rb'<meta name="generator" content="axisid ',
    "figure": rb"/Creator \(axisid\)|<dc:title>axisid</dc:title>|Software\0axisid",
    "generate": rb"Generated by `axisid generate",
    "fleet-table": rb"axisid\.fleet/\d",
    "twin": rb"axisid\.twin/\d",
}


def kinds_of(file: Path) -> set[str]:
    """Return the kinds of output that a file may be; empty if no command wrote it.

    The kind of a command's own document is the name of the command.

    Parameters
    ----------
    file : Path
        A regular file.

    Raises
    ------
    OSError
        It cannot be read.
    """
    with file.open("rb") as stream:
        ends = stream.read(_LOOKED_AT)
        stream.seek(max(stream.seek(0, 2) - _LOOKED_AT, len(ends)))
        ends += stream.read()
    begun = {kind for kind, mark in _BEGINS.items() if re.match(mark, ends)}
    return begun | {kind for kind, mark in _HOLDS.items() if re.search(mark, ends)}
