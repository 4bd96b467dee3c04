"""The estimation problem: an axis, and its records, each with its filter."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, cast

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
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
from axisid.estimation.signals import FilteredRecord, RowTimes, Signals, motion_lacks
from axisid.estimation.simulation import Simulation, StepBudget
from axisid.estimation.unknowns import JointForm
from axisid.support.arrays import Array, Uncached
from axisid.support.errors import AxisidError, EstimationError, ModelError

from .detectability import SignalRanges, check_has_rows, check_time_known, check_visible
from .parameter_at_bound import ParameterAtBound


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """Solver of the rows of a form: least squares, instrumental variables or output error.

    Without `loop` and `slopes` it is least squares, with `loop` alone instrumental variables, and
    with both output error.

    Attributes
    ----------
    loop : QrFactors or None
        Columns of the simulated loop as instruments, fixed for all rows; None for least squares.
    slopes : Equations or None
        For output error: the simulated left side, linearised about the estimate, as regressor of
        the measured left side. None if the rows have their own regressor.
    counts : LossWeights or None
        Weight of each row under a loss; None for equal weights.
    """

    loop: QrFactors | None = None
    slopes: Equations | None = None
    counts: LossWeights | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Return the solution of `rows`, which are rows of `form`.

        Raises
        ------
        EstimationError
            As in `factor`, `checked_columns` and `instrumental_variables`.
        """
        names = [q.label for q in form.quantities]
        right = self.slopes or rows
        left = rows.left - right.intercept
        if self.loop is None:
            regressor = factor(right.regressor, names)
            return instrumental_variables(left, regressor, regressor, self.counts)
        columns = checked_columns(right.regressor, names)
        return instrumental_variables(left, columns, self.loop, self.counts)


@dataclass(frozen=True, kw_only=True, repr=False)
class Problem(Uncached):
    """The records that an axis's parameters are estimated from, as one regression.

    Segments of a record and several records are treated equally: their rows are concatenated, with
    their times in `neighbours`.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis to identify.
    data : tuple of FilteredRecord
        One or more records. The axis of each record is that of the problem, or the axis that a
        joint form has for the record. The rows of all records have the same distance in time.
    joint_form : JointForm or None
        Parameters of the records if not all are shared; None if all are shared.
    weights : tuple of float
        Weight of each record's rows, the inverse of its noise; empty for equal weights.
    held : tuple of ParameterAtBound
        Declared parameters that are removed from the axis, as they are fixed at a bound.

    Raises
    ------
    UsageError
        The axis has a lag or a delay of its drive that is to be estimated.
    EstimationError
        The axis has parameters that are not identifiable from any record.
    """

    axis: GeneratedAxis
    data: tuple[FilteredRecord, ...]
    joint_form: JointForm | None = None
    weights: tuple[float, ...] = ()
    held: tuple[ParameterAtBound, ...] = ()

    def __post_init__(self) -> None:
        """Refuse an axis that has no rows, or is not identifiable; see the class."""
        check_has_rows(self.axis.axis)
        check_time_known(self.axis)
        if self.joint_form is None and self.axis.unidentifiable:
            raise EstimationError(
                f"axis {self.axis.name!r} cannot be identified: "
                f"{'; '.join(self.axis.unidentifiable)}. Declare the combination as one parameter."
            )

    def __repr__(self) -> str:
        """Return the name of the axis and its records."""
        return f"{self.axis.name} from {', '.join(map(repr, self.data))}"

    @cached_property
    def neighbours(self) -> RowTimes:
        """Times of the rows of all records."""
        return RowTimes.joined([data.sampling.neighbours for data in self.data])

    def form(self, kind: type[Form]) -> Form:
        """Return the inverse or direct model (`kind`), in the parameters of all records.

        Raises
        ------
        ModelError
            The axis has no such form, or the form does not allow local parameters.
        """
        if self.joint_form is None:
            return kind(self.axis)
        if not issubclass(kind, InverseForm):
            raise ModelError(
                "the direct model needs records that share all parameters, without known values of "
                "single records, because its parameters are quotients of the shared parameters. "
                "Use a method of the inverse model, such as idm-iv.",
                code="method",
            )
        return self.joint_form

    def reduced(self, form: Form, signals: Sequence[Signals]) -> Equations:
        """Return the rows of a form for signals of each record, filtered as the record is."""
        every = [form.of_record(i).equations(own) for i, own in enumerate(signals)]
        return self._stacked(form, [e.reduced(d) for e, d in zip(every, self.data, strict=True)])

    def rows(self, form: Form) -> Equations:
        """Return the measured rows of a form, filtered and weighted, of all records.

        The rows of a linear form are computed once. A record that does not show a parameter is
        refused, except with local parameters or known values of each record.

        Raises
        ------
        EstimationError
            The rows do not show a parameter, which is named.
        """
        if type(form) in self.made:
            return cast(Equations, self.made[type(form)])
        if not isinstance(form, InverseForm):
            self.rows(InverseForm(self.axis))  # detectability is tested with the inverse model
        every = [form.of_record(i).equations(data.signals) for i, data in enumerate(self.data)]
        rows = self._stacked(form, [e.reduced(d) for e, d in zip(every, self.data, strict=True)])
        if isinstance(form, InverseForm) and self.joint_form is None:
            # Refuse parameters that the rows do not show, by the ranges over all kept samples.
            samples = [
                (data.signals, equations, data.sampling.kept)
                for data, equations in zip(self.data, every, strict=True)
            ]
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
        """Return values of the rows of all records, (n,), from a function of one record."""
        pieces = [values(data) for data in self.data]
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def factored(self, form: Form, measured: Equations) -> QrFactors:
        """Return the QR factors of the regressor of measured rows.

        The factors are computed once for the rows that `rows` keeps, which are those of linear
        forms.

        Raises
        ------
        EstimationError
            As in `factor`, with a sentence on the missing excitation of the motion.
        """
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
        """Return the simulated loops with parameters (p,), and their filtered rows.

        `budget` limits the integration steps of a search.
        """
        loops = self.loops(form, physical, budget)
        return loops, self.simulated_rows(form, physical, loops)

    def simulated_rows(
        self, form: Form, physical: Array, loops: tuple[Simulation, ...]
    ) -> Equations:
        """Return the filtered rows of loops that were simulated with parameters (p,)."""
        rows = []
        for i, (data, own_loops) in enumerate(zip(self.data, self.by_record(loops), strict=True)):
            own_form, own_parameters = form.of_record(i), form.own(physical, i)
            rows.append(simulated_rows(own_form, own_loops, own_parameters, data))
        return self._stacked(form, rows)

    def loops(
        self, form: Form, physical: Array, budget: StepBudget | None = None
    ) -> tuple[Simulation, ...]:
        """Return the simulated loops with parameters (p,), one for each segment of each record.

        The arguments are those of `simulated`.
        """
        loops: list[Simulation] = []
        for i, data in enumerate(self.data):
            own_parameters = form.own(physical, i)
            loops += simulated_loops(data.axis, data.record, own_parameters, budget=budget)
        return tuple(loops)

    def by_record(self, loops: tuple[Simulation, ...]) -> tuple[tuple[Simulation, ...], ...]:
        """Return simulated loops, one for each segment of all records, grouped by record."""
        ends = list(accumulate(len(data.record.spans) for data in self.data))
        return tuple(loops[a:b] for a, b in zip([0, *ends], ends, strict=False))

    @cached_property
    def spans(self) -> tuple[slice, ...]:
        """Slice of the rows of each record among all rows."""
        ends = [*accumulate(len(data.sampling.rows) for data in self.data)]
        return tuple(slice(a, b) for a, b in zip([0, *ends], ends, strict=False))

    @property
    def row_weights(self) -> Array:
        """Weight of each row, (n,); 1 for equal weights."""
        weights = self.weights or (1.0,) * len(self.data)
        return np.repeat(weights, [span.stop - span.start for span in self.spans])

    @property
    def rest(self) -> float:
        """Share of the used samples of all records at which the axis is at standstill, 0 to 1."""
        weights = [int(data.sampling.used.sum()) for data in self.data]
        rests = [data.rest for data in self.data]
        return float(np.average(rests, weights=weights)) if sum(weights) else max(rests)

    @property
    def lacking(self) -> str:
        """Sentence on the excitation that the motion of every record lacks; empty if none."""
        every = [motion_lacks(data.signals) for data in self.data]
        facts = [fact for fact in every[0] if all(fact in of_record for of_record in every)]
        where = "this record" if len(self.data) == 1 else "each of these records"
        return f"In {where} {', and '.join(facts)}." if facts else ""

    def _stacked(self, form: Form, rows: Sequence[Equations]) -> Equations:
        """Return the weighted rows of all records, in the parameters of a form.

        `rows` has the rows of each record, in the parameters of the record's axis.
        """
        pieces = []
        for i, own in enumerate(rows):
            left = own.left
            intercept, regressor = form.placed(i, own.intercept, own.regressor)
            weight = self.weights[i] if self.weights else 1.0
            if weight != 1:
                left, intercept, regressor = weight * left, weight * intercept, weight * regressor
            pieces.append(Equations(left=left, intercept=intercept, regressor=regressor))
        return Equations.stacked(pieces)

    @cached_property
    def made(self) -> dict[Any, Any]:
        """Cache of rows and QR factors by type of linear form, and of fits by method."""
        return {}


@contextmanager
def adding(sentence: Callable[[], str]) -> Iterator[None]:
    """Append a sentence to an error that is raised in the ``with`` block.

    `sentence` returns the sentence, and is called only if there is an error. With an empty
    sentence, the error is raised unchanged.
    """
    try:
        yield
    except AxisidError as error:
        further = sentence()
        if further:
            raise type(error)(f"{error} {further}", code=error.code) from error
        raise
