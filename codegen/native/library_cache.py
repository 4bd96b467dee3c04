"""Compiled libraries on disk: built once, checked before they are loaded.

A library is named by the content it is made from, so that an edited axis never meets old code. It
is built in a private folder, tried in a process of its own, and moved into place whole; its digest
stands beside it and is compared before the library is loaded. Only a library that passed its trial
gets a digest, so that none is ever loaded untried.
"""

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

from axisid.support.files import read_regular

from .compiler import FLAGS, Compiler, find_compiler, most_seconds
from .errors import CompilerHangsError, NativeUnavailableError, WrongLibraryError
from .trial import Trial

_LOCK_SECONDS = 300.0
_OLD_SECONDS = 3600.0


def compiled_library(text: str, trial: Callable[[], Trial]) -> Path:
    """Return the path of the library compiled from a C text, building it if need be.

    Parameters
    ----------
    text : str
        C11 source.
    trial : callable
        Makes what a freshly built library is tried by.

    Raises
    ------
    NativeUnavailableError
        There is no compiler, it fails or hangs, the library crashes or computes wrong values, or no
        folder can be written to.
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
            if not _is_private(folder, linked=make is _preferred_folder):
                raise PermissionError(errno.EPERM, "others can write to it")
            with FileLock(folder / f"{name}.lock", timeout=_LOCK_SECONDS):
                if not _is_intact(folder / name):
                    _build(text, compiler, folder / name, trial())
            return folder / name
        except Timeout as error:
            reasons.append(f"another process holds {error.lock_file}")
        except (CompilerHangsError, WrongLibraryError):
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
    for make, linked in ((_preferred_folder, True), (_temporary_folder, False)):
        with contextlib.suppress(OSError, RuntimeError):  # there is no home, or no folder for files
            library = make() / name
            if _is_private(library.parent, linked=linked) and _is_intact(library):
                return library
    return None


def _name(text: str, compiler: Compiler) -> str:
    content = "\0".join([text, *FLAGS, *compiler.command, compiler.identity])
    return f"{hashlib.sha256(content.encode(errors='backslashreplace')).hexdigest()}.so"


def _preferred_folder() -> Path:
    requested = os.environ.get("AXISID_CACHE")
    return Path(requested).absolute() if requested else user_cache_path("axisid") / "native"


def _temporary_folder() -> Path:
    """A folder for this user's processes, where the cache cannot be written to."""
    return Path(tempfile.gettempdir()) / f"axisid-{os.getuid()}"


def _is_private(folder: Path, *, linked: bool) -> bool:
    """Whether nobody else can put a library there; `linked` folders may be links."""
    try:
        status = folder.stat(follow_symlinks=linked)
    except OSError:
        return False
    shared = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not shared


def _digest(library: Path, name: str) -> str:
    """Of the content and the name it goes by: another axis's library in its place is no match."""
    return hashlib.sha256(b"tried\0" + name.encode() + read_regular(library)).hexdigest()


def _is_intact(library: Path) -> bool:
    try:
        return read_regular(library.with_suffix(".sha256")).decode() == _digest(
            library, library.name
        )
    except (OSError, UnicodeDecodeError):
        return False


def _build(text: str, compiler: Compiler, library: Path, trial: Trial) -> None:
    """Compile and try in a private folder beside the library, then move both files into place.

    Raises
    ------
    NativeUnavailableError
        The compiler fails, or the library crashes or computes wrong values.
    OSError
        The folder cannot be written to.
    """
    _clear(library.parent)
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as name:
        folder = Path(name)
        source, target = folder / "native.c", folder / f"{secrets.token_hex(8)}.so"
        source.write_text(text)
        compiler.compile(source, target, most_seconds())
        trial.run(target, most_seconds())
        digest = folder / "sha256"
        digest.write_text(_digest(target, library.name))
        for file in (target, digest):
            with file.open("rb") as written:
                os.fsync(written.fileno())
        digest.replace(library.with_suffix(".sha256"))
        target.replace(library)


def _clear(folder: Path) -> None:
    """Remove what builds left that were killed together with the process that clears up."""
    for left in folder.glob("build-*"):
        with contextlib.suppress(OSError):
            if time.time() - left.lstat().st_mtime >= _OLD_SECONDS:
                shutil.rmtree(left, ignore_errors=True)
