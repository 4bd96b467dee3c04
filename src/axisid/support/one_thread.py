"""Keep numerical libraries from using their own threads and from arithmetic warnings.

Matrices here are tall and thin, and more threads only wait.
"""

import contextlib
import functools
import os
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

Given = ParamSpec("Given")
Found = TypeVar("Found")

_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")


def one_thread() -> list[str]:
    """Have linear algebra in one thread where the user says nothing; NumPy reads it when imported.

    Returns
    -------
    list of str
        The variables of the environment that were set.
    """
    added = [name for name in _COUNTS if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    return added


@contextlib.contextmanager
def started_with_one_thread() -> Iterator[None]:
    """Have it in one thread in the processes that are started now, and here as it was."""
    added = one_thread()
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


@functools.lru_cache(maxsize=1)
def _blas_libraries() -> "ThreadpoolController":
    """Find the linear algebra of NumPy and SciPy, each of which has its own."""
    import scipy.linalg  # noqa: F401
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


#: Held by the thread of the program that has set the number, which is the whole process's.
_LIMIT_LOCK = threading.RLock()


def in_one_thread(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """Run a function with linear algebra in one thread, unless the environment says how many.

    Threads that wait for each other cost more than they save on tall and thin matrices: 300 QR
    factorisations of 3000 x 12 took 0.7 s in one thread and 80 s in two on a busy machine.
    """

    @functools.wraps(function)
    def limited(*values: Given.args, **named: Given.kwargs) -> Found:
        is_set_by_user = any(name in os.environ for name in _COUNTS)
        if is_set_by_user or not _LIMIT_LOCK.acquire(blocking=False):
            return function(*values, **named)
        try:
            with _blas_libraries().limit(limits=1, user_api="blas"):
                return function(*values, **named)
        finally:
            _LIMIT_LOCK.release()

    return limited


def without_arithmetic_warnings() -> None:
    """Have this process say nothing of its arithmetic: what comes of it is judged and told."""
    warnings.filterwarnings("ignore", ".* encountered in ", RuntimeWarning)
