"""The system's C compiler, or Zig's where there is none.

Flags keep IEEE semantics: no contraction to fused operations and no fast-math, so that native
results are those of the CasADi virtual machine to rounding.
"""

import contextlib
import importlib.util
import math
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

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


class CompilerHangsError(NativeUnavailableError):
    """The compiler did not finish in time; trying elsewhere would take as long again."""


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

    def compile(self, source: Path, target: Path) -> None:
        """Compile one file into a shared library.

        Raises
        ------
        NativeUnavailableError
            The compiler fails or hangs; what it started is ended.
        """
        seconds = _seconds()
        command = [*self.command, *FLAGS, source.name, "-o", target.name, "-lm"]
        # Into a file: what the compiler starts may outlive it and hold a pipe open.
        with (source.parent / "output").open("w+b") as output:
            try:
                process = subprocess.Popen(  # noqa: S603
                    command,
                    cwd=source.parent,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            except OSError as error:
                raise NativeUnavailableError(
                    f"{self.command[0]} does not run: {error.strerror}"
                ) from error
            try:
                process.wait(timeout=seconds)
            except subprocess.TimeoutExpired:
                raise CompilerHangsError(
                    f"{self.command[0]} did not finish within {seconds:g} s"
                ) from None
            finally:
                _end(process)
            output.seek(0)
            said = output.read(_MOST_OUTPUT).decode(errors="replace").strip().splitlines()
        if process.returncode != 0 or not target.is_file():
            telling = [line for line in said if "error" in line] or said[-1:]
            reason = telling[0] if telling else f"exit code {process.returncode}"
            raise NativeUnavailableError(f"{self.command[0]} failed: {reason}")


def find_compiler() -> Compiler:
    """Return ``$CC``, a compiler on the path, or Zig's (the extra ``native``).

    Raises
    ------
    NativeUnavailableError
        There is none.
    """
    asked = os.environ.get("CC")
    for name in [asked] if asked else ["cc", "gcc", "clang"]:
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
    if asked:
        raise NativeUnavailableError(f"the compiler CC={asked!r} is not found")
    zig = importlib.util.find_spec("ziglang")
    if zig is not None and zig.origin is not None:
        command = (sys.executable, "-m", "ziglang", "cc")
        return Compiler(command, _identity(Path(zig.origin)))
    raise NativeUnavailableError(
        "there is no C compiler (install one, or pip install 'axisid[native]')"
    )


def _seconds() -> float:
    """Time limit, from AXISID_COMPILE_SECONDS if that is a sensible number."""
    with contextlib.suppress(ValueError):
        seconds = float(os.environ.get("AXISID_COMPILE_SECONDS", _SECONDS))
        if math.isfinite(seconds) and 0 < seconds < 1e6:
            return seconds
    return _SECONDS


def _identity(executable: Path) -> str:
    real = executable.resolve()
    status = real.stat()
    return f"{real} {status.st_size} {status.st_mtime_ns} {platform.machine()} {_processor()}"


def _processor() -> str:
    """What -march=native depends on."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith(("flags", "Features")):
                return line
    return platform.processor()


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End the compiler and whatever it started."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
