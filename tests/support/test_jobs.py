"""Jobs on processes and executors: none harms another, and each has one thread of algebra."""

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from operator import itemgetter
from pathlib import Path
from typing import Any

import pytest

from axisid.support.jobs import Failure, pace, run_jobs
from axisid.support.one_thread import one_thread, started_with_one_thread
from tests.refusals import refuses
from tests.support.work import FAILS, HANGS, KILLS, double, double_at_second_attempt, square


def outcomes(items: list[int], **how: Any) -> list[int | Failure]:
    """By place; each has one."""
    found = sorted(run_jobs(double, items, total=len(items), **how), key=itemgetter(0))
    assert [place for place, _ in found] == list(range(len(items)))
    return [made for _, made in found]


def kinds(found: Iterable[int | Failure]) -> list[object]:
    return [each.kind if isinstance(each, Failure) else each for each in found]


def test_in_this_process_what_raises_is_told_and_the_others_go_on() -> None:
    found = outcomes([1, FAILS, 3], jobs=0)
    assert kinds(found) == [2, "error", 6]
    assert found[1].reason == "ValueError: no number to double"


def test_a_process_says_nothing_of_its_arithmetic(capfd: pytest.CaptureFixture[str]) -> None:
    ((_, found),) = run_jobs(square, [1e200], total=1, jobs=1)
    assert found == math.inf
    assert capfd.readouterr().err == ""


def test_an_executor_does_what_it_is_given() -> None:
    with ThreadPoolExecutor(2) as executor:
        assert kinds(outcomes([1, FAILS, 3], executor=executor)) == [2, "error", 6]


@pytest.mark.slow
def test_a_process_that_dies_or_hangs_takes_its_item_alone() -> None:
    found = outcomes([1, KILLS, HANGS, FAILS, *range(4, 30)], jobs=2, limit=3.0)
    assert kinds(found) == [2, "killed", "time", "error", *range(8, 60, 2)]
    assert found[1].reason == "its process was killed 2 times (SIGKILL)"


@pytest.mark.slow
def test_the_item_of_a_process_that_was_killed_once_is_done_anew(tmp_path: Path) -> None:
    items = [(str(tmp_path / "mark"), 3)]
    ((_, found),) = run_jobs(double_at_second_attempt, items, total=1, jobs=1)
    assert found == 6


@pytest.mark.slow
def test_an_executor_whose_process_dies_is_refused() -> None:
    executor: Executor
    with (
        ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor,
        refuses("jobs", "the executor is broken"),
    ):
        outcomes([*range(20), KILLS, *range(20, 40)], executor=executor)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="an interrupt is a signal")
def test_an_interrupt_ends_all_processes_within_two_seconds(root: Path) -> None:
    run = _hanging(root)
    begin = time.monotonic()
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does: to all processes
    _, said = run.communicate(timeout=10)  # to the end of the pipes, which workers have too
    assert time.monotonic() - begin < 2.0
    assert said.count("Traceback") == 1, said  # ours, and none of a worker


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="it is killed by a signal")
@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_a_process_that_is_killed(root: Path, by: signal.Signals) -> None:
    run = _hanging(root)
    begin = time.monotonic()
    run.send_signal(by)  # to this process alone
    run.communicate(timeout=10)  # to the end of the pipes, which workers have too
    assert time.monotonic() - begin < 2.0


def _hanging(root: Path) -> "subprocess.Popen[str]":
    """A program whose two workers hang."""
    program = (
        "import signal\n"
        "from axisid.support.jobs import run_jobs\n"
        "from tests.support.work import HANGS, double\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a background has none
        "    for _ in run_jobs(double, [1, HANGS, HANGS], total=3, jobs=2):\n"
        "        print('begun', flush=True)\n"
    )
    run = subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=root,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert run.stdout.readline() == "begun\n"
    return run


@pytest.mark.parametrize(
    ("done", "seconds", "said"),
    [(10, 5.0, "2 a second, 45 s left"), (1, 100.0, "0.01 a second, 2.8 h left")],
)
def test_progress_tells_the_rate_and_what_remains(done: int, seconds: float, said: str) -> None:
    assert pace(done, 100, seconds) == said


COMMAND = """
import os, sys
from axisid.commands.main import main
sys.argv = ["axisid", "--version"]
try:
    main()
finally:
    print(os.environ["OPENBLAS_NUM_THREADS"], "numpy" in sys.modules)
"""


@pytest.mark.parametrize(("said", "taken"), [(None, "1"), ("3", "3")])
def test_commands_say_so_before_numpy_is_imported(said: str | None, taken: str) -> None:
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    if said is not None:
        environment["OPENBLAS_NUM_THREADS"] = said
    done = subprocess.run(
        [sys.executable, "-c", COMMAND], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == f"{taken} False"


def test_what_the_user_said_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    monkeypatch.delenv("BLIS_NUM_THREADS", raising=False)
    with started_with_one_thread():
        assert (os.environ["OMP_NUM_THREADS"], os.environ["MKL_NUM_THREADS"]) == ("4", "1")
    assert "MKL_NUM_THREADS" not in os.environ
    assert one_thread() == ["MKL_NUM_THREADS", "BLIS_NUM_THREADS"]
    for name in ("MKL_NUM_THREADS", "BLIS_NUM_THREADS"):
        monkeypatch.delenv(name)
