"""Results that were written as JSON, read again: files with an end, of a size that results have."""

import json
import math
import re
import stat
from pathlib import Path
from typing import Any

from .errors import AxisidError

_LARGEST = 64_000_000  # bytes; a result has some ten thousand
#: What was opened by whoever started the program, and can be read to its end.
_OPENED = re.compile(r"/dev/stdin|(/dev|/proc/self)/fd/\d+")


def read_json(file: Path, error: type[AxisidError], advice: str) -> Any:
    """Read a JSON file whose numbers are all finite.

    Parameters
    ----------
    file : Path
        A regular file, or what the program was given opened, as ``/dev/stdin`` is.
    error : type
        Of what is raised.
    advice : str
        A sentence on what to give instead.

    Raises
    ------
    AxisidError
        As `error` says: it cannot be read, is no regular file, too large, or no such JSON.
    """
    try:
        kind = file.stat().st_mode
        if not stat.S_ISREG(kind) and (stat.S_ISDIR(kind) or not _OPENED.fullmatch(str(file))):
            raise error(f"{file} cannot be read: it is {_kind(kind)}. {advice}")
        with file.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except OSError as refused:
        raise error(f"{file} cannot be read: {refused.strerror}. Check the path.") from refused
    if len(content) > _LARGEST:
        raise error(f"{file} is larger than any result, {_LARGEST // 10**6} MB. {advice}")
    try:
        return json.loads(
            content.decode(), parse_constant=_finite, parse_float=_finite, parse_int=_whole
        )
    except (ValueError, RecursionError) as refused:
        raise error(f"{file} is not JSON: {refused}. {advice}") from refused


def _kind(mode: int) -> str:
    return "a folder" if stat.S_ISDIR(mode) else "a pipe, a device or a socket"


def _finite(text: str) -> float:
    """A number that a double holds; JSON has no others, but some programs write them."""
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"it holds {text[:20]}, which is no number in floating point")
    return number


def _whole(text: str) -> int:
    _finite(text)
    return int(text)
