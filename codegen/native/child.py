"""A process of its own for what may crash or hang: a compiler, or a library nobody has tried."""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from .errors import NativeUnavailableError

_PROCESS = Path(__file__).with_name("child_process.py")


def run_child(folder: Path, seconds: float, task: Sequence[object]) -> int:
    """Do a task of `child_process` in a folder; its exit code, negative for a signal.

    Whatever it started ends with it. When this process is gone, even killed, the other ends and
    removes the folder.

    Raises
    ------
    NativeUnavailableError
        No such process can be started.
    TimeoutError
        It does not end in time.
    """
    if not sys.executable or getattr(sys, "frozen", False):
        raise NativeUnavailableError("there is no Python interpreter to try a library in")
    (folder / "task").write_bytes(pickle.dumps(task))
    try:
        process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-I", "-S", str(_PROCESS), str(folder), str(os.getpid())],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for this process to answer
        )
    except OSError as error:
        raise NativeUnavailableError(f"{sys.executable} does not run: {error.strerror}") from error
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        raise TimeoutError(f"it does not return within {seconds:g} s") from None
    finally:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
