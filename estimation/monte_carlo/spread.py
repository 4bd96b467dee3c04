"""Blocks of runs one after the other, in processes of this machine, or by any executor."""

from collections.abc import Generator, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from time import monotonic

from axisid.support.errors import EstimationError, UsageError
from axisid.support.jobs.outcome import Outcome
from axisid.support.jobs.run import pace, run_jobs
from axisid.support.progress import Progress
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

from .plan import MonteCarloPlan
from .runs import BlockNumbers, block_numbers, lost_block

Block = tuple[int, int]  # first run and the one after the last


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

    block: int = 32
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
                "both jobs and an executor are given; give one of them.", code="monte-carlo-both"
            )
        if self.executor is not None and not isinstance(self.executor, Executor):
            raise UsageError(
                f"the executor is {quoted(self.executor)}; give one of concurrent.futures, or what "
                "Dask's Client.get_executor() gives.",
                code="monte-carlo-executor",
            )

    def numbers(self, plan: MonteCarloPlan) -> Generator[BlockNumbers, None, None]:
        """The numbers of each block, as they come.

        Raises
        ------
        EstimationError
            Something failed that no twin is to blame for.
        """
        blocks = [
            (start, min(start + self.block, plan.runs)) for start in range(0, plan.runs, self.block)
        ]
        jobs = min(self.jobs, len(blocks))
        alone = self.executor is None and jobs == 1
        # In one thread with others beside it: there are as many as processors can serve.
        work = partial(_block_numbers, plan, None if alone else 1)
        jobs = 0 if alone else jobs
        for outcome in run_jobs(work, blocks, total=len(blocks), jobs=jobs, executor=self.executor):
            yield _numbers(outcome, blocks[outcome.place])


def _block_numbers(plan: MonteCarloPlan, threads: int | None, block: Block) -> BlockNumbers:
    return block_numbers(plan, *block, threads=threads)


def _numbers(outcome: Outcome[BlockNumbers], block: Block) -> BlockNumbers:
    """What a worker gave; of one that was killed, which runs are lost."""
    if outcome.value is not None:
        return outcome.value
    reason = "" if outcome.failure is None else outcome.failure.reason
    if outcome.failure is not None and outcome.failure.kind == "error":
        raise EstimationError(
            f"the runs {block[0]} to {block[1] - 1} failed: {reason}.",
            code="monte-carlo-worker",
        )
    return lost_block(*block, reason)


def take_blocks(
    numbers: Iterator[BlockNumbers],
    plan: MonteCarloPlan,
    progress: Progress | None,
    taken: list[BlockNumbers],
) -> None:
    """Take blocks as they come, and tell of them; what is taken stays, whatever ends the others.

    Parameters
    ----------
    numbers : iterator of BlockNumbers
    plan : MonteCarloPlan
    progress : Progress or None
        Told how many runs are done.
    taken : list of BlockNumbers
        That blocks are added to, in the order in which they are done.
    """
    begin, done, total = monotonic(), 0, plan.runs
    named = f"twins of {plan.twin.axis.name}"
    for block in numbers:
        taken.append(block)
        done += len(block.runs)
        if progress is not None and done < total:
            progress(done, total, f"{named}, {pace(done, total, monotonic() - begin)}")
