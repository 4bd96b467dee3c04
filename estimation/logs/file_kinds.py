"""What a file is by its first bytes, so that a wrong ending is told with what to do about it."""

import re
import stat
import zipfile
from pathlib import Path

from axisid.support.errors import DataError

from .formats import ZIP, format_by_content, format_of
from .packings import packing_by_content, packing_of

HEAD = 4096  # bytes that tell the kind
_ASK = "give the file the ending "
_JSON = re.compile(rb'\s*(\{\s*"|\[\s*[\[{])')
#: First bytes of what is no log, what such a file is, and what to do.
_NO_LOGS: tuple[tuple[bytes, str, str], ...] = (
    (b"\x93NUMPY", "a NumPy array", "save the columns with numpy.savez, as .npz"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Office file", "save its sheet as CSV"),
    (b"%PDF", "a PDF document", "give the log itself"),
    (b"\x89PNG", "a picture", "give the log itself"),
    (b"\xff\xd8\xff", "a picture", "give the log itself"),
    (b"7z\xbc\xaf", "a 7z archive", "unpack it and give the log"),
    (b"Rar!", "a RAR archive", "unpack it and give the log"),
    (b"BZh", "compressed by bzip2", "unpack it first"),
    (b"\xfd7zXZ\0", "compressed by xz", "unpack it first"),
    (b"{\\rtf", "a word processor's document", "save the table as CSV"),
)


def check_regular(file: Path, *, folder: bool) -> None:
    """Refuse what is there but is no file with an end, such as a pipe or a device.

    Parameters
    ----------
    file : Path
    folder : bool
        Whether it may be a folder.

    Raises
    ------
    DataError
        It is not a regular file or a folder, or there is none.
    """
    try:
        mode = file.stat().st_mode
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        where = "" if file.is_absolute() else f" ({Path.cwd() / file})"
        raise DataError(
            f"{file} cannot be read: {why}{where}. Check the path.", code="log-not-read"
        ) from error
    if stat.S_ISDIR(mode) and not folder:
        raise DataError(
            f"{file} cannot be read: it is a folder, and no ROS 2 bag. Give the file of the log.",
            code="folder-for-log",
        )
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise DataError(
            f"{file} is no regular file but a pipe, a device or a socket; save the log to a file.",
            code="log-not-a-file",
        )


def check_kind(file: Path) -> None:
    """Refuse a file whose first bytes are those of another format than its ending says.

    Raises
    ------
    DataError
        It says what the file is, and what to do.
    """
    if not file.is_file():
        return
    with file.open("rb") as stream:
        head = stream.read(HEAD)
    ending = file.suffix.lower()
    found = _kind(file, head, ending)
    if found is not None:
        kind, advice = found
        raise DataError(f"{file} is {kind} by its content; {advice}.", code="other-kind-of-file")


def _kind(file: Path, head: bytes, ending: str) -> tuple[str, str] | None:
    """What a file is and what to do, where that is surely not what its ending says."""
    found = format_by_content(head)
    if found is not None:
        log_format, signature = found
        advice = f"{_ASK}{log_format.endings[0]}{signature.provided}"
        return None if ending in log_format.endings else (signature.kind, advice)
    for start, kind, advice in _NO_LOGS:
        if head.startswith(start):
            return kind, advice
    named = format_of(file)
    if head.startswith(ZIP):
        return None if named.start == ZIP else _archive(file)
    packed, packing = packing_by_content(head), packing_of(file)
    if packed is not None:
        advice = f"{_ASK}{packed.ending}, as in .csv{packed.ending}"
        return None if packed is packing else (f"compressed by {packed.name}", advice)
    if packing is not None:
        return f"not compressed by {packing.name}", f"{_ASK}of what it is"
    if b'"axisid.' in head and _JSON.match(head):
        return "a result of axisid in JSON", "give the log that it was found from"
    if named.is_text:
        return _marked_up(head)
    return ("text", f"{_ASK}.csv") if named.is_binary and _is_text(head) else None


def _archive(file: Path) -> tuple[str, str]:
    try:
        with zipfile.ZipFile(file) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError):
        names = []
    if any(name.startswith("xl/") for name in names):
        return "an Excel workbook", "save the sheet of the log as CSV"
    if names and all(name.endswith(".npy") for name in names):
        return "a NumPy archive", f"{_ASK}.npz"
    return "a ZIP archive", "unpack it and give the log"


def _marked_up(head: bytes) -> tuple[str, str] | None:
    """Text that is surely no table."""
    begin = head.removeprefix(b"\xef\xbb\xbf").lstrip()[:200].lower()
    if begin.startswith((b"<!doctype html", b"<html")):
        return "a page in HTML", "export the log itself as CSV"
    if begin.startswith(b"<?xml"):
        return "an XML document", "export the log as CSV"
    if _JSON.match(begin):
        return "a JSON document", f"{_ASK}.json, or .jsonl for a record in each line"
    return None


def _is_text(head: bytes) -> bool:
    """Whether bytes are printable and have lines, as a table in text has."""
    return b"\n" in head and all(byte >= 0x20 or byte in b"\t\n\r\f" for byte in head)
