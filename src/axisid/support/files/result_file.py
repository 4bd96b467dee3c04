"""Results that were written as JSON, read again: files with an end, of a size that results have."""

import re
import stat
from pathlib import Path

from axisid.support.errors import AxisidError

#: How a result becomes a file.
AS_WRITTEN = "written with --json, or by save()"
#: What to do about a file that is none.
GIVE_RESULT = f"Give a result of identify, {AS_WRITTEN}."
#: What to do about a file that was changed or cut off.
WRITE_AGAIN = f"Identify again; the result is {AS_WRITTEN}."

_LARGEST = 64_000_000  # bytes; a result has some ten thousand
#: What was opened by whoever started the program, and can be read to its end.
_OPENED = re.compile(r"/dev/stdin|(/dev|/proc/self)/fd/\d+")


def read_result(file: Path, error: type[AxisidError]) -> bytes:
    """The bytes of a file that has an end and the size of a result.

    Parameters
    ----------
    file : Path
        A regular file, or what the program was given opened, as ``/dev/stdin`` is.
    error : type
        Of what is raised.

    Raises
    ------
    AxisidError
        As `error` says: it cannot be read, is no regular file, or too large.
    """
    try:
        kind = file.stat().st_mode
        if not stat.S_ISREG(kind) and (stat.S_ISDIR(kind) or not _OPENED.fullmatch(str(file))):
            raise error(
                f"{file} cannot be read: it is {_kind(kind)}. {GIVE_RESULT}",
                code="result-file",
            )
        with file.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except AxisidError:
        raise  # it is a ValueError too
    except ValueError as refused:  # a null, or half of a letter
        raise error(
            f"{str(file)!r} is no name of a file. {GIVE_RESULT}", code="result-file"
        ) from refused
    except OSError as refused:
        raise error(
            f"{file} cannot be read: {refused.strerror}. Check the path.", code="result-file"
        ) from refused
    if len(content) > _LARGEST:
        raise error(f"{file} is larger than any result, {_LARGEST // 10**6} MB. {GIVE_RESULT}")
    return content


def _kind(mode: int) -> str:
    return "a folder" if stat.S_ISDIR(mode) else "a pipe, a device or a socket"
