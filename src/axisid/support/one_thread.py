"""Limit numerical libraries to one thread, and turn off warnings about arithmetic.

The matrices of axisid are tall and thin. With several threads, each thread mostly waits for others.
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
    """Set linear algebra to one thread, unless the environment states a number of threads.

    NumPy reads the setting when it is imported.

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
    """Set linear algebra to one thread in processes that are started within the context.

    Afterwards the environment of this process is restored.
    """
    added = one_thread()
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


@functools.lru_cache(maxsize=1)
def _blas_libraries() -> "ThreadpoolController":
    """Return the controller of the linear algebra libraries of NumPy and SciPy, found once."""
    import scipy.linalg  # noqa: F401
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


#: Lock held by the thread that has set the number of threads, which applies to the whole process.
_LIMIT_LOCK = threading.RLock()


def in_one_thread(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """Return a function that runs with linear algebra in one thread.

    A number of threads that is set in the environment is kept. If another thread of this process
    has already set the limit, the function runs without setting it again. On tall and thin matrices
    several threads cost more than they save: 300 QR factorisations of 3000 x 12 took 0.7 s in one
    thread and 80 s in two on a busy machine.
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
    """Turn off NumPy's warnings about arithmetic; results that are not finite are checked later."""
    warnings.filterwarnings("ignore", ".* encountered in ", RuntimeWarning)
