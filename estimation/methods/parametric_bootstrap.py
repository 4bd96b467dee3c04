"""Parametric bootstrap: simulated replicas of a problem's records, and corrections by them."""

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

TOO_FEW = "more than half of the replicas cannot be simulated, or give no estimate"
_FOLLOWS_NOT = "the simulated loop does not follow the record"
_ROUNDS = 4  # of replicas, each with the estimate minus the bias of the previous round
_NOISE_ROUNDS = 2  # rounds that measure the noise: with the estimate, and minus a first bias
_ROUNDING = 1e-9  # of a parameter: rounding by reversals of simulated loops
_NO_CHANGE = 1e-7  # of a parameter: a change that hardly affects a bias


@dataclass(frozen=True, kw_only=True)
class Bootstrap:
    """Simulated replicas of the records of a problem, which serve every method.

    A replica is a loop that is simulated with an estimate and with noise as in the record. The
    estimate is that of DIDIM, which noise biases least, otherwise that of IDM-IV or of least
    squares. Its bias is found with the replicas and subtracted, and the replicas are simulated
    again with the result.

    Attributes
    ----------
    problem : Problem
    count : int
        Number of replicas.
    methods : sequence of str
        Methods that will use the replicas, whose rows are computed together.
    has_laws : callable
        Returns True if the recorded controls follow the declared law. Only then may the replicas
        come from a loop that does not follow the record. The residual of that loop must be no
        larger than in the replicas, so that noise explains it: a residual by another law or another
        delay is not noise.
    loss : str
        One of `ROW_LOSSES`. Only squares have replicas, because outliers are not noise of a signal
        chain.
    """

    problem: Problem
    count: int
    methods: Sequence[str]
    has_laws: Callable[[], bool]
    loss: str = ROW_LOSSES[0]

    @cached_property
    def twins(self) -> Twins | str:
        """Simulated replicas, or the reason why there are none, as text.

        The methods DIDIM, IDM-IV and IDM-LS are tried in this order. The first whose loop follows
        the record, or differs from the record only by noise, gives the replicas.
        """
        if self.loss != ROW_LOSSES[0]:
            return "a robust loss weights the rows, and outliers are not noise of the signals"
        why = _FOLLOWS_NOT
        for method in ("didim", "idm-iv", "idm-ls"):
            try:
                fit = with_loops(self.problem, METHODS[method].fitted(self.problem))
                if fit.follows or self.has_laws():
                    twins = self._unbiased_replicas(fit)
                    # `twins` is a text, the reason, if there are no replicas.
                    if fit.follows or isinstance(twins, str) or self._noise_explains(twins, fit):
                        return twins
                why = _FOLLOWS_NOT
            except (ModelError, LoopDataError):  # the verdict reports the reason
                why = "there is no loop to simulate"
            except (DataError, EstimationError) as error:
                why = str(error).rstrip("; ")
        return why

    def _unbiased_replicas(self, fit: Fit) -> Twins | str:
        """Return replicas simulated with the estimate minus its bias, or why there are none.

        In each round replicas are simulated, and their mean error is subtracted from the estimate.
        The rounds end when no parameter changes by more than its standard error. The noise of the
        records is measured in the first two rounds.
        """
        form, model, at, loops = fit.form, Hac(), fit.physical, fit.loops
        standard_errors = np.sqrt(np.diag(model.matrix(fit.solution)))
        chains: tuple[Chain, ...] = ()
        # Linear forms of the methods that the problem allows, whose rows are computed together.
        kinds: list[type[Form]] = []
        for kind in dict.fromkeys(METHODS[method].form for method in self.methods):
            with suppress(ModelError):
                if self.problem.form(kind).is_linear:
                    kinds.append(kind)
        for number in range(_ROUNDS):
            if number < _NOISE_ROUNDS:
                records = zip(self._records_for_noise, self.problem.by_record(loops), strict=True)
                chains = tuple(
                    measured_noise(data, form.own(at, i), own_loops)
                    for i, (data, own_loops) in enumerate(records)
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
            # End if the bias hardly changes, otherwise simulate with the new estimate.
            before, at = at, fit.physical - correction.bias
            theta = form.regressed(at)
            change = np.abs(theta - form.regressed(before))
            scale, _ = correction.theta_scaled
            tolerance = scale * standard_errors + _NO_CHANGE * np.abs(theta)
            if np.all(change <= tolerance):
                return twins
            loops = _loops_at(self.problem, form, at)
        return "the bias of the estimate does not converge"

    @cached_property
    def _records_for_noise(self) -> list[FilteredRecord]:
        """The records with filters from which their noise can be measured.

        A filter with a lower cut-off than the default is replaced by the default filter: with a low
        cut-off, all rows are near a reversal. The noise of a record does not depend on the filter.
        """
        found = []
        for data in self.problem.data:
            default = Prefilter(hold=data.prefilter.hold).at_rate_of(data.period)
            if data.prefilter.cutoff < default.cutoff:
                bound = FilteredRecord.bind(data.axis, data.record, default, data.fastest)
                found.append(bound.with_mean_control(data.between))
            else:
                found.append(data)
        return found

    def _noise_explains(self, twins: Twins, fit: Fit) -> bool:
        """Return True if the residual of the records is no larger than the largest of the replicas.

        The residual is the left side minus that of the loop without noise, which is simulated with
        the parameters of the replicas. It is compared in percent of the left side (rms).
        """
        problem, form = self.problem, fit.form.at(twins.at)
        rows = problem.simulated_rows(form, twins.at, _loops_at(problem, form, twins.at))
        simulated = rows.predicted(form.regressed(twins.at))
        left = fit.measured.left
        error_of_records = relative_error_percent(left - simulated, left)
        errors_of_replicas = [
            relative_error_percent(replica.left - simulated, replica.left)
            for replica in twins.rows(form)
        ]
        return error_of_records <= max(errors_of_replicas, default=0.0)


def with_loops(problem: Problem, fit: Fit) -> Fit:
    """Return a fit with loops that are simulated with its parameters; unchanged if it has loops.

    A loop follows the recorded reference, or the recorded motion where no reference was recorded.

    Raises
    ------
    ModelError, DataError, EstimationError
        No loops can be simulated.
    """
    if fit.loops:
        return fit
    loops = _loops_at(problem, fit.form, fit.physical)
    rows = problem.simulated_rows(fit.form, fit.physical, loops)
    return replace(fit, loops=loops, simulated=rows.predicted(fit.form.regressed(fit.physical)))


def _loops_at(problem: Problem, form: Form, physical: Array) -> tuple[Simulation, ...]:
    """Return the loops of all records, simulated with physical parameters, (p,).

    There is one loop for each segment of each record.
    """
    loops: list[Simulation] = []
    for i, data in enumerate(problem.data):
        loops += recorded_loops(data, form.own(physical, i))
    return tuple(loops)


@dataclass(frozen=True, slots=True, kw_only=True)
class BootstrapCorrection:
    """Correction of an estimate's bias and standard errors by simulated replicas.

    Attributes
    ----------
    twins : Twins
        Simulated replicas.
    off : (R, p) array
        Errors of the physical parameters in R replicas: the estimate from a replica minus the
        parameters that it was simulated with.
    theta_error : (R, k) array
        Errors of the regression's own parameters.
    scaled : (p,) array, (p, p) array
        Factors of the standard errors of the physical parameters, and the correlation matrix of the
        replicas' errors. With too few replicas, the matrix is that of the estimate's covariance.
    theta_scaled : (k,) array, (k, k) array
        The same two for the regression's own parameters.
    residuals : (n, R) array
        Residuals of the estimator in the replicas.
    """

    twins: Twins
    off: Array
    theta_error: Array
    scaled: tuple[Array, Array]
    theta_scaled: tuple[Array, Array]
    residuals: Array

    @property
    def count(self) -> int:
        """Number of replicas."""
        return len(self.off)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of `scaled`, and of Student's distribution of the intervals.

        Infinite for a single replica, with which the covariance is not scaled. Otherwise they are
        those of replicas in antithetic pairs, see `pair_freedom`.
        """
        return pair_freedom(self.count) if self.count > 1 else np.inf

    @property
    def bias(self) -> Array:
        """Mean error of the replicas, (p,)."""
        return np.asarray(self.off.mean(axis=0))


def bootstrap_correction(
    twins: Twins,
    form: Form,
    solver: Solver,
    solution: Solution,
    covariance: Covariance,
) -> BootstrapCorrection | None:
    """Return the correction of an estimate by replicas: its bias, and factors of standard errors.

    Each replica is solved in the same way as the records. None where too few can be solved.

    This is the bootstrap-t of [EfronTibshirani1993]_: the errors of the replicas, each divided by
    its own standard error, give the distribution of the pivot. With the standard errors ``h_r`` of
    the replicas and ``h`` of the records, ``s = sd_r((theta_r - theta_0) / h_r)``, the interval is
    ``theta - bias +- t_nu s h`` with Student's ``t_nu`` and the degrees of freedom ``nu`` of
    `BootstrapCorrection.freedom`.

    Parameters
    ----------
    twins : Twins
        Simulated replicas.
    form : Form
        Form at the estimate.
    solver : Solver
        Solver of the estimate.
    solution : Solution
        Solution of the records.
    covariance : Covariance
        Estimator of the covariances whose standard errors h are scaled.

    Returns
    -------
    BootstrapCorrection or None
        None where too few replicas can be solved.
    """
    solved = twins.solutions(form, solver)
    if not 0 < twins.count <= 2 * len(solved):
        return None
    jacobian = form.physical(solution.theta)[1]
    # Errors of the replicas: their estimates minus the parameters that they were simulated with.
    regressed = form.regressed(twins.at)
    theta_error = np.array([each.theta for each in solved]) - regressed
    off = np.array([form.physical(each.theta)[0] for each in solved]) - twins.at
    # Covariances of the records, and then of each replica.
    of_theta = [covariance.matrix(each) for each in (solution, *solved)]
    of_physical = [delta_method(each, jacobian) for each in of_theta]
    return BootstrapCorrection(
        twins=twins,
        off=off,
        theta_error=theta_error,
        scaled=_scale_and_correlation(off, of_physical, twins.at),
        theta_scaled=_scale_and_correlation(theta_error, of_theta, regressed),
        residuals=np.column_stack([each.residuals for each in solved]),
    )


def _scale_and_correlation(
    errors: Array, covariances: list[Array], at: Array
) -> tuple[Array, Array]:
    """Return the factors of the standard errors by replicas, and the correlation of the errors.

    Parameters
    ----------
    errors : (R, p) array
        Errors of the parameters in the replicas.
    covariances : list of (p, p) arrays
        Covariance of the estimate from the records, then of the estimate from each replica.
    at : (p,) array
        Parameters of the simulated loops. Scaled standard errors are at least 1e-9 of these, which
        is the rounding of a loop.

    Returns
    -------
    scale : (p,) array
        Standard deviation of the errors divided by their standard errors; 1 for a single replica.
    correlations : (p, p) array
        Correlation matrix of the errors; that of the estimate's covariance for few replicas.
    """
    if len(errors) == 1:
        return np.ones(len(at)), np.nan_to_num(correlation(covariances[0]))
    # First row: the rounding, divided by the standard errors of the records. The other rows: the
    # centred errors of the replicas, each divided by the standard errors of its replica.
    deviations = np.sqrt(np.maximum([np.diag(each) for each in covariances], 0.0))
    centred = np.vstack([_ROUNDING * np.abs(at), errors - errors.mean(axis=0)])
    least, *t = np.divide(centred, deviations, out=np.zeros_like(centred), where=deviations > 0)
    scale = np.maximum(np.std(t, axis=0, ddof=1), least)
    # Two antithetic replicas are one sample, to first order.
    matrix = covariances[0]
    if len(errors) // 2 > len(at):
        matrix = np.atleast_2d(np.cov(centred[1:].T))
    correlations = np.nan_to_num(correlation(matrix))
    np.fill_diagonal(correlations, 1.0)
    return scale, correlations
