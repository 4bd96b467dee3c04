"""The parametric bootstrap of a problem: twins of its records, the same for all estimates."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from axisid.estimation.bootstrap import Chain, Twins, bootstrap_correction, measured_noise
from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.regression import Form, Hac, LoopDataError, recorded_loops
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError

from .method import Fit
from .methods import METHODS

TOO_FEW = "more than half of the loops with its noise cannot be simulated, or estimated from"
_FOLLOWS_NOT = "the loop does not follow the record"
_ROUNDS = 4  # of twins, each less the bias that the one before has
_MEASURED = 2  # rounds that measure the chains: at the estimate, and less a first bias
_CLOSE = 1e-7  # of a parameter: what hardly moves a bias


@dataclass(frozen=True, kw_only=True)
class Bootstrap:
    """Twins of the records of a problem.

    Their loops are those of the output error of the force, or of instruments, or of least squares
    where these come to nothing, less its bias, which is found again where it leads: noise in the
    loop biases the first least. What is judged by the twins is any method.

    Attributes
    ----------
    problem : Problem
    count : int
    methods : sequence of str
        That may be judged, whose rows are made together.
    has_laws : callable
        Whether the records' controls are the declared law's. Only then may noise be most of what
        their loops leave of the force, and only as much as it is in twins: what another law, or
        another delay, leaves is none.
    loss : str
        Of `ROW_LOSSES`: only squares have twins, as outliers are no noise of a chain.
    """

    problem: Problem
    count: int
    methods: Sequence[str]
    has_laws: Callable[[], bool]
    loss: str = ROW_LOSSES[0]

    @cached_property
    def twins(self) -> Twins | str:
        """Or why there are none."""
        if self.loss != ROW_LOSSES[0]:
            return "rows count by their residuals, and outliers are no noise of a loop"
        why = _FOLLOWS_NOT
        for method in ("didim", "idm-iv", "idm-ls"):
            try:
                fit = with_loops(self.problem, METHODS[method].fitted(self.problem))
                if fit.follows or self.has_laws():
                    twins = self._less_bias(fit)
                    if fit.follows or isinstance(twins, str) or self._leave_as_much(twins, fit):
                        return twins
                why = _FOLLOWS_NOT
            except (ModelError, LoopDataError):  # which the verdict tells
                why = "there is no loop to simulate"
            except (DataError, EstimationError) as error:
                why = str(error).rstrip("; ")
        return why

    def _less_bias(self, fit: Fit) -> Twins | str:
        """At an estimate less the bias that it has there, where that is beyond a deviation."""
        form, model, at, loops = fit.form, Hac(), fit.physical, fit.loops
        standard_errors = np.sqrt(np.diag(model.matrix(fit.solution)))
        chains: tuple[Chain, ...] = ()
        for number in range(_ROUNDS):
            if number < _MEASURED:
                records = zip(self._noisy, self.problem.by_record(loops), strict=True)
                chains = tuple(
                    measured_noise(data, form.own(at, i), of_one)
                    for i, (data, of_one) in enumerate(records)
                )
            twins = Twins(
                problem=self.problem,
                form=form,
                at=at,
                chains=chains,
                count=self.count,
                kinds=self._kinds,
            )
            correction = bootstrap_correction(twins, form, fit.solver, fit.solution, model)
            if correction is None:
                return TOO_FEW
            before, at = at, fit.physical - correction.bias
            change = np.abs(form.regressed(at) - form.regressed(before))
            tolerance = correction.theta_scaled[0] * standard_errors + _CLOSE * np.abs(
                form.regressed(at)
            )
            if np.all(change <= tolerance):
                return twins
            loops = _at(self.problem, form, at)
        return "the parameters of their loops do not settle"

    @cached_property
    def _noisy(self) -> list[FilteredRecord]:
        """The records under filters that leave their noise: their own, or those by default.

        Noise is a record's own, whatever its rows are made by, and below a low cut-off all rows are
        near a turn.
        """
        noisy = []
        for data in self.problem.data:
            default = Prefilter(hold=data.prefilter.hold).at_rate_of(data.period)
            if data.prefilter.cutoff < default.cutoff:
                bound = FilteredRecord.bind(data.axis, data.record, default, data.fastest)
                noisy.append(bound.with_mean_control(data.between))
            else:
                noisy.append(data)
        return noisy

    def _leave_as_much(self, twins: Twins, fit: Fit) -> bool:
        """Whether the loop leaves as much of twins' force as of the records'."""
        problem, form = self.problem, fit.form.at(twins.at)
        rows = problem.simulated_rows(form, twins.at, _at(problem, form, twins.at))
        simulated = rows.predicted(form.regressed(twins.at))
        sides = [fit.measured.left, *(rows.left for rows in twins.rows(form))]
        of_records, *others = (relative_error_percent(left - simulated, left) for left in sides)
        return of_records <= max(others, default=0.0)

    @property
    def _kinds(self) -> tuple[type[Form], ...]:
        """Linear forms of the methods, but for those that the problem has not."""
        kinds = []
        for kind in dict.fromkeys(METHODS[method].form for method in self.methods):
            with suppress(ModelError):
                kinds += [kind] * self.problem.form(kind).is_linear
        return tuple(kinds)


def with_loops(problem: Problem, fit: Fit) -> Fit:
    """A fit with the loops of its records, as far as they follow them without a reference.

    Raises
    ------
    ModelError, DataError, EstimationError
        There are none.
    """
    if fit.loops:
        return fit
    loops = _at(problem, fit.form, fit.physical)
    rows = problem.simulated_rows(fit.form, fit.physical, loops)
    return replace(fit, loops=loops, simulated=rows.predicted(fit.form.regressed(fit.physical)))


def _at(problem: Problem, form: Form, physical: Array) -> tuple[Simulation, ...]:
    return tuple(
        loop
        for i, data in enumerate(problem.data)
        for loop in recorded_loops(data, form.own(physical, i))
    )
