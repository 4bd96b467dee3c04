"""The process in which a library is compiled or tried: run by `run_child`, never imported.

It needs the standard library alone, so that it starts at once. Its task lies in its folder. When
its maker is gone, however that ended, it removes the folder, and ends with what it started.
"""

import ctypes
import os
import pickle
import shutil
import signal
import sys
import time
from _thread import start_new_thread
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

_LOOKS = 0.5  # s between looks whether the maker is alive


def compile_text(command: Sequence[str], output: str) -> int:
    """Run a command, what it says into a file; its exit code, negative for a signal."""
    # Not into a pipe, which what the compiler starts may hold open beyond its end.
    into = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    os.dup2(into, 1)
    os.dup2(into, 2)
    compiler = os.posix_spawn(command[0], list(command), os.environ)
    return os.waitstatus_to_exitcode(os.waitpid(compiler, 0)[1])


def call(path: str, calls: Sequence[tuple[str, Sequence[Any]]]) -> int:
    """Call functions of a library; the content of all arrays after the calls is the reply."""
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        Path("refused").write_text(str(error))
        return 1
    Path("loaded").touch()
    given = [
        (function, [_as_c(argument) for argument in arguments]) for function, arguments in calls
    ]
    for function, arguments in given:
        getattr(library, function)(*arguments)
    arrays = (a.raw for _, arguments in given for a in arguments if isinstance(a, ctypes.Array))
    Path("reply").write_bytes(b"".join(arrays))
    return 0


def _as_c(argument: Any) -> Any:
    if isinstance(argument, bytes):
        return ctypes.create_string_buffer(argument, len(argument))
    if isinstance(argument, float):
        return ctypes.c_double(argument)
    return None if argument is None else ctypes.c_ssize_t(argument)


def _watch(folder: str, parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOKS)
    shutil.rmtree(folder, ignore_errors=True)
    os.killpg(0, signal.SIGKILL)


def main(folder: str, parent: int) -> None:
    """Do the task of a folder, there."""
    os.chdir(folder)
    os.environ["TMPDIR"] = folder  # what a compiler leaves there when it is killed goes with it
    start_new_thread(_watch, (folder, parent))
    task, *arguments = pickle.loads(Path("task").read_bytes())  # noqa: S301
    tasks: dict[str, Callable[..., int]] = {"compile": compile_text, "call": call}
    os._exit(tasks[task](*arguments) & 0xFF)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
