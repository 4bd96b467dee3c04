"""What a fit of outputs comes to."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels, told_or, unless_faulty
from axisid.estimation.choices import OPEN_LOOP
from axisid.estimation.diagnostics import Checked
from axisid.estimation.diagnostics.law import FoundGains, LawCheck, check_found_law, first_failing
from axisid.estimation.estimates import Distribution, NamedValues, Value, freedom_of
from axisid.estimation.lacking import Lack, found_beside, scores_of
from axisid.estimation.methods import bound_record
from axisid.estimation.records import Record
from axisid.estimation.regression import recorded_loops
from axisid.estimation.searches import FitStep
from axisid.estimation.signals import Prefilter
from axisid.estimation.twins import measured_chain
from axisid.modeling.text import FunctionLike
from axisid.support.arrays import Array, Exact
from axisid.support.errors import AxisidError
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable
from axisid.support.remedy import Note

from .law_moves import factors_in_twins, move_by_record, moves_of_all, moves_per_percent
from .solution import FitSolution
from .spread import noise_left


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordError:
    """What a fit leaves of an output of one record.

    Attributes
    ----------
    output, unit : str
    weight : float
        By which its errors count, in the inverse of its unit.
    rows : int
        Samples that count.
    error : float
        Root mean square, in the output's unit.
    percent : float
        Of the recorded output's.
    order : int
        Of the autoregression of the errors, of all outputs together.
    """

    output: str
    unit: str
    weight: float
    rows: int
    error: float
    percent: float
    order: int


@dataclass(frozen=True, kw_only=True, eq=False)
class OutputFit(Checked, Presentable, Exact):
    """Parameters with which a simulated output follows that of the records.

    Attributes
    ----------
    axis : GeneratedAxis
    records : tuple of Record
    outputs : tuple of str
        What is followed: ``control``, ``position``, ``force``, or ``open-loop`` alone.
    units : tuple of str
        Of the outputs.
    loss : str
        ``squares``, ``soft-l1`` or ``huber``.
    quantities : tuple of Quantity
        The parameters, length P.
    physical : (P,) array
    covariances : mapping of str to (P, P) array
        By name: ``coloured``, for errors that follow an autoregression, ``iid`` for independent
        ones; of loops with twins ``bootstrap`` by them. Rows of what is fixed or at a bound
        are 0; of what no output shows the variances are infinite.
    chosen : str
        Of `covariances`: what deviations and intervals are of.
    values : mapping of str to Value
        The parameters with deviations and intervals, by name; see `parameters`.
    at_bound : mapping of str to str
        ``lower`` or ``upper``, by parameters that are driven to a bound; the interval of one is on
        the side that is allowed.
    bounds : mapping of str to (float, float)
        That were in force.
    fixed : mapping of str to float
    prior : mapping of str to (float, float)
        What was known before, with its deviation.
    unseen : tuple of str
        Parameters, or sums of them, that no output shows, in words.
    local : mapping of str to tuple of str
        Names of each parameter that records have for themselves, by record.
    start : (P,) array
    started : str
        Where it is from: ``instruments``, ``least-squares``, ``nominal`` or ``given``.
    remarks : tuple of Note
    steps : tuple of FitStep
        Where slopes were taken, the last at the end.
    ends : tuple of (float, Array)
        Cost and parameters (P,) of each search, where several were asked for.
    of_records : tuple of RecordError
        By record, and in each by output.
    errors : tuple of (N,) array
        Simulated less recorded output, by record; of m outputs (N, m).
    samples : tuple of (N,) array of int
        Of the record, that the errors are at.
    horizon : float or None
        Length of the windows of an open loop, s.
    solution : FitSolution
        What it is judged from.
    judge : callable
        Gives the checks of a fit.
    levels : Levels
        From when on a check tells something of the model.
    """

    axis: GeneratedAxis
    records: tuple[Record, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    loss: str
    quantities: tuple[Quantity, ...]
    physical: Array
    covariances: Mapping[str, Array]
    chosen: str
    values: Mapping[str, Value]
    at_bound: Mapping[str, Literal["lower", "upper"]]
    bounds: Mapping[str, tuple[float, float]]
    fixed: Mapping[str, float]
    prior: Mapping[str, tuple[float, float]]
    unseen: tuple[str, ...]
    local: Mapping[str, tuple[str, ...]]
    start: Array
    started: str
    remarks: tuple[Note, ...]
    steps: tuple[FitStep, ...]
    ends: tuple[tuple[float, Array], ...]
    of_records: tuple[RecordError, ...]
    errors: tuple[Array, ...]
    samples: tuple[NDArray[np.intp], ...]
    horizon: float | None
    solution: FitSolution = field(repr=False, compare=False)
    judge: Callable[["OutputFit"], tuple[Check, ...]] = field(repr=False, compare=False)
    levels: Levels = DEFAULT_LEVELS

    def __getstate__(self) -> dict[str, Any]:
        """With what twins of the record tell: the solution has none of them then."""
        _ = self.lacks, self.noise
        return vars(self)

    @cached_property
    def law(self) -> LawCheck | Missing:
        """The declared control law against the records: that of the first that fails."""
        return first_failing(self._laws)

    @cached_property
    def law_moves(self) -> Mapping[str, Array]:
        """What each term of the law, 1 % larger, would move the parameters by, (P,)."""
        return told_or({}, lambda: moves_of_all(self._moves_of_records))

    @cached_property
    def law_move(self) -> Array | None:
        """What the law as the records have it would move them by, (P,)."""
        found = self.law_shift
        return None if found is None or isinstance(found, Missing) else found[0]

    @cached_property
    def law_shift(self) -> tuple[Array, Array] | Missing | None:
        """What the law as the records have it would move them by, with deviations, (P,) each."""
        solution = self.solution
        chains = solution.chains or (None,) * len(self.records)
        every = zip(self._laws, solution.axes, self.records, solution.own, chains, strict=True)

        def moved() -> tuple[Array, Array] | None:
            twins = [
                factors_in_twins(law, axis, record, own, self.found_gains, chain)
                for law, axis, record, own, chain in every
            ]
            return move_by_record(self._moves_of_records, self._laws, twins)

        return unless_faulty(moved)

    @cached_property
    def _moves_of_records(self) -> tuple[Mapping[str, Array], ...]:
        return moves_per_percent(self.solution.predictions, self.physical, self.solution.influence)

    @cached_property
    def lacks(self) -> tuple[tuple[Lack, ...] | Missing, ...]:
        """What the model lacks on each record, what explains most first."""
        every = zip(self.solution.axes, self.records, self.solution.own, strict=True)
        return tuple(unless_faulty(partial(self._lacks, i, *each)) for i, each in enumerate(every))

    def _lacks(
        self, number: int, axis: GeneratedAxis, record: Record, own: Array
    ) -> tuple[Lack, ...] | Missing:
        """By the rows of a record, and of its twins, as identified ones.

        What a model lacks is no matter of what is followed: the residuals of instruments at the
        fit's parameters tell it, whatever output these are of.
        """
        if axis.axis.states:
            return Missing("friction that remembers has no rows in which that could be looked for")
        locals_ = {name: names[number] for name, names in self.local.items()}
        names = [locals_.get(q.name, q.name) for q in axis.parameters]
        data = bound_record(axis, record, Prefilter())
        data = data.by_position or data
        chain = None
        with suppress(AxisidError):
            chain = measured_chain(data, own, recorded_loops(data, own))
        told = set(self.searched) - self.prior.keys()
        free = [j for j, name in enumerate(names) if name in told]
        scores = scores_of(data, own, chain, free)
        if isinstance(scores, Missing):
            return scores
        half = [
            float(np.ptp(self.values[n].interval)) / 2 if n in self.values else math.inf
            for n in names
        ]
        return found_beside(scores, np.array(half), len(self.records), self.levels)

    @cached_property
    def noise(self) -> tuple[float, ...]:
        """Root mean square of what is noise in what is left, in the output's unit.

        As in `of_records`.

        What white noise of the position makes in the loop, as the record has it, or what nothing
        before it tells of an error, whichever is more.
        """
        solution = self.solution
        return noise_left(
            solution.predictions, self.physical, solution.judged_scores, solution.weighing.weights
        )

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether to believe it."""
        return self.judge(self)

    @cached_property
    def _laws(self) -> tuple[LawCheck | Missing, ...]:
        if self.outputs == (OPEN_LOOP,):
            why = Missing("no law is simulated: the control is the recorded one")
            return (why,) * len(self.records)
        found = self.found_gains
        return tuple(
            unless_faulty(partial(check_found_law, axis, record, found))
            for axis, record in zip(self.solution.axes, self.records, strict=True)
        )

    @cached_property
    def found_gains(self) -> FoundGains:
        """Gains of the law that were searched, and are not at a bound."""
        law = self.axis.axis.control
        names = () if law is None else tuple(name for name in law.gains if name in self.searched)
        places = [self.names.index(name) for name in names]
        return FoundGains(names, self.covariance[np.ix_(places, places)])

    @property
    def searched(self) -> tuple[str, ...]:
        """Names of what is neither held nor at a bound."""
        return tuple(n for n in self.names if n not in self.fixed and n not in self.at_bound)

    @property
    def parameters(self) -> NamedValues:
        """The parameters with unit, deviations and 95 % interval, by name."""
        return NamedValues(self.values)

    def __getitem__(self, name: str) -> Value:
        return self.parameters[name]

    def derive(self, function: FunctionLike) -> Value:
        """Any function of the parameters, with its unit and interval.

        Parameters
        ----------
        function : str or SymPy expression
            Such as ``"M/Fv"``, as `Estimate.derive` takes it.

        Returns
        -------
        Value
            By the delta method, under every covariance.

        Raises
        ------
        UsageError
            The function cannot be read, its units do not fit, or it is of what is at a bound.
        EstimationError
            It has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function bends within the uncertainty, so that the delta method is not enough.
        """
        freedom = np.array([freedom_of(value) for value in self.values.values()])
        return Distribution(
            quantities=self.quantities,
            theta=self.physical,
            covariances=self.covariances,
            freedom={self.chosen: freedom},
            chosen=self.chosen,
            at_bound=self.at_bound,
        ).derived(function, "fit with bootstrap= and look at the parameters")

    @property
    def covariance(self) -> Array:
        """The one that was chosen, (P, P)."""
        return self.covariances[self.chosen]

    @property
    def deviations(self) -> Array:
        """Of the parameters, (P,)."""
        return np.array([value.deviation for value in self.values.values()])

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(q.name for q in self.quantities)

    @property
    def output(self) -> str:
        """What is followed, in words."""
        return " and ".join(self.outputs)

    @property
    def unit(self) -> str:
        """Of the first output."""
        return self.units[0]

    @property
    def error(self) -> float:
        """Root mean square of what is left of all records, of the first output, in its unit."""
        own = self.of_records[:: len(self.outputs)]
        squares = sum(each.rows * each.error**2 for each in own)
        return float(np.sqrt(squares / sum(each.rows for each in own)))

    @property
    def error_percent(self) -> float:
        """Of the recorded output; of several records or outputs the largest."""
        return max(each.percent for each in self.of_records)

    @property
    def percent_beyond_noise(self) -> float:
        """What is left beyond noise, of the recorded output; of several the largest."""
        return max(self.percents_beyond_noise)

    @property
    def percents_beyond_noise(self) -> tuple[float, ...]:
        """What is left beyond noise, of the recorded output, as in `of_records`."""
        return tuple(
            each.percent * math.sqrt(max(1 - (noise / each.error) ** 2, 0.0)) if each.error else 0.0
            for each, noise in zip(self.of_records, self.noise, strict=True)
        )

    @property
    def step(self) -> float:
        """Of the coarsest encoder, SI; 0 where nothing is known of any."""
        return self.solution.predictions.step
