"""The system's C compiler, or Zig's where there is none.

Flags keep IEEE semantics: no contraction to fused operations and no fast-math, so that native
results are those of the CasADi virtual machine to rounding.
"""

import contextlib
import importlib.util
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

FLAGS = (
    "-std=c11",
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fPIC",
    "-shared",
)
_SECONDS = 120.0
_MOST_OUTPUT = 100_000


class NativeUnavailableError(Exception):
    """Native code cannot be had; the message says why, and the virtual machine serves instead."""


@dataclass(frozen=True, slots=True)
class Compiler:
    """A C compiler.

    Attributes
    ----------
    command : tuple of str
        What is run, before flags and files.
    identity : str
        Changes when the compiler or the processor does.
    """

    command: tuple[str, ...]
    identity: str

    def compile(self, source: Path, target: Path, seconds: float = _SECONDS) -> None:
        """Compile one file into a shared library, both in one folder.

        Raises
        ------
        NativeUnavailableError
            The compiler fails or hangs; what it started is ended.
        """
        command = [*self.command, *FLAGS, source.name, "-o", target.name, "-lm"]
        # Not into a pipe, which what the compiler starts may hold open beyond its end.
        with source.with_name("output").open("w+b") as output:
            code = _run(command, source.parent, output, seconds)
            output.seek(0)
            said = output.read(_MOST_OUTPUT).decode(errors="replace").strip().splitlines()
        if code != 0 or not target.is_file():
            telling = [line for line in said if "error" in line] or said[-1:]
            reason = telling[0] if telling else f"exit code {code}"
            raise NativeUnavailableError(f"{self.command[0]} failed: {reason}")


def _run(command: Sequence[str], folder: Path, output: IO[bytes], seconds: float) -> int:
    """The exit code of a command; whatever it started ends with it."""
    process = subprocess.Popen(  # noqa: S603
        command,
        cwd=folder,
        env={**os.environ, "TMPDIR": str(folder)},  # what it leaves goes with the folder
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=output,
        start_new_session=True,  # Ctrl-C is for this process to answer
    )
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        reason = f"{command[0]} did not finish within {seconds:g} s"
        raise NativeUnavailableError(reason) from None
    finally:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def find_compiler() -> Compiler:
    """Return ``$CC``, a compiler on the path, or Zig's (the extra ``native``).

    Raises
    ------
    NativeUnavailableError
        There is none, or the system is none that a library could be tried on.
    """
    if not hasattr(os, "getuid"):
        raise NativeUnavailableError("it needs a POSIX system, such as Linux or macOS")
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
        raise NativeUnavailableError(f"the compiler CC={requested!r} is not found")
    zig = importlib.util.find_spec("ziglang")
    if zig is not None and zig.origin is not None:
        command = (sys.executable, "-m", "ziglang", "cc")
        return Compiler(command, _identity(Path(zig.origin)))
    raise NativeUnavailableError(
        "there is no C compiler (install one, or pip install 'axisid[native]')"
    )


def _identity(executable: Path) -> str:
    real = executable.resolve()
    status = real.stat()
    processor = platform.processor()  # what -march=native depends on
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        found = (line for line in lines if line.startswith(("flags", "Features")))
        processor = next(found, processor)
    return f"{real} {status.st_size} {status.st_mtime_ns} {platform.machine()} {processor}"
