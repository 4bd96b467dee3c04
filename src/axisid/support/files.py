"""Read and write files safely: only regular files, complete, unchanged while read; JSON and CSV.

The first or last bytes of every output name the command that made it: the schema of a result, the
creator of a page or figure, the first lines of exported or generated code.
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
    """Open a regular file for reading within the context; a link is followed.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe, a socket, a device or a folder.
    """
    # Without O_NONBLOCK the opening of a pipe would wait until a process opens it for writing.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        with open(descriptor, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(descriptor)


def read_regular(path: Path) -> bytes:
    """Return the bytes of a regular file; a link is followed.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe, a socket, a device or a folder.
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
        path.write_bytes(data)  # not resolved: the real name of an open pipe cannot be opened
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
        Function that returns the content, by ending.
    refused : str
        First sentence, without its full stop, of the error for another ending.
    code : str
        Code of this error.

    Raises
    ------
    UsageError
        The ending is another one, or the file system refuses.
    """
    if path.suffix not in writers:
        raise UsageError(f"{refused}. Give a name that ends in {', '.join(writers)}.", code=code)
    return write_file(path, writers[path.suffix]())


#: State of a file, which changes when the file does: device, inode, size, time of change in ns.
Stamp = tuple[int, int, int, int]


def stamps(path: Path) -> dict[Path, Stamp]:
    """Return the state of a file, or of every file in a folder and its subfolders, by path.

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
    """Return the SHA-256, as hexadecimal text, of the joined contents of regular files."""
    digest = hashlib.sha256()
    for file in files:
        with opened_regular(file) as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


@contextmanager
def unchanged(path: Path) -> Iterator[list[Path]]:
    """Yield a file, or the files of a folder, as a list; afterwards refuse it if a file changed.

    Raises
    ------
    OSError
        A file cannot be read.
    DataError
        A file changed within the context.
    """
    before = stamps(path)
    yield list(before)
    if stamps(path) != before:
        raise DataError(
            f"{path} changed while it was read. Wait until the program that writes the file has "
            "closed it, or read a copy.",
            code="log-file",
        )


#: Ways to write a result to a file, as a part of sentences.
HOW_SAVED = "written with --json, or by save()"
#: Instruction for a file that is not a result.
GIVE_RESULT = f"Give the file of a result of identify, {HOW_SAVED}."
#: Instruction for a file that was changed or cut off.
WRITE_AGAIN = f"Identify again to get a result {HOW_SAVED}."

_LARGEST = 64_000_000  # bytes; a typical result has some ten thousand


def read_result(file: Path) -> bytes:
    """Return the bytes of a file that may be a result; its content is not checked here.

    Raises
    ------
    DataError
        The file cannot be read, is not a regular file, or is larger than 64 MB.
    """
    try:
        with opened_regular(file) as stream:
            content = stream.read(_LARGEST + 1)
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
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
    """Return a document as JSON on several lines, with its `digest` if it has a schema.

    Raises
    ------
    EstimationError
        A number in the document is infinite or NaN.
    """
    try:
        if "schema" in document:
            document = {**document, "digest": digest(document)}
        return json.dumps(document, indent=2, allow_nan=False) + "\n"
    except ValueError as error:
        place, value = next(_not_finite(document, ""))
        raise EstimationError(
            f"the result cannot be written as JSON, because {place} is {value}. A value exceeds "
            "the range of floating-point numbers. Check the equation of motion over the positions "
            "and speeds of the record, and the units of the record.",
            code="result-file",
        ) from error


def digest(document: Mapping[str, Any]) -> str:
    """Return the SHA-256, as hexadecimal text, of a document without its member ``digest``.

    All numbers are converted to floats, because other programs write 1.0 as 1.
    """
    members = {name: value for name, value in document.items() if name != "digest"}
    floats = json.loads(json.dumps(members), parse_int=float)
    return hashlib.sha256(json.dumps(floats, sort_keys=True).encode()).hexdigest()


def is_unchanged(document: Mapping[str, Any]) -> bool:
    """Return True if a document is unchanged since it was written, or has no digest."""
    return "digest" not in document or document["digest"] == digest(document)


def toml_text(text: str) -> str:
    """Return a text as a basic string of TOML: as in JSON, with DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _not_finite(value: Any, place: str) -> Iterator[tuple[str, float]]:
    """Yield the path and the value of each number in a document that JSON cannot represent.

    `place` is the path of `value` in the document, such as ``estimates.0.sd``; empty for the
    document itself.
    """
    if isinstance(value, float) and not math.isfinite(value):
        yield place, value
    members: Iterable[tuple[object, Any]] = ()
    if isinstance(value, Mapping):
        members = value.items()
    elif isinstance(value, (list, tuple)):
        members = enumerate(value)
    for key, member in members:
        yield from _not_finite(member, f"{place}.{key}" if place else str(key))


_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV text; None is an empty cell.

    A text that a spreadsheet would run as a formula begins with an apostrophe, which marks it as
    text. Serial numbers and names of logs can contain any characters.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_as_text, row) for row in rows)
    return text.getvalue()


def _as_text(cell: object) -> object:
    """Return a cell; a text that begins like a formula, and is not a number, with an apostrophe."""
    if not isinstance(cell, str):
        return cell
    is_formula = cell.startswith(_FORMULA)
    with suppress(ValueError):
        float(cell)
        is_formula = False
    # The CSV writer does not quote a carriage return, which readers take as the end of a row.
    text = cell.replace("\r", "\n")
    return f"'{text}" if is_formula else text


_LOOKED_AT = 8192  # bytes at the beginning and at the end of a file

_SCHEMA = rb'\s*\{\s*"schema":\s*"axisid\.(?:%s)/\d'
_EXPORTED = (
    rb"\W{0,4}Feed-forward of the axis ",  # after the beginning of a comment
    rb"# (?:This table replaces that of the same name|Base parameters\. The axis is)",
    rb"# (?:Replaces the table \[parameters\]|For the axis's declaration, in place)",  # earlier
    rb"# Base parameters: the axis is",  # earlier
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
    """Return the kinds of output that a file may be; empty if no command wrote the file.

    The kind of the JSON document of a command is the name of the command.

    Parameters
    ----------
    file : Path
        A regular file.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    with file.open("rb") as stream:
        ends = stream.read(_LOOKED_AT)
        stream.seek(max(stream.seek(0, 2) - _LOOKED_AT, len(ends)))
        ends += stream.read()
    begun = {kind for kind, mark in _BEGINS.items() if re.match(mark, ends)}
    return begun | {kind for kind, mark in _HOLDS.items() if re.search(mark, ends)}
