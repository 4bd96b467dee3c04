"""Compiled libraries on disk: built once, checked before they are loaded.

A library is named by the content it is made from, so that an edited axis never meets old code. It
is built in a private folder, tested, and moved into place whole; its digest stands beside it and is
compared before the library is loaded.
"""

import atexit
import contextlib
import errno
import hashlib
import os
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from filelock import FileLock, Timeout
from platformdirs import user_cache_path

from .compiler import FLAGS, Compiler, CompilerHangsError, NativeUnavailableError, find_compiler
from .store import replace_file

_LOCK_SECONDS = 300.0
_OLD_SECONDS = 3600.0


def compiled_library(text: str, check: Callable[[Path], None]) -> Path:
    """Return the path of the library compiled from a C text, building it if need be.

    Parameters
    ----------
    text : str
        C11 source.
    check : callable
        Loads a freshly built library; raises `NativeUnavailableError` if its values are wrong.

    Raises
    ------
    NativeUnavailableError
        There is no compiler, it fails or hangs, or no folder can be written to.
    """
    compiler = find_compiler()
    name = _name(text, compiler)
    if (cached := _cached(name)) is not None:
        return cached
    reasons = []
    for make in (_preferred_folder, _temporary_folder):
        try:
            folder = make()
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_private(folder):
                raise PermissionError(errno.EPERM, "others can write to it")
            with FileLock(folder / f"{name}.lock", timeout=_LOCK_SECONDS):
                if not _is_intact(folder / name):
                    build_library(text, compiler, folder / name, check)
            return folder / name
        except Timeout as error:
            reasons.append(f"another process holds {error.lock_file}")
        except CompilerHangsError:
            raise
        except NativeUnavailableError as error:
            # A full disk or one without permission to execute looks like a failing compiler.
            reasons.append(str(error))
        except (OSError, RuntimeError) as error:
            reasons.append(str(error))
    raise NativeUnavailableError("; ".join(dict.fromkeys(reasons)))


def cached_library(text: str) -> Path | None:
    """Return the library of a C text if it was built before and is intact."""
    try:
        return _cached(_name(text, find_compiler()))
    except NativeUnavailableError:
        return None


def _cached(name: str) -> Path | None:
    try:
        library = _preferred_folder() / name
    except RuntimeError:  # there is no home
        return None
    return library if _is_private(library.parent) and _is_intact(library) else None


def _name(text: str, compiler: Compiler) -> str:
    content = "\0".join([text, *FLAGS, *compiler.command, compiler.identity])
    return f"{hashlib.sha256(content.encode(errors='backslashreplace')).hexdigest()}.so"


def _preferred_folder() -> Path:
    asked = os.environ.get("AXISID_CACHE")
    return Path(asked).absolute() if asked else user_cache_path("axisid") / "native"


def _temporary_folder() -> Path:
    """A folder for this process alone, where the cache cannot be written to."""
    folder = tempfile.mkdtemp(prefix="axisid-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _is_private(folder: Path) -> bool:
    """Whether nobody else can put a library there."""
    try:
        status = folder.stat()
    except OSError:
        return False
    shared = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not shared


def _digest(library: Path, name: str) -> str:
    """Of the content and the name it goes by: another axis's library in its place is no match."""
    return hashlib.sha256(name.encode() + library.read_bytes()).hexdigest()


def _is_intact(library: Path) -> bool:
    try:
        return library.with_suffix(".sha256").read_text() == _digest(library, library.name)
    except (OSError, UnicodeDecodeError):
        return False


def build_library(
    text: str, compiler: Compiler, library: Path, check: Callable[[Path], None]
) -> None:
    """Compile in a private folder beside the library, test, then move both files into place.

    Raises
    ------
    NativeUnavailableError
        The compiler fails, or the library computes wrong values.
    OSError
        The folder cannot be written to.
    """
    for left in library.parent.glob("build-*"):  # of a build that was killed
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > _OLD_SECONDS:
                shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as folder:
        source, target = Path(folder) / "native.c", Path(folder) / f"{secrets.token_hex(8)}.so"
        source.write_text(text)
        compiler.compile(source, target)
        check(target)
        with target.open("rb") as file:
            os.fsync(file.fileno())
        replace_file(library.with_suffix(".sha256"), _digest(target, library.name))
        target.replace(library)
