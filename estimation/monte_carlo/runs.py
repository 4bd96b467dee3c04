"""Numbers of a block of runs: the estimates of each twin, or the reason of a failure.

A study only calls `block_numbers`; another way to identify many twins would replace it.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.batched import identify_lanes
from axisid.estimation.choices import fitted_output
from axisid.estimation.estimates import COVARIANCES, Value, student_interval
from axisid.estimation.identification import Identification, identify
from axisid.estimation.output_error import OutputFit, fit
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .drawn_twins import are_lanes, twin_lanes, twins
from .plan import COLOURED, IID, MonteCarloPlan

#: Standard error, and both bounds of the interval.
Interval: TypeAlias = tuple[float, tuple[float, float]]

#: Kind of the intervals that include the effect of the model error, of runs with a verdict.
MODEL_ERROR = "model"
#: Kinds of intervals: by each covariance, for coloured errors of a fit, and for the model error.
INTERVALS = (*COVARIANCES, COLOURED, MODEL_ERROR)
_WIDTH = 2 + 3 * len(INTERVALS)  # numbers of an estimand in a run
#: Kinds of estimands: an identified parameter, a parameter of the direct model, or a declared
#: parameter that follows from others.
Kind: TypeAlias = Literal["parameter", "direct", "physical"]
PARAMETER: Kind = "parameter"
DIRECT: Kind = "direct"
PHYSICAL: Kind = "physical"
#: Statuses of a check, by their number in `BlockNumbers.statuses`; -1 for a run without the check.
STATUSES = ("pass", "note", "fail", "not evaluated")
#: Parts of a run that fail for all methods: its simulation, and its verdict.
SIMULATION, VERDICT = "simulation", "verdict"


@dataclass(frozen=True, slots=True)
class Estimand:
    """A quantity that a method estimates in every run.

    Attributes
    ----------
    method : str
        Method of `identify`, or an output-error fit such as ``fit:control``.
    name : str
        Name of the parameter.
    kind : {"parameter", "direct", "physical"}
        An identified parameter; a parameter of the direct model; a declared parameter that follows
        from base parameters and known values.
    unit : str
    """

    method: str
    name: str
    kind: Kind
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedRun:
    """Failure of a run, of one method or of all.

    Attributes
    ----------
    run : int
        Number of the run, from 0.
    of : str
        The method that failed; ``simulation`` if the twin could not be simulated, ``verdict`` if
        the checks could not be evaluated.
    reason : str
        Message of the error.
    """

    run: int
    of: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockNumbers:
    """Estimates and statuses of checks of some runs of a study.

    Attributes
    ----------
    runs : (b,) array of int
        Numbers of the runs.
    estimands : tuple of Estimand
        Quantities that the methods estimate, length e.
    numbers : (b, e, 2 + 3 i) array
        Value, value minus the bias of filter and noise, then standard error and both bounds for
        each of `INTERVALS`; not a number if missing.
    checks : tuple of str
        Names of the checks, length c.
    statuses : (b, c) array of int
        Status of each check as index in `STATUSES`; -1 for a run without the check.
    judged : (b,) array of bool
        True for runs with a verdict.
    failures : tuple of FailedRun
        Failures of these runs.
    """

    runs: NDArray[np.int64]
    estimands: tuple[Estimand, ...]
    numbers: Array
    checks: tuple[str, ...]
    statuses: NDArray[np.int8]
    judged: NDArray[np.bool_]
    failures: tuple[FailedRun, ...]


@dataclass(slots=True)
class _Run:
    """Results of one run while they are collected.

    Attributes
    ----------
    run : int
        Number of the run, from 0.
    values : dict of Estimand to (2 + 3 i,) array
        Numbers of each estimand, as in `BlockNumbers`.
    checks : dict of str to int, or None
        Status of each check as index in `STATUSES`; None for a run without a verdict.
    failures : list of FailedRun
        Failures of this run.
    """

    run: int
    values: dict[Estimand, Array] = field(default_factory=dict)
    checks: dict[str, int] | None = None
    failures: list[FailedRun] = field(default_factory=list)

    @contextmanager
    def losing(self, of: str, lead: str = "") -> Iterator[None]:
        """Record an error in the ``with`` block as a failure, and go on after the block.

        `of` is the part of the run that failed, as in `FailedRun`; the reason begins with `lead`.
        """
        try:
            yield
        except AxisidError as error:
            self.lost(of, f"{lead}{error}")

    def lost(self, of: str, reason: str) -> None:
        """Record the failure of a method, or of another part of the run, with its reason."""
        self.failures.append(FailedRun(run=self.run, of=of, reason=reason))

    def judged(self, statuses: Mapping[str, str]) -> None:
        """Record the statuses of checks by name, in addition to those already recorded."""
        indices = {name: STATUSES.index(status) for name, status in statuses.items()}
        self.checks = {**(self.checks or {}), **indices}

    def numbers(self) -> BlockNumbers:
        """Return the run as a block of one run."""
        checks = self.checks or {}
        return BlockNumbers(
            runs=np.array([self.run], dtype=np.int64),
            estimands=tuple(self.values),
            numbers=np.array([*self.values.values()], dtype=float).reshape(1, -1, _WIDTH),
            checks=tuple(checks),
            statuses=np.array([[*checks.values()]], dtype=np.int8),
            judged=np.array([self.checks is not None]),
            failures=tuple(self.failures),
        )


def block_numbers(
    plan: MonteCarloPlan,
    block: range,
    threads: int | None = None,
    *,
    bootstrapped: int | None = None,
) -> BlockNumbers:
    """Simulate and identify consecutive runs, and return their numbers.

    Parameters
    ----------
    plan : MonteCarloPlan
    block : range
        Numbers of the runs.
    threads : int, optional
        Threads of the simulation, as in `simulate_batch`; the numbers do not depend on them.
    bootstrapped : int, optional
        Number of the study's first runs that have simulated replicas; by default the runs with a
        verdict.
    """
    with_replicas = plan.checks if bootstrapped is None else bootstrapped
    # Runs with replicas are identified one by one; the other runs in lanes, if the plan allows it.
    count = max(with_replicas - block.start, 0) if are_lanes(plan) else len(block)
    one_by_one, in_lanes = block[:count], block[count:]
    runs = []
    for number, record in twins(plan, one_by_one):
        bootstrap = plan.bootstrap if number < with_replicas else 0
        runs.append(_run(plan, number, record, bootstrap))
    if in_lanes:
        runs += _lane_runs(plan, in_lanes, threads)
    return joined([run.numbers() for run in runs])


def _lane_runs(plan: MonteCarloPlan, runs: range, threads: int | None) -> Iterator[_Run]:
    """Yield the results of runs that are simulated and identified in parallel lanes.

    The plan has one method, and the runs have no verdict.
    """
    (method,) = plan.methods
    lanes, unsimulated = twin_lanes(plan.twin, plan.noise, plan.seed, runs, threads)
    found = identify_lanes(plan.axis, lanes, method, plan.prefilter, lags=plan.settings["lags"])
    for lane, number in enumerate(runs):
        run = _Run(number)
        if lane in unsimulated:
            run.lost(SIMULATION, unsimulated[lane])
        elif lane in found.errors:
            run.lost(method, found.errors[lane])
        else:
            for i, quantity in enumerate(plan.axis.parameters):
                value = float(found.values[lane, i])
                intervals = {
                    of: _interval(value, found.deviations[of][lane, i], found.freedom[of][lane, i])
                    for of in COVARIANCES
                }
                estimand = Estimand(method, quantity.name, PARAMETER, quantity.unit)
                run.values[estimand] = _row(value, value, intervals)
        yield run


def _run(plan: MonteCarloPlan, number: int, record: Record | str, bootstrap: int) -> _Run:
    """Return the results of one run by all methods, with its verdict if planned.

    A method that fails is recorded as a failure of the run; the other methods go on.

    Parameters
    ----------
    plan : MonteCarloPlan
    number : int
        Number of the run, from 0.
    record : Record or str
        Simulated record of the twin; the reason, as text, if its simulation failed.
    bootstrap : int
        Number of simulated replicas for bias and standard errors; 0 for none.
    """
    run, is_judged = _Run(number), number < plan.checks
    if isinstance(record, str):
        run.lost(SIMULATION, record)
        return run
    # The methods of `identify`, and its verdict.
    result = _identified(plan, run, record, bootstrap)
    if result is not None:
        if is_judged:
            with run.losing(VERDICT):
                run.judged({check.name: check.status for check in result.verdict})
        run.values.update(estimand_numbers(result, judged=run.checks is not None))
    # The output-error fits, and their checks.
    for method in plan.fits:
        with run.losing(method):
            found = fit(plan.axis, record, fitted_output(method), **asdict(plan.levels))
            run.values.update([*_fit_numbers(method, found)])
            if is_judged:
                with run.losing(VERDICT, f"{method}: "):
                    run.judged({f"{c.name} ({method})": c.status for c in found.checks})
    return run


def _fit_numbers(method: str, found: OutputFit) -> Iterator[tuple[Estimand, Array]]:
    """Yield the estimands of a fit with their numbers, as in `BlockNumbers`.

    Fixed parameters, and parameters that the record does not identify, are left out.
    """
    for name, value in found.parameters.items():
        if name in found.fixed or not math.isfinite(value.deviation):
            continue
        intervals = {COLOURED: (value.deviation, value.interval)}
        if name not in found.at_bound:  # the interval at a bound is one-sided
            intervals[IID] = _interval(value.value, value.deviations[IID], math.inf)
        yield (
            Estimand(method, name, PARAMETER, value.unit),
            _row(value.value, value.corrected, intervals),
        )


def _identified(
    plan: MonteCarloPlan, run: _Run, record: Record, bootstrap: int
) -> Identification | None:
    """Return the identification by all methods that succeed; None if none does.

    All methods are tried together first. If that fails, each is tried alone, and those that fail
    are recorded as failures of the run.
    """
    if not plan.regressions:
        return None
    with suppress(AxisidError):
        return _estimated(plan, record, plan.regressions, bootstrap)
    able: list[str] = []
    for method in plan.regressions:
        with run.losing(method):
            _estimated(plan, record, [method], bootstrap)
            able.append(method)
    return _estimated(plan, record, able, bootstrap) if able else None


def _estimated(
    plan: MonteCarloPlan, record: Record, methods: Sequence[str], bootstrap: int
) -> Identification:
    """Return the identification of a record by methods.

    The intervals of each method are computed here, so that their errors are raised here.
    """
    settings = {**plan.settings, **asdict(plan.levels), "bootstrap": bootstrap}
    result = identify(plan.axis, record, plan.prefilter, methods, **settings, judge=False)
    for method in methods:
        _ = result[method].parameters
    return result


def estimand_numbers(
    result: Identification, *, judged: bool = False
) -> Iterator[tuple[Estimand, Array]]:
    """Yield each estimand of a result with its numbers, as in `BlockNumbers`.

    Parameters
    ----------
    result : Identification
    judged : bool
        True if intervals for the model error are included.
    """
    for method, estimate in result.estimates.items():
        bands = result.diagnosis.bands.get(method, {}) if judged else {}
        for kind, values, freedoms in (
            (PARAMETER, estimate.parameters, estimate.freedom),
            (DIRECT, estimate.ddm_parameters, estimate.inference.ddm_freedom),
        ):
            for i, (name, value) in enumerate(values.items()):
                numbers = _numbers(value, {of: freedoms[of][i] for of in COVARIANCES})
                if kind == PARAMETER and name in bands:
                    numbers[-3:] = bands[name].deviation, *bands[name].interval
                yield Estimand(method, name, kind, value.unit), numbers
    for method, physical in result.physical.items():
        for name, value in physical.parameters.items() if physical.shows_more else ():
            yield Estimand(method, name, PHYSICAL, value.unit), _numbers(value, {})


def _numbers(value: Value, freedom: Mapping[str, float]) -> Array:
    """Return the numbers of an estimate in a run, (2 + 3 i,), as in `BlockNumbers`.

    The interval of the reported covariance is that of the value. Other covariances have an interval
    if `freedom` has their degrees of freedom, by name.
    """
    intervals: dict[str, Interval] = {}
    for of in COVARIANCES:
        if of == value.chosen:
            intervals[of] = value.deviations[of], value.interval
        elif of in freedom:
            intervals[of] = _interval(value.corrected, value.deviations[of], freedom[of])
    return _row(value.value, value.corrected, intervals)


def _interval(value: float, deviation: float, freedom: float) -> Interval:
    """Return the standard error of a value, and both bounds of its interval by Student's t.

    `deviation` is the standard error, and `freedom` has its degrees of freedom.
    """
    return float(deviation), student_interval(value, float(deviation), float(freedom))


def _row(value: float, corrected: float, intervals: Mapping[str, Interval]) -> Array:
    """Return the numbers of an estimand in a run, (2 + 3 i,); not a number for missing intervals.

    `corrected` is the value minus the bias of filter and noise; the intervals are by kind, of
    `INTERVALS`.
    """
    row = np.full(_WIDTH, np.nan)
    row[:2] = value, corrected
    for kind, (deviation, bounds) in intervals.items():
        first = 2 + 3 * INTERVALS.index(kind)
        row[first : first + 3] = deviation, *bounds
    return row


def lost_block(block: range, reason: str) -> BlockNumbers:
    """Return runs without numbers, each with a failed simulation.

    Their process was killed; `reason` is the message of the failure.
    """
    blocks = []
    for number in block:
        failure = FailedRun(run=number, of=SIMULATION, reason=reason)
        blocks.append(_Run(number, failures=[failure]).numbers())
    return joined(blocks)


def joined(blocks: Sequence[BlockNumbers]) -> BlockNumbers:
    """Return blocks of runs as one block, sorted by the first run of each block.

    Estimands and checks of all blocks are joined. Numbers that a block lacks are not a number, and
    statuses -1.
    """
    ordered = sorted(blocks, key=lambda block: int(block.runs[0]))
    # Unique, in order of first occurrence.
    estimands = tuple(dict.fromkeys(each for block in ordered for each in block.estimands))
    checks = tuple(dict.fromkeys(each for block in ordered for each in block.checks))
    return BlockNumbers(
        runs=np.concatenate([block.runs for block in ordered]),
        estimands=estimands,
        numbers=_stacked([(b.numbers, b.estimands) for b in ordered], estimands, np.nan),
        checks=checks,
        statuses=_stacked([(b.statuses, b.checks) for b in ordered], checks, -1),
        judged=np.concatenate([block.judged for block in ordered]),
        failures=tuple(failed for block in ordered for failed in block.failures),
    )


def _stacked(
    parts: Sequence[tuple[NDArray[Any], tuple[object, ...]]],
    columns: tuple[object, ...],
    missing: float,
) -> NDArray[Any]:
    """Return arrays stacked by run, with common columns.

    Parameters
    ----------
    parts : sequence of (array, tuple)
        Array of each block, with the estimands or checks of its columns.
    columns : tuple
        Estimands or checks of all columns of the result.
    missing : float
        Value of a column that a block lacks.
    """
    index = {column: i for i, column in enumerate(columns)}
    stacked = []
    for array, own_columns in parts:
        whole = np.full((len(array), len(columns), *array.shape[2:]), missing, dtype=array.dtype)
        whole[:, [index[column] for column in own_columns]] = array
        stacked.append(whole)
    return np.concatenate(stacked)
