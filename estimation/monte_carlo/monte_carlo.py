"""Monte-Carlo study of an axis: the public function.

The calibration of standard errors by simulated replicas is determined from the first runs and used
for all runs. Replicas for each run, as in `identify`, would multiply the number of simulated loops.
The runs differ only in their noise, so that their estimates have the same bias, and their standard
errors the same relative error.
"""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from time import monotonic
from typing import TypeAlias

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import (
    INSTRUMENT_STARTS,
    ROW_LOSSES,
    fit_names,
    fitted_output,
    method_names,
)
from axisid.estimation.identification import check_choices, requested_methods
from axisid.estimation.noise_models import DEFAULT_TWIN_COUNT, Chain, check_twin_count
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import twin_plan
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Levels
from axisid.modeling.declaration import Axis, Move
from axisid.support.arrays import Array
from axisid.support.checks import check_among, is_whole, listed, refuse
from axisid.support.errors import EstimationError, UsageError
from axisid.support.jobs import Failure, pace, run_jobs
from axisid.support.one_thread import in_one_thread
from axisid.support.progress import Progress
from axisid.support.wording import quoted

from .drawn_twins import noise_of, twin_of
from .plan import MonteCarloPlan
from .result import MonteCarlo
from .runs import (
    INTERVALS,
    BlockNumbers,
    Estimand,
    block_numbers,
    joined,
    lost_block,
)

_CALIBRATION_RUNS = 16  # first runs, from which the calibration is determined
# index of the HAC standard error among the numbers of an estimand, see `BlockNumbers`; both bounds
# of its interval follow
_HAC = 2 + 3 * INTERVALS.index("hac")

_NO_CALIBRATION = np.array([0.0, 1.0, 1.0])  # bias, and factors of standard error and width


@np.errstate(all="ignore")  # of runs without an estimate
def study_calibrations(plan: MonteCarloPlan) -> dict[Estimand, Array]:
    """Return the calibration of each estimand by simulated replicas, (3,).

    The three numbers are the bias, the factor of the HAC standard error, and the factor of the
    width of its interval. They are means over the first runs, which are identified with and without
    replicas. Empty if no replicas or no method of `identify` are planned.
    """
    if not (plan.bootstrap and plan.regressions):
        return {}
    # The first runs with replicas, then the same runs without replicas.
    first = range(min(_CALIBRATION_RUNS, plan.runs))
    estimates_only = replace(plan, methods=plan.regressions, checks=0)
    with_replicas = block_numbers(estimates_only, first, bootstrapped=first.stop)
    both = joined([with_replicas, block_numbers(estimates_only, first)])
    calibrated, plain = np.split(both.numbers, 2)
    bias = calibrated[..., 0] - calibrated[..., 1]
    factors = calibrated[..., _HAC] / plain[..., _HAC]
    widths = (calibrated[..., _HAC + 2] - calibrated[..., _HAC + 1]) / (
        plain[..., _HAC + 2] - plain[..., _HAC + 1]
    )
    figures = np.stack((bias, factors, widths), axis=-1)
    means = np.ma.masked_invalid(figures).mean(axis=0).filled(_NO_CALIBRATION)
    return dict(zip(both.estimands, means, strict=True))


def calibrated_runs(
    numbers: BlockNumbers, calibrations: Mapping[Estimand, Array], judged: int
) -> BlockNumbers:
    """Return the numbers of runs, calibrated for the runs without simulated replicas.

    Values and bounds are corrected for bias; HAC standard errors and intervals are scaled. Runs
    with replicas are unchanged, because their numbers are calibrated already.

    Parameters
    ----------
    numbers : BlockNumbers
        Numbers of the runs, sorted by run.
    calibrations : mapping of Estimand to (3,) array
        As from `study_calibrations`; other estimands are unchanged.
    judged : int
        Number of first runs that have replicas.
    """
    changed, first = numbers.numbers.copy(), int(np.searchsorted(numbers.runs, judged))
    known = [calibrations.get(estimand, _NO_CALIBRATION) for estimand in numbers.estimands]
    bias, scale, width = np.reshape(known, (-1, 3)).T
    own = changed[first:]  # a view: the runs without replicas
    # Subtract the bias from the corrected value, and from both bounds of every interval.
    own[..., 1] -= bias
    own[..., 3::3] -= bias[:, None]
    own[..., 4::3] -= bias[:, None]
    # Scale the HAC standard error, and the HAC interval about the corrected value.
    own[..., _HAC] *= scale
    corrected, ends = own[..., 1:2], own[..., _HAC + 1 : _HAC + 3]
    ends[:] = corrected + (ends - corrected) * width[:, None]
    return replace(numbers, numbers=changed)


_MOST_REASONS = 3  # reasons that are reported if no run gave an estimate

#: Receives the finished runs of a study that ends early.
Keep: TypeAlias = Callable[[MonteCarlo], None]


@in_one_thread
def monte_carlo(
    axis: Axis | GeneratedAxis,
    runs: int = 1000,
    methods: str | Sequence[str] | None = "idm-iv",
    *,
    prefilter: Prefilter | None = None,
    noise: Chain | None = None,
    twin: Axis | GeneratedAxis | None = None,
    truth: Mapping[str, float] | None = None,
    moves: Sequence[Move] | None = None,
    checks: int = 0,
    seed: int = 1,
    covariance: str = "hac",
    lags: int | None = None,
    start: str = INSTRUMENT_STARTS[0],
    loss: str = ROW_LOSSES[0],
    bootstrap: int = DEFAULT_TWIN_COUNT,
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
    jobs: int = 1,
    executor: Executor | None = None,
    block: int = 32,
    progress: Progress | None = None,
    keep: Keep | None = None,
) -> MonteCarlo:
    """Identify many twins of an axis that differ in their noise.

    The random numbers of a run depend on the seed and the number of the run only: its results are
    bit-identical on any process and with any other runs.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis to identify. Without `twin`, it must declare a control law and an experiment.
    runs : int
        Number of twins.
    methods : str or sequence of str, optional
        Names of `METHODS`, or None or ``"all"`` for all methods; and output-error fits by their
        output, such as ``"fit:control"``, with the default settings of `fit`. If a method refuses a
        twin, the run fails, but not the study.
    prefilter : Prefilter, optional
        As in `identify`.
    noise : Chain, optional
        Declared noise, or that estimated from a record (`Estimate.inference`, its ``chains``); the
        experiment's by default.
    twin : Axis or GeneratedAxis, optional
        Axis to simulate; by default the identified axis. Another axis, with other friction or
        another law, shows the effect of a wrong model.
    truth : mapping of str to float, optional
        True values of the twin by name, SI; the experiment's by default.
    moves : sequence of Move, optional
        Motion of the twin; the experiment's by default.
    checks : int
        Number of runs with a verdict, from the first on; a verdict takes several times as long as
        an estimate.
    seed : int
    covariance, lags, start, loss
        As in `identify`; not used by fits.
    bootstrap : int
        Number of simulated replicas for the bias and HAC standard errors of `identify`; 0 for none.
        The first 16 runs are used for all; each run with a verdict has its own replicas.
    level, least_share : float
        As in `identify` and `fit`, for the verdicts.
    jobs : int
        Number of processes. With several processes, new ones are started, so that a script needs
        the guard ``if __name__ == "__main__":``.
    executor : Executor, optional
        Executor that runs the blocks instead of `jobs` processes: one of `concurrent.futures`, or
        that of Dask, ``Client.get_executor()``.
    block : int
        Number of runs that are simulated together in one process.
    progress : callable, optional
        Called with the number of finished runs.
    keep : callable, optional
        Called with the finished runs if the study ends early, such as by Ctrl-C.

    Returns
    -------
    MonteCarlo

    Raises
    ------
    UsageError
        An argument is not valid.
    ModelError
        The axis has no twin.
    EstimationError
        No twin gave an estimate, or an error occurred that is not due to a twin.

    Notes
    -----
    The memory has the signals of one block for each process, and about 0.1 kB of numbers for each
    run and parameter.
    """
    refuse(
        UsageError,
        (
            not (is_whole(block) and block >= 1),
            f"the argument block is {quoted(block)}. Give a whole number of 1 or more",
        ),
        (
            not (is_whole(jobs) and jobs >= 1),
            f"the argument jobs is {quoted(jobs)}. Give a whole number of 1 or more",
        ),
        (
            executor is not None and jobs != 1,
            "both jobs and an executor are given. Give either jobs or an executor",
        ),
        (
            not isinstance(executor, (Executor, type(None))),
            f"the executor is {quoted(executor)}. Give an executor of concurrent.futures, or that "
            "of Dask's Client.get_executor()",
        ),
        (
            not (keep is None or callable(keep)),
            f"the argument keep is {quoted(keep)}. Give a function that takes a MonteCarlo, or "
            "omit keep",
        ),
        code="study",
    )
    generated = as_generated(axis)
    simulated = generated if twin is None else as_generated(twin)
    check_choices(covariance, start, loss)
    check_twin_count(bootstrap)
    twin_axis = twin_of(simulated, {} if truth is None else truth, moves)
    plan = MonteCarloPlan(
        axis=generated,
        twin=twin_axis,
        runs=runs,
        seed=seed,
        methods=_methods(methods),
        noise=noise_of(noise, twin_axis, runs),
        prefilter=Prefilter.given(prefilter).at_rate_of(twin_plan(twin_axis).period),
        checks=min(checks, runs) if is_whole(checks) and is_whole(runs) else checks,
        settings={"covariance": covariance, "lags": lags, "start": start, "loss": loss},
        bootstrap=bootstrap,
        levels=Levels(level=level, least_share=least_share),
    )
    return _run(plan, block, jobs, executor, progress, keep)


def _methods(methods: object) -> tuple[str, ...]:
    """Return the names of the requested methods, then of the requested fits, each once.

    A fit has the name of its output, such as ``fit:control``. None and ``all`` stand for all
    methods, without the fits. A list of fits alone requests no method.

    Raises
    ------
    UsageError
        A name is unknown, or the list is empty.
    """
    if methods is None:
        methods = "all"
    names = listed(methods)
    fits = [each for each in names if isinstance(each, str) and fitted_output(each)]
    for each in fits:
        check_among(("fit", each, fit_names()))
    others = [each for each in names if each not in fits]
    requested: tuple[str, ...] = ()
    if others or not fits:
        requested = requested_methods(others) or method_names()
    return tuple(dict.fromkeys((*requested, *fits)))


def _run(
    plan: MonteCarloPlan,
    block: int,
    jobs: int,
    executor: Executor | None,
    progress: Progress | None,
    keep: Keep | None,
) -> MonteCarlo:
    """Run the study in blocks and return its result, which does not depend on the processes.

    If the study ends early, `keep` is called with the finished runs. The other arguments are those
    of `monte_carlo`.

    Raises
    ------
    EstimationError
        An error occurred that is not due to a twin, or no twin gave an estimate.
    """
    calibrations, runs = study_calibrations(plan), range(plan.runs)
    blocks = [runs[first : first + block] for first in runs[::block]]
    alone = executor is None and min(jobs, len(blocks)) == 1
    # One thread per block if there are several processes.
    work = partial(block_numbers, plan, threads=None if alone else 1)
    jobs = 0 if alone else min(jobs, len(blocks))
    results = run_jobs(work, blocks, total=len(blocks), jobs=jobs, executor=executor)
    begin, done, count = monotonic(), list[BlockNumbers](), 0
    try:
        # Collect the blocks as they finish.
        with contextlib.closing(results):
            for index, result in results:
                runs_of_block = blocks[index]
                if not isinstance(result, Failure):
                    done.append(result)
                elif result.kind == "error":
                    raise EstimationError(
                        f"the runs {runs_of_block[0]} to {runs_of_block[-1]} failed: "
                        f"{result.reason}.",
                        code="study",
                    )
                else:  # the process was killed
                    done.append(lost_block(runs_of_block, result.reason))
                count += len(runs_of_block)
                if progress is not None and count < plan.runs:
                    remaining = pace(count, plan.runs, monotonic() - begin)
                    progress(count, plan.runs, f"twins of {plan.twin.axis.name}, {remaining}")
    except BaseException:
        if keep is not None and done:
            numbers = calibrated_runs(joined(done), calibrations, plan.checks)
            keep(MonteCarlo(plan=plan, numbers=numbers))
        raise
    numbers = joined(done)
    if not numbers.estimands:
        reasons = dict.fromkeys(f"{each.of}: {each.reason}" for each in numbers.failures)
        listed_reasons = "; ".join(each.removesuffix(".") for each in [*reasons][:_MOST_REASONS])
        raise EstimationError(
            f"no twin gave an estimate. {listed_reasons}.", code="no-twin-identified"
        )
    return MonteCarlo(plan=plan, numbers=calibrated_runs(numbers, calibrations, plan.checks))
