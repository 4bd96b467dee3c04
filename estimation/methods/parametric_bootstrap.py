"""The parametric bootstrap: twins of a problem's records, and what they tell of an estimate."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.noise_models import Chain, Twins, measured_noise, pair_freedom
from axisid.estimation.regression import (
    Covariance,
    Form,
    Hac,
    LoopDataError,
    Solution,
    correlation,
    delta_method,
    recorded_loops,
)
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
_ROUNDING = 1e-9  # of a parameter: what simulated loops that reverse make of the last digit
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
        kinds: list[type[Form]] = []  # linear forms of the methods that the problem has
        for kind in dict.fromkeys(METHODS[method].form for method in self.methods):
            with suppress(ModelError):
                kinds += [kind] * self.problem.form(kind).is_linear
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
                kinds=tuple(kinds),
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


@dataclass(frozen=True, slots=True, kw_only=True)
class BootstrapCorrection:
    """What twins tell of an estimate.

    Attributes
    ----------
    twins : Twins
    off : (R, p) array
        The twins' physical parameters, less those of their loops.
    theta_error : (R, k) array
        The same of the regression's own parameters.
    scaled : (p,) array, (p, p) array
        What deviations are to be multiplied by, and the correlation as the twins scatter; of the
        covariance where they are too few to tell it.
    theta_scaled : (k,) array, (k, k) array
        The same of the regression's own parameters.
    residuals : (n, R) array
        What the estimator leaves of the twins.
    """

    twins: Twins
    off: Array
    theta_error: Array
    scaled: tuple[Array, Array]
    theta_scaled: tuple[Array, Array]
    residuals: Array

    @property
    def count(self) -> int:
        """How many twins tell it."""
        return len(self.off)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of `scaled`, and of Student's distribution of the intervals.

        Infinite for a single twin, of which the covariance is told. Else see `pair_freedom`.
        """
        return pair_freedom(self.count) if self.count > 1 else np.inf

    @property
    def bias(self) -> Array:
        """Mean of what the twins are off by, (p,)."""
        return np.asarray(self.off.mean(axis=0))


def bootstrap_correction(
    twins: Twins,
    form: Form,
    solver: Solver,
    solution: Solution,
    covariance: Covariance,
) -> BootstrapCorrection | None:
    """Bias of an estimate, and what its deviations lack; None where too few twins can be solved.

    A covariance is the pivot, whose law the twins have: what they are off by in their own
    deviations, the bootstrap-t of [EfronTibshirani1993]_. With the deviations ``h_r`` of the twins
    and ``h`` of the records, ``s = sd_r((theta_r - theta_0) / h_r)``, the interval is
    ``theta - bias +- t_nu s h`` with Student's ``t_nu`` and the degrees of freedom ``nu`` of
    `BootstrapCorrection.freedom`.

    Parameters
    ----------
    twins : Twins
    form : Form
        At the estimate.
    solver : Solver
        Of the estimate.
    solution : Solution
        Of the records.
    covariance : Covariance

    Returns
    -------
    BootstrapCorrection or None
    """
    solved = twins.solutions(form, solver)
    if not 0 < twins.count <= 2 * len(solved):
        return None
    jacobian = form.physical(solution.theta)[1]
    regressed = form.regressed(twins.at)
    theta_error = np.array([each.theta for each in solved]) - regressed
    off = np.array([form.physical(each.theta)[0] for each in solved]) - twins.at
    # Of the records, and then of each twin.
    own_covariances = [covariance.matrix(each) for each in (solution, *solved)]
    covariances = [delta_method(each, jacobian) for each in own_covariances]
    return BootstrapCorrection(
        twins=twins,
        off=off,
        theta_error=theta_error,
        scaled=_pivot(off, covariances, twins.at),
        theta_scaled=_pivot(theta_error, own_covariances, regressed),
        residuals=np.column_stack([each.residuals for each in solved]),
    )


def _pivot(off: Array, covariances: list[Array], at: Array) -> tuple[Array, Array]:
    """Deviation of what twins are off by beside their bias, in their own; and its correlation.

    Parameters
    ----------
    off : (R, p) array
    covariances : list of (p, p) arrays
        Of the estimate, whose deviations are no less than rounding of a loop, and each twin's own.
    at : (p,) array
        Parameters of their loops.
    """
    if len(off) == 1:
        return np.ones(len(at)), np.nan_to_num(correlation(covariances[0]))
    deviations = np.sqrt(np.maximum([np.diag(each) for each in covariances], 0.0))
    centred = np.vstack([_ROUNDING * np.abs(at), off - off.mean(axis=0)])
    least, *t = np.divide(centred, deviations, out=np.zeros_like(centred), where=deviations > 0)
    scale = np.maximum(np.std(t, axis=0, ddof=1), least)
    # Opposite twins are one sample of a straight line.
    tells = len(off) // 2 > len(at)
    matrix = np.atleast_2d(np.cov(centred[1:].T)) if tells else covariances[0]
    correlations = np.nan_to_num(correlation(matrix))
    np.fill_diagonal(correlations, 1.0)
    return scale, correlations
