"""Blocks of runs one after the other, in processes of this machine, or by any executor."""

import contextlib
import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field

from axisid.support.errors import EstimationError, UsageError
from axisid.support.progress import Progress
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

from .plan import MonteCarloPlan
from .runs import BlockNumbers, block_numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Spreading:
    """How the runs are spread; what they give does not depend on it.

    Attributes
    ----------
    block : int
        Runs of a block, which are simulated side by side.
    jobs : int
        Processes of this machine; 1 for none but this one.
    executor : Executor or None
        That takes the blocks in their place.
    """

    block: int = 16
    jobs: int = 1
    executor: Executor | None = None

    def __post_init__(self) -> None:
        for what, value in (("block", self.block), ("jobs", self.jobs)):
            if not (is_whole(value) and value >= 1):
                raise UsageError(
                    f"{what}={quoted(value)}; give a whole number of 1 or more.",
                    code="monte-carlo-spread",
                )
        if self.executor is not None and self.jobs > 1:
            raise UsageError(
                "both jobs and an executor are given; give one of them.", code="monte-carlo-spread"
            )
        if self.executor is not None and not isinstance(self.executor, Executor):
            raise UsageError(
                f"the executor is {quoted(self.executor)}; give one of concurrent.futures, or what "
                "Dask's Client.get_executor() gives.",
                code="monte-carlo-spread",
            )

    def blocks(self, runs: int) -> list[tuple[int, int]]:
        """First run of each block and the one after its last."""
        return [(start, min(start + self.block, runs)) for start in range(0, runs, self.block)]


@dataclass(slots=True)
class Done:
    """The blocks that are done, whatever ends the others.

    Attributes
    ----------
    plan : MonteCarloPlan
    progress : Progress or None
        Told of runs.
    blocks : list of BlockNumbers
        In the order in which they were done.
    runs : int
        In them.
    """

    plan: MonteCarloPlan
    progress: Progress | None
    blocks: list[BlockNumbers] = field(default_factory=list)
    runs: int = 0

    def say(self) -> None:
        """Tell how many runs are done."""
        if self.progress is not None:
            self.progress(self.runs, self.plan.runs, f"twins of {self.plan.twin.axis.name}")

    def add(self, block: BlockNumbers) -> None:
        """Keep a block, and tell of it."""
        self.blocks.append(block)
        self.runs += len(block.runs)
        if self.runs < self.plan.runs:
            self.say()


def spread(done: Done, spreading: Spreading) -> None:
    """Run every block into `done`, which has what was done before whatever is raised.

    Raises
    ------
    EstimationError
        A process ended before its block.
    """
    blocks = spreading.blocks(done.plan.runs)
    done.say()
    if spreading.executor is not None:
        _submitted(done, blocks, spreading.executor)
    elif spreading.jobs > 1 and len(blocks) > 1:
        with _processes(min(spreading.jobs, len(blocks))) as pool:
            _submitted(done, blocks, pool)
    else:
        for start, stop in blocks:
            done.add(block_numbers(done.plan, start, stop))


def _submitted(done: Done, blocks: Sequence[tuple[int, int]], executor: Executor) -> None:
    # One thread of a worker simulates: there are as many workers as processors can serve.
    futures = [executor.submit(block_numbers, done.plan, *block, threads=1) for block in blocks]
    try:
        for future in as_completed(futures):
            done.add(future.result())
    except BrokenExecutor as error:
        raise EstimationError(
            f"a process that ran twins has ended, killed or out of memory; {done.runs} of "
            f"{done.plan.runs} runs are done. Use fewer jobs, or smaller blocks.",
            code="monte-carlo-worker",
        ) from error
    finally:
        for future in futures:
            future.cancel()


@contextlib.contextmanager
def _processes(jobs: int) -> Iterator[Executor]:
    """A pool of new processes, which are ended at once where anything is raised."""
    before = {*multiprocessing.active_children()}
    pool = ProcessPoolExecutor(
        jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_leave_interrupts
    )
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in {*multiprocessing.active_children()} - before:
            child.terminate()
        raise
    pool.shutdown()


def _leave_interrupts() -> None:
    """Ctrl-C goes to every process of a terminal; the one that started the others ends them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
