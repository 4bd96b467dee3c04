"""What numerical libraries do not do here: work in threads of their own, and warn of arithmetic.

Matrices here are tall and thin, and more threads only wait.
"""

import contextlib
import os
import warnings
from collections.abc import Iterator

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


def without_arithmetic_warnings() -> None:
    """Have this process say nothing of its arithmetic: what comes of it is judged and told."""
    warnings.filterwarnings("ignore", ".* encountered in ", RuntimeWarning)
