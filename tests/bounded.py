"""Bounds on work, in calls of functions: what makes more of them would hang for a user.

Unlike seconds, calls are the same on a machine that others use. They count Python's own functions,
of which nearly all of SymPy's work is; what waits for another process or runs in compiled code has
no calls, and its test says what it waits for.
"""

import cProfile
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def within(calls: int) -> Iterator[None]:
    """Fail if the work makes more calls of functions than so many."""
    profile = cProfile.Profile(subcalls=False, builtins=False)
    with profile:
        yield
    made = sum(entry.callcount for entry in profile.getstats())
    assert made <= calls, f"the work makes {made} calls of functions, more than {calls}"
