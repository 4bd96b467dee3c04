"""A library's function has linear algebra in one thread, and leaves the caller's as it was."""

import subprocess
import sys
from collections.abc import Iterator

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from axisid.support.one_thread import in_one_thread

NAMES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")

SCRIPT = """
import threading
import numpy, scipy.linalg
from threadpoolctl import threadpool_info
from axisid.support.one_thread import in_one_thread

def threads():
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}

before = threads()
print(in_one_thread(threads)() == {1}, threads() == before)

# The call that began first ends first.
began, leave = threading.Event(), threading.Event()

@in_one_thread
def second():
    began.set()
    leave.wait()

@in_one_thread
def first():
    other.start()
    began.wait()
    return threads()

other = threading.Thread(target=second)
print(first() == {1})
leave.set()
other.join()
print(threads() == before)
"""


def threads() -> set[int]:
    """Threads of every linear algebra that is loaded."""
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


@pytest.fixture
def two_threads(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    with threadpool_limits(limits=2, user_api="blas"):
        yield


def test_every_linear_algebra_has_one_thread_inside_and_its_own_after_calls_that_overlap() -> None:
    clean = {"PYTHONPATH": ":".join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=clean, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["True"] * 4


@pytest.mark.usefixtures("two_threads")
def test_a_call_within_a_call_and_an_error_leave_the_caller_as_it_was() -> None:
    outer = in_one_thread(lambda: (in_one_thread(threads)(), threads()))
    assert outer() == ({1}, {1})
    assert threads() == {2}
    with pytest.raises(ZeroDivisionError):
        in_one_thread(lambda: 1 / 0)()
    assert threads() == {2}


@pytest.mark.usefixtures("two_threads")
def test_what_the_environment_says_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    assert in_one_thread(threads)() == {2}
