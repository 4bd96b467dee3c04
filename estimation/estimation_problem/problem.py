"""What is to be estimated from what: an axis, and its records, each under its filter.

And how a method solves its rows, or what it makes of others: of a loop, of another gain, of steps.
The loop of an estimate is a record without noise. It, and how an estimate depends on the drive
gain, keep the instruments: only what was measured is changed.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Any, cast

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.parameters import JointForm
from axisid.estimation.regression import (
    Equations,
    Form,
    InverseForm,
    LossWeights,
    QrFactors,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
    simulated_loops,
    simulated_rows,
)
from axisid.estimation.signals import FilteredRecord, RowTimes, Signals, hold_mean, motion_lacks
from axisid.estimation.simulation import Simulation, StepBudget, logged_control
from axisid.support.arrays import Array, Uncached
from axisid.support.errors import AxisidError, EstimationError, ModelError, range_text

from .visibility import (
    SignalRanges,
    check_has_rows,
    check_time_known,
    check_visible,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterAtBound:
    """A parameter at its bound, and what the records say of it without.

    Attributes
    ----------
    name, unit : str
    bound : float
        Where it is held, SI.
    is_lower : bool
        Whether that is the lower one.
    free : float
        What it is without the bound, others that are held at theirs, less its bias
        where that is known.
    deviation : float
        Of `free`, under the covariance that was chosen.
    reach : float
        The other end of its 95 % interval, which begins at the bound and has one side; the bound
        itself where the records leave no room beside it.
    """

    name: str
    unit: str
    bound: float
    is_lower: bool
    free: float
    deviation: float
    reach: float

    @property
    def distance(self) -> float:
        """How far beyond the bound it would be, in deviations; 0 for what would come back."""
        beyond = (self.bound - self.free) if self.is_lower else (self.free - self.bound)
        return max(0.0, beyond / self.deviation) if self.deviation > 0 else 0.0

    @property
    def text(self) -> str:
        """All of it in words."""
        room = (
            "95 %, to one side: "
            + range_text(min(self.bound, self.reach), max(self.bound, self.reach), " to ")
            if self.reach != self.bound
            else "which leaves no room beside the bound"
        )
        return (
            f"{self.name} is held at its bound {self.bound:g} {self.unit}; without it "
            f"{self.free:.4g} +- {self.deviation:.2g}, {room}"
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class Problem(Uncached):
    """The records that an axis's parameters are estimated from, as one regression.

    A record with gaps and several records are the same thing: rows one after the other, of which
    `neighbours` says which follow each other in time.

    Attributes
    ----------
    axis : GeneratedAxis
    data : tuple of FilteredRecord
        One or more, of that axis, or each of its own where a layout has one for it; their rows are
        equally far apart in time.
    layout : JointForm or None
        Which parameters the records share, where they do not share all; None where they do.
    weights : tuple of float
        Of each record's rows, the inverse of its noise; empty where all are of one.
    held : tuple of ParameterAtBound
        Declared parameters that are no longer the axis's, since they are held at a bound.

    Raises
    ------
    UsageError
        The axis has a lag or a delay of its drive that is still to be estimated.
    EstimationError
        The axis has parameters that no record can tell.
    """

    axis: GeneratedAxis
    data: tuple[FilteredRecord, ...]
    layout: JointForm | None = None
    weights: tuple[float, ...] = ()
    held: tuple[ParameterAtBound, ...] = ()

    def __post_init__(self) -> None:
        check_has_rows(self.axis.axis)
        check_time_known(self.axis)
        if self.layout is None and self.axis.unidentifiable:
            raise EstimationError(
                f"axis {self.axis.axis.name!r} cannot be identified: "
                f"{'; '.join(self.axis.unidentifiable)}. Declare the combination as one parameter."
            )

    def __repr__(self) -> str:
        return f"{self.axis.axis.name} from {', '.join(map(repr, self.data))}"

    @cached_property
    def neighbours(self) -> RowTimes:
        """Which of the rows follow each other in time."""
        return RowTimes.joined([data.sampling.neighbours for data in self.data])

    def form(self, kind: type[Form]) -> Form:
        """A form of the axis, in the parameters of the records.

        Raises
        ------
        ModelError
            The axis has no such form, or it is not served where records do not share all.
        """
        if self.layout is None:
            return kind(self.axis)
        if not issubclass(kind, InverseForm):
            raise ModelError(
                "the direct model is regressed where all parameters are the same in all records "
                "and none is known of them; its own are quotients of them.",
                code="method",
            )
        return self.layout

    def reduced(self, form: Form, signals: Sequence[Signals]) -> Equations:
        """The rows of a form for signals of each record, each under the record's filter."""
        every = [form.of_record(i).equations(own) for i, own in enumerate(signals)]
        return self._stacked(form, [e.reduced(d) for e, d in zip(every, self.data, strict=True)])

    def rows(self, form: Form) -> Equations:
        """The measured rows of a form.

        Raises
        ------
        EstimationError
            They do not show a parameter, which is named.
        """
        if type(form) in self.made:
            return cast(Equations, self.made[type(form)])
        if not isinstance(form, InverseForm):
            self.rows(InverseForm(self.axis))  # what is shown of a parameter is of its own column
        every = [form.of_record(i).equations(data.signals) for i, data in enumerate(self.data)]
        rows = self._stacked(form, [e.reduced(d) for e, d in zip(every, self.data, strict=True)])
        if isinstance(form, InverseForm) and self.layout is None:
            # Columns that the rows do not show are refused, of what every sample has.
            pairs = zip(self.data, every, strict=True)
            samples = [(data.signals, own, data.sampling.kept) for data, own in pairs]
            with adding(lambda: self.lacking):
                check_visible(
                    self.axis,
                    SignalRanges.of(samples),
                    rows.regressor,
                    rows.left - rows.intercept,
                    source="the record" if len(self.data) == 1 else "the set of records",
                    without_turns=any(d.prefilter.reversals == "leave-out" for d in self.data),
                )
        if form.is_linear:
            self.made[type(form)] = rows
        return rows

    def stacked(self, values: Callable[[FilteredRecord], Array]) -> Array:
        """What each record gives for its rows, one after the other."""
        pieces = [values(data) for data in self.data]
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def factored(self, form: Form, measured: Equations) -> QrFactors:
        """The regressor of measured rows, or an error that says what the motion lacks."""
        key, is_kept = (factor, type(form)), measured is self.made.get(type(form))
        if is_kept and key in self.made:
            return cast(QrFactors, self.made[key])
        names = [q.label for q in form.quantities]
        with adding(lambda: self.lacking):
            regressor = factor(measured.regressor, names, neighbours=self.neighbours)
        if is_kept:
            self.made[key] = regressor
        return regressor

    def simulated(
        self, form: Form, physical: Array, budget: StepBudget | None = None
    ) -> tuple[tuple[Simulation, ...], Equations]:
        """The loops simulated with an estimate, and their rows."""
        loops = self.loops(form, physical, budget)
        return loops, self.simulated_rows(form, physical, loops)

    def simulated_rows(
        self, form: Form, physical: Array, loops: tuple[Simulation, ...]
    ) -> Equations:
        """The rows of loops that were simulated with an estimate."""
        pairs = enumerate(zip(self.data, self.by_record(loops), strict=True))
        rows = [
            simulated_rows(form.of_record(i), of_one, form.own(physical, i), data)
            for i, (data, of_one) in pairs
        ]
        return self._stacked(form, rows)

    def loops(
        self, form: Form, physical: Array, budget: StepBudget | None = None
    ) -> tuple[Simulation, ...]:
        """The loops simulated with an estimate, one for each segment of each record."""
        return tuple(
            loop
            for i, data in enumerate(self.data)
            for loop in simulated_loops(
                data.axis, data.record, form.own(physical, i), budget=budget
            )
        )

    def by_record(self, loops: tuple[Simulation, ...]) -> tuple[tuple[Simulation, ...], ...]:
        """Simulated loops, one for each segment, by the record that they are of."""
        ends = list(accumulate(len(data.record.spans) for data in self.data))
        return tuple(loops[a:b] for a, b in zip([0, *ends], ends, strict=False))

    @cached_property
    def spans(self) -> tuple[slice, ...]:
        """Of the rows, those of each record."""
        ends = [*accumulate(len(data.sampling.rows) for data in self.data)]
        return tuple(slice(a, b) for a, b in zip([0, *ends], ends, strict=False))

    @property
    def row_weights(self) -> Array:
        """Of each row, (n,); 1 where all are of one."""
        weights = self.weights or (1.0,) * len(self.data)
        return np.repeat(weights, [span.stop - span.start for span in self.spans])

    @property
    def rest(self) -> float:
        """Part of the samples of a fit at which the axis stands still."""
        weights = [int(data.sampling.used.sum()) for data in self.data]
        rests = [data.rest for data in self.data]
        return float(np.average(rests, weights=weights)) if sum(weights) else max(rests)

    @property
    def lacking(self) -> str:
        """What the motion lacks, as a sentence; empty if nothing is known to lack."""
        every = [motion_lacks(data.signals) for data in self.data]
        facts = [fact for fact in every[0] if all(fact in others for others in every)]
        where = "this record" if len(self.data) == 1 else "each of these records"
        return f"In {where} {', and '.join(facts)}." if facts else ""

    def _stacked(self, form: Form, rows: Sequence[Equations]) -> Equations:
        """The rows of each record as those of all, in their parameters."""
        pieces = []
        for i, own in enumerate(rows):
            weight = self.weights[i] if self.weights else 1.0
            parts = (own.left, *form.placed(i, own.intercept, own.regressor))
            left, intercept, regressor = (part if weight == 1 else weight * part for part in parts)
            pieces.append(Equations(left=left, intercept=intercept, regressor=regressor))
        return Equations.stacked(pieces)

    @cached_property
    def made(self) -> dict[Any, Any]:
        """What was made of it once: rows and factors by form, fits by method.

        Rows are the same wherever they are asked for if the axis is linear.
        """
        return {}


@contextmanager
def adding(sentence: Callable[[], str]) -> Iterator[None]:
    """Say more in an error, if there is more to say; asked for only then."""
    try:
        yield
    except AxisidError as error:
        if what := sentence():
            raise type(error)(f"{error} {what}", code=error.code) from error
        raise


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """What solves rows of a form: least squares, unless loops were simulated with an estimate.

    Attributes
    ----------
    loop : QrFactors or None
        The simulated loop's columns, the same whatever the rows: the instruments. None for least
        squares.
    slopes : Equations or None
        The simulated left side about the estimate, by which the measured one alone is explained:
        output error. None where the rows have their own regressor.
    counts : LossWeights or None
        What each row counted under a loss; None where all rows count alike.
    """

    loop: QrFactors | None = None
    slopes: Equations | None = None
    counts: LossWeights | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        names = [q.label for q in form.quantities]
        right = self.slopes or rows
        left = rows.left - right.intercept
        Z = factor(right.regressor, names) if self.loop is None else self.loop
        X = Z if self.loop is None else checked_columns(right.regressor, names)
        return instrumental_variables(left, X, Z, self.counts)


_STEP = 1e-4  # of the gain


def noise_free_residuals(
    form: Form, problem: Problem, loops: tuple[Simulation, ...], solver: Solver
) -> Array:
    """What filtering, differencing and decimation alone leave of an estimate's own loop, (n,).

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    problem : Problem
        What the estimate was made from.
    loops : tuple of Simulation
        Of the records, with the estimate; one for each segment.
    solver : Solver
        Of the estimate.
    """
    signals = [
        noise_free_record(data, of_one).signals
        for data, of_one in zip(problem.data, problem.by_record(loops), strict=True)
    ]
    return solver(form, problem.reduced(form, signals)).residuals / problem.row_weights


def jacobian_by_gain(
    form: Form, problem: Problem, solution: Solution, solver: Solver
) -> tuple[Array, Array]:
    """Slopes of the physical parameters, (p,), and of the regression's, (k,), by ln(gain).

    Without known terms every linear parameter is proportional to the gain; a known term keeps its
    size, so that the others take what it leaves. So does what the drive makes without its gain.
    """
    if isinstance(form, InverseForm):  # the force is on the left alone
        rows = problem.stacked(lambda data: data.reduce(data.force_by_gain))
        slope = solution.response.T @ (problem.row_weights * rows)
        return slope, slope
    # A measured force does not depend on the gain.
    shifted = [
        [replace(d.signals, force=d.signals.force + step * d.force_by_gain) for d in problem.data]
        for step in (_STEP, -_STEP)
    ]
    ahead, behind = (solver(form, problem.reduced(form, each)).theta for each in shifted)
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _STEP), (ahead - behind) / (2 * _STEP)


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """The record as its simulated loops have it, under the same filter.

    A column that was recorded is made of the loops as its sensor would see them.
    """
    record = data.record
    jumps = data.axis.axis.jumps
    sensed = jumps and data.prefilter.hold != "zoh"  # else it is what is held from the sample on
    simulated: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.position,
        "velocity": lambda s: s.velocity,
        "acceleration": lambda s: hold_mean(s.acceleration, [0]) if jumps else s.acceleration,
        "control": lambda s: logged_control(data.axis, s),
        "force": lambda s: hold_mean(s.force, [0]) if sensed else s.force,
    }
    columns: dict[str, Any] = {
        role: np.concatenate([seen(loop) for loop in loops])
        for role, seen in simulated.items()
        if getattr(record, role) is not None
    }
    return data.with_columns(**columns)


_DRAWS = 4  # each once with either sign


def quantisation_bias(form: Form, data: FilteredRecord, step: float, physical: Array) -> Array:
    """About what the steps of a position, that no control answers to, move an estimate by, (p,).

    Rounding adds noise that is uniform within a step. As much again moves the estimate about as
    far again, to first order in its variance: the simulation step of Cook and Stefanski's SIMEX.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    data : FilteredRecord
    step : float
        Of the position, SI.
    physical : (p,) array
        Least squares of the record as it is.
    """
    rng, changes = np.random.default_rng(0), []
    for _ in range(_DRAWS):
        noise = step * rng.uniform(-0.5, 0.5, len(data.record))
        for sign in (1.0, -1.0):
            position = data.record.position + sign * noise
            noisy = data.with_columns(position=position)
            rows = form.equations(noisy.signals).reduced(noisy)
            changes.append(form.physical(Solver()(form, rows).theta)[0] - physical)
    return np.asarray(np.mean(changes, axis=0), dtype=float)
