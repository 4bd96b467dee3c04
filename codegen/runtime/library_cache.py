"""Compiled libraries on disk: built once by the system's compiler, checked before they are loaded.

The name of a library is a hash of the text from which it is made, so that an edited axis never uses
old code. A library is built in a private folder, tested, and moved to its final path as a whole.
Its digest is stored next to it and compared before the library is loaded. Only a library that
passed its test gets a digest.

Zig's compiler is used if there is no other compiler. The flags keep IEEE semantics (no fused
operations, no fast-math), so that native results and results of the CasADi virtual machine agree to
rounding.
"""

import contextlib
import errno
import hashlib
import importlib.util
import os
import platform
import secrets
import shlex
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout
from platformdirs import user_cache_path

from axisid.support.files import read_regular

FLAGS = (
    "-std=c11",
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fPIC",
    "-shared",
)
_SECONDS = 120.0  # longest time for a compilation
_MOST_OUTPUT = 100_000  # bytes of the compiler's output that are read


class NativeUnavailableError(Exception):
    """Native code is unavailable, for the reason in the message, so the virtual machine is used."""


@dataclass(frozen=True, slots=True)
class Compiler:
    """A C compiler.

    Attributes
    ----------
    command : tuple of str
        Command, before flags and files.
    identity : str
        Text that changes when the compiler or the processor does.
    """

    command: tuple[str, ...]
    identity: str

    def compile(self, source: Path, target: Path, seconds: float = _SECONDS) -> None:
        """Compile a C file into a shared library in the same folder.

        Raises
        ------
        NativeUnavailableError
            The compiler fails, or takes longer than `seconds`; its processes are then killed.
        """
        command = [*self.command, *FLAGS, source.name, "-o", target.name, "-lm"]
        # Output to a file: a pipe could be kept open by processes that the compiler started.
        with source.with_name("output").open("w+b") as output:
            process = subprocess.Popen(  # noqa: S603
                command,
                cwd=source.parent,
                env={**os.environ, "TMPDIR": str(source.parent)},  # for its temporary files
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                start_new_session=True,  # so that only this process gets Ctrl-C
            )
            try:
                code = process.wait(seconds)
            except subprocess.TimeoutExpired:
                raise NativeUnavailableError(
                    f"{command[0]} did not finish within {seconds:g} s"
                ) from None
            finally:  # kill the processes that the compiler started, too
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            output.seek(0)
            lines = output.read(_MOST_OUTPUT).decode(errors="replace").strip().splitlines()
        if code != 0 or not target.is_file():
            # The first line with an error, otherwise the last line.
            errors = [line for line in lines if "error" in line] or lines[-1:]
            reason = errors[0] if errors else f"exit code {code}"
            raise NativeUnavailableError(f"{self.command[0]} failed: {reason}")


def find_compiler() -> Compiler:
    """Return ``$CC``, a compiler on the path, or Zig's compiler (the extra ``native``).

    Raises
    ------
    NativeUnavailableError
        There is no compiler, or the system is not a POSIX system.
    """
    if not hasattr(os, "getuid"):
        raise NativeUnavailableError("native code needs a POSIX system, such as Linux or macOS")
    requested = os.environ.get("CC")
    for name in [requested] if requested else ["cc", "gcc", "clang"]:
        try:
            words = shlex.split(name)
        except ValueError as error:
            raise NativeUnavailableError(
                f"the compiler CC={name!r} cannot be read: {error}"
            ) from error
        found = shutil.which(words[0]) if words else None
        if found is not None:
            path = Path(found).absolute()
            return Compiler((str(path), *words[1:]), _identity(path))
    if requested:
        raise NativeUnavailableError(f"the compiler CC={requested!r} was not found")
    zig = importlib.util.find_spec("ziglang")
    if zig is not None and zig.origin is not None:
        return Compiler((sys.executable, "-m", "ziglang", "cc"), _identity(Path(zig.origin)))
    raise NativeUnavailableError(
        "there is no C compiler (install one, or pip install 'axisid[native]')"
    )


def _identity(executable: Path) -> str:
    """Return a text that changes when the file of a compiler or the processor changes."""
    real = executable.resolve()
    status = real.stat()
    processor = platform.processor()  # the processor features on which -march=native depends
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        found = (line for line in lines if line.startswith(("flags", "Features")))
        processor = next(found, processor)
    return f"{real} {status.st_size} {status.st_mtime_ns} {platform.machine()} {processor}"


_LOCK_SECONDS = 300.0  # longest wait for another process that builds the same library
_LOAD_SECONDS = 60.0  # longest time to load a library for its test
_OLD_SECONDS = 3600.0  # age of a folder of an interrupted build that is deleted


def compiled_library(text: str, check: Callable[[Path], object] = lambda _: None) -> Path:
    """Return the path of the library compiled from a C text; build it if it is not in the cache.

    Parameters
    ----------
    text : str
        C11 source.
    check : callable
        Function that is called with the path of a library after it is built. It raises an error if
        the library is wrong.

    Raises
    ------
    NativeUnavailableError
        There is no compiler, the compiler fails or hangs, the library does not load or is refused,
        or the cache cannot be written to.
    """
    compiler = find_compiler()
    name = _name(text, compiler)
    try:
        folder = _folder()
        if _is_private(folder) and _is_intact(folder / name):
            return folder / name
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(folder):
            raise PermissionError(errno.EPERM, "other users can write to it", str(folder))
        with FileLock(folder / f"{name}.lock", timeout=_LOCK_SECONDS):
            if not _is_intact(folder / name):
                _build(text, compiler, folder / name, check)
        return folder / name
    except Timeout as error:
        raise NativeUnavailableError(
            f"another process has locked {error.lock_file} for {_LOCK_SECONDS:g} s"
        ) from error
    except (OSError, RuntimeError) as error:
        raise NativeUnavailableError(
            f"{error} (choose another folder with AXISID_CACHE)"
        ) from error


def cached_library(text: str) -> Path | None:
    """Return the path of the library of a C text; None if it is not in the cache or not intact."""
    # RuntimeError: the user has no home folder.
    with contextlib.suppress(NativeUnavailableError, OSError, RuntimeError):
        library = _folder() / _name(text, find_compiler())
        if _is_private(library.parent) and _is_intact(library):
            return library
    return None


def _name(text: str, compiler: Compiler) -> str:
    """Return the file name of a library: a hash of the C text, the flags and the compiler."""
    content = "\0".join([text, *FLAGS, *compiler.command, compiler.identity])
    return f"{hashlib.sha256(content.encode(errors='backslashreplace')).hexdigest()}.so"


def _folder() -> Path:
    """Return the folder of compiled libraries: ``$AXISID_CACHE``, or one in the user's cache."""
    requested = os.environ.get("AXISID_CACHE")
    return Path(requested).absolute() if requested else user_cache_path("axisid") / "native"


def _is_private(folder: Path) -> bool:
    """Return True if only this user can write into a folder."""
    try:
        status = folder.stat()
    except OSError:
        return False
    shared = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not shared


def _digest(library: Path, name: str) -> str:
    """Return the SHA-256 of a library's content and name, as hexadecimal text.

    The name is included so that a library of another axis does not match.
    """
    return hashlib.sha256(b"tried\0" + name.encode() + read_regular(library)).hexdigest()


def _is_intact(library: Path) -> bool:
    """Return True if a library exists and matches the digest that was stored after its test."""
    try:
        return read_regular(library.with_suffix(".sha256")).decode() == _digest(
            library, library.name
        )
    except (OSError, UnicodeDecodeError):
        return False


def _build(text: str, compiler: Compiler, library: Path, check: Callable[[Path], object]) -> None:
    """Compile a library, test it, and move it with its digest to the final path.

    The library is built in a private folder next to the final path. It is first loaded in another
    process, because a truncated library would end this process. Then `check` is called.

    Raises
    ------
    NativeUnavailableError
        The compiler fails, or the library does not load or computes wrong values.
    """
    # Delete the folders of builds whose process was killed.
    for old in library.parent.glob("build-*"):
        with contextlib.suppress(OSError):
            if time.time() - old.lstat().st_mtime >= _OLD_SECONDS:
                shutil.rmtree(old, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as name:
        folder = Path(name)
        # A new name, because a path that was already loaded would give the old code.
        source, target = folder / "native.c", folder / f"{secrets.token_hex(8)}.so"
        source.write_text(text)
        compiler.compile(source, target)
        load = "import ctypes, sys; ctypes.CDLL(sys.argv[1])"
        command = [sys.executable, "-c", load, str(target)]
        try:
            subprocess.run(command, capture_output=True, timeout=_LOAD_SECONDS, check=True)  # noqa: S603
        except (OSError, subprocess.SubprocessError) as error:
            raise NativeUnavailableError("the compiled library cannot be loaded") from error
        check(target)
        digest = folder / "sha256"
        digest.write_text(_digest(target, library.name))
        for file in (target, digest):
            with file.open("rb") as written:
                os.fsync(written.fileno())
        digest.replace(library.with_suffix(".sha256"))
        target.replace(library)
