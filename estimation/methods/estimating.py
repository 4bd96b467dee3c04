"""From a problem and a method to an estimate: fit, map, covariances and remarks.

Bias and standard errors are found by the parametric bootstrap of the problem's records.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from axisid.estimation.estimates import (
    COVARIANCES,
    Estimate,
    Inference,
    NotSimulated,
    covariance_of,
    least_freedom,
)
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.noise_models import Chain, noise_free_record, noise_sources
from axisid.estimation.regression import (
    Covariance,
    CovarianceEstimate,
    CovarianceNote,
    DirectForm,
    Form,
    InverseForm,
    condition_number,
    delta_method,
)
from axisid.estimation.signals import resting_axis
from axisid.estimation.thresholds import NO_RELATION
from axisid.estimation.unknowns import perturbed_joint_forms
from axisid.support.arrays import Array, Deferred, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError
from axisid.support.one_thread import in_one_thread

from .least_squares import loss_remarks
from .method import Fit, Method
from .parametric_bootstrap import (
    TOO_FEW,
    Bootstrap,
    BootstrapCorrection,
    bootstrap_correction,
    with_loops,
)

_BOUND_TOLERANCE = 1e-6  # relative distance of a nonlinear parameter from a bound that it is at

_GAIN_STEP = 1e-4  # relative step of the drive gain, for numerical derivatives by the gain
# name of the covariance whose standard errors simulated replicas calibrate; others stay as they are
_PIVOT = "hac"


def estimate_by(
    problem: Problem,
    method: Method,
    lags: int | None = None,
    covariance: str = "hac",
    bootstrap: Bootstrap | None = None,
) -> Estimate:
    """Return the estimate by one method.

    The rows are solved, and the regression's parameters are mapped to the physical ones. The
    covariances without replicas are computed and checked at once. All that needs further simulated
    loops, such as the bias, is computed when it is read.

    Parameters
    ----------
    problem : Problem
    method : Method
    lags : int, optional
        Lags of the autocorrelation-consistent covariance; chosen from the data by default.
    covariance : str
        One of `COVARIANCES`, which intervals, draws and tests use.
    bootstrap : Bootstrap, optional
        Simulated replicas for the bias and the HAC standard errors, where they can be drawn.

    Raises
    ------
    ModelError, LoopDataError
        The axis, or the record, does not allow the method.
    EstimationError
        The rows cannot be solved, or the solution is not finite.
    """
    # Solve the rows, and map the regression's parameters to the physical ones.
    fit = method.fitted(problem)
    form, solution, solver, y = fit.form, fit.solution, fit.solver, fit.measured.left
    weights = problem.row_weights
    physical, jacobian = form.physical(solution.theta)
    # Covariance estimators in the order of results, which is that of fewer and fewer assumptions on
    # the residuals: i.i.d., robust, HAC. `COVARIANCES` has the default, HAC, first.
    models = {name: covariance_of(name, lags) for name in reversed(COVARIANCES)}
    known = _covariance_by_known_values(problem, fit)
    # The covariances by name, with the uncertainty of known values, without replicas.
    applied = _covariances_without_replicas(method, fit, models, known, jacobian)
    # Rows are reported without the weights of their records.
    direct = isinstance(form, DirectForm)
    residuals, left = _unweighted(solution.residuals, weights), _unweighted(y, weights)
    simulated, error = fit.simulated, None
    if not isinstance(simulated, NotSimulated):
        simulated = _unweighted(simulated, weights)
        error = relative_error_percent(left - simulated, left)
    has_times = len(problem.data) > 1 or problem.data[0].record.segments
    pivot = models[_PIVOT]
    return Estimate(
        method=method.name,
        form=form.at(physical),
        quantities=form.physical_quantities,
        theta=solution.theta,
        physical=physical,
        jacobian=jacobian,
        ddm_quantities=form.quantities if direct else (),
        y=left,
        X=_unweighted((solver.slopes or fit.measured).regressor, weights),
        Z=None if solver.loop is None else _unweighted(solver.loop.columns, weights),
        rows=problem.stacked(lambda data: data.sampling.rows),
        neighbours=problem.neighbours,
        times=problem.stacked(lambda data: data.times_of_rows) if has_times else None,
        period=problem.data[0].period,
        row_period=problem.data[0].row_period,
        residuals=residuals,
        simulated=simulated,
        equation_error_percent=relative_error_percent(residuals, left),
        simulation_error_percent=error,
        condition_number=condition_number(fit.measured.regressor),
        iterates=fit.iterates,
        started=fit.started,
        remarks=tuple(_remarks(problem, fit, method.loss)),
        covariance_model=models[covariance],
        chosen=covariance,
        gain_relative_sd=gain_relative_sd(problem),
        deferred=Deferred(lambda: _inference(problem, fit, applied, pivot, known, bootstrap)),
        weights=weights,
        loss=method.loss,
        counts=solution.counts,
    )


def _covariances_without_replicas(
    method: Method,
    fit: Fit,
    models: dict[str, Covariance],
    known: Array,
    jacobian: Array,
) -> dict[str, CovarianceEstimate]:
    """Return the covariances of the regression's parameters, (k, k) each, by name.

    Each estimator in `models` is applied to the residuals of the solution. The part by uncertain
    known values is added. Physical parameters with a covariance that is not finite are refused.

    Parameters
    ----------
    method : Method
        Method, for its name in the error.
    fit : Fit
    models : dict of str to Covariance
        Covariance estimators by name.
    known : (k, k) array
        Uncertainty by values that are known with a standard deviation, which each covariance
        includes.
    jacobian : (p, k) array
        Derivatives of the physical parameters by those of the regression.

    Raises
    ------
    EstimationError
        The residuals or a covariance are not finite, or the left side is zero in every row.
    """
    y, solution = fit.measured.left, fit.solution
    found: dict[str, CovarianceEstimate] = {}
    if float(y @ y) > 0 and np.all(np.isfinite(solution.residuals)):
        found = {name: covariance.applied(solution) for name, covariance in models.items()}
    # Covariances of the physical parameters, which must be finite too.
    mapped = [delta_method(each.matrix, jacobian) for each in found.values()]
    if not mapped or not np.all(np.isfinite(mapped)):
        raise EstimationError(
            f"{method.name}: the regression is not finite, or the {fit.form.left} is zero in every "
            "row. Check the size of the signals and the known terms of the equation of motion.",
            code="not-finite",
        )
    return {name: replace(each, matrix=each.matrix + known) for name, each in found.items()}


def _remarks(problem: Problem, fit: Fit, loss: str) -> Iterator[str]:
    """Yield remarks for the user on an estimate, as sentences.

    They are on the filter, on a simulated loop that does not follow the record, on the loss, on the
    iteration, and on parameters at or beyond a bound. A remark on the filters of several records is
    yielded once.
    """
    remarks = [remark for data in problem.data for remark in data.sampling.filter.remarks()]
    yield from dict.fromkeys(remarks)
    if np.inf > fit.simulation_error_percent > NO_RELATION.value:
        advice = "Check the control law, the reference and the signs and units of the columns"
        resting = resting_axis(problem.rest)
        if resting is not None:
            advice = f"A likely cause is that {resting.sentence}"
        yield f"the simulated loop does not follow the record. {advice}"
    yield from loss_remarks(loss, fit.solution)
    yield from fit.remarks
    form = fit.form
    values = [*zip(form.declared, fit.physical, strict=True)]
    # Nonlinear parameters are searched within their bounds, and may end at a bound.
    searched = () if form.is_linear else form.axis.nonlinear
    for (p, value), is_searched in zip(values, searched, strict=False):
        distance = min(abs(value - p.lower), abs(value - p.upper))
        if is_searched and distance <= _BOUND_TOLERANCE * abs(value):
            yield (
                f"{p.name} = {value:.6g} {p.unit} is at its bound. Without the bound, the search "
                "would go further"
            )
    yield from (p.out_of_bounds(value) for p, value in values if not p.allows(value))


@in_one_thread
def _inference(
    problem: Problem,
    fit: Fit,
    applied: Mapping[str, CovarianceEstimate],
    pivot: Covariance,
    known: Array,
    bootstrap: Bootstrap | None,
) -> Inference:
    """Return the effects of filter, noise and gain on an estimate, and its covariances.

    The errors of the filter are the residuals of loops that are simulated with the estimate and
    then filtered. The derivatives by the drive gain are computed if the gain is uncertain.
    Simulated replicas of the records give the bias, and scale the HAC covariance. A part that
    cannot be computed is None.

    Parameters
    ----------
    problem : Problem
    fit : Fit
    applied : dict of str to CovarianceEstimate
        Covariances of the regression's parameters, by name.
    pivot : Covariance
        Covariance that is scaled by simulated replicas.
    known : (k, k) array
        Uncertainty in each covariance by values that are known with a standard deviation.
    bootstrap : Bootstrap or None
        Simulated replicas for the effects of filter and noise, where they can be drawn.
    """
    solution, form = fit.solution, fit.form.at(fit.physical)
    jacobian = form.physical(solution.theta)[1]
    filter_errors, by_gain, theta_by_gain = None, None, None
    # Values that are not finite are reported as missing. NumPy's warnings would only repeat it.
    with np.errstate(all="ignore"):
        with suppress(ModelError, DataError, EstimationError):
            fit_with_loops = with_loops(problem, fit)
            if fit_with_loops.follows:
                # Residual of the simulated loop itself, by filter, differences and decimation.
                pairs = zip(problem.data, problem.by_record(fit_with_loops.loops), strict=True)
                signals = [noise_free_record(data, loops).signals for data, loops in pairs]
                residuals_of_loop = fit.solver(form, problem.reduced(form, signals)).residuals
                filter_errors = residuals_of_loop / problem.row_weights
        if gain_relative_sd(problem):
            with suppress(DataError, EstimationError):
                by_gain, theta_by_gain = _jacobian_by_gain(form, problem, fit)
        # Covariances without replicas, then the scaled HAC covariance where there are replicas.
        correction = _correction_by_replicas(fit, form, pivot, bootstrap)
        of_theta = {name: each.matrix for name, each in applied.items()}
        of_physical = {name: delta_method(each, jacobian) for name, each in of_theta.items()}
        freedom = {name: each.freedom for name, each in applied.items()}
        notes = {name: each.note for name, each in applied.items()}
        chains: tuple[Chain, ...] = ()
        bias = replica_residuals = replica_errors = None
        if isinstance(correction, str):
            notes[_PIVOT] = replace(notes[_PIVOT], no_replicas=correction)
        else:
            by_known = delta_method(known, jacobian)
            of_theta[_PIVOT] = _scaled(of_theta[_PIVOT], known, *correction.theta_scaled)
            of_physical[_PIVOT] = _scaled(of_physical[_PIVOT], by_known, *correction.scaled)
            notes[_PIVOT] = _with_replicas(notes[_PIVOT], problem, correction)
            replica_residuals = _unweighted(correction.residuals, problem.row_weights)
            if correction.count > 1:
                freedom[_PIVOT] = np.full(len(solution.theta), correction.freedom)
            chains, bias = correction.twins.chains, correction.bias
            replica_errors = correction.theta_error
            # With replicas, the errors of the filter are the mean residuals of the replicas.
            if filter_errors is not None:
                filter_errors = replica_residuals.mean(axis=1)
            if replica_residuals.shape[1] < 2:
                replica_residuals = None
        direct = isinstance(form, DirectForm)
        return Inference(
            covariances=of_physical,
            covariance_notes=notes,
            ddm_covariances=of_theta if direct else {},
            freedom={name: least_freedom(each, jacobian) for name, each in freedom.items()},
            ddm_freedom=freedom if direct else {},
            gain_slopes=by_gain,
            theta_gain_slopes=theta_by_gain,
            noise_free=filter_errors,
            bias=bias,
            twins_residuals=replica_residuals,
            twin_errors=replica_errors,
            chains=chains,
        )


def _jacobian_by_gain(form: Form, problem: Problem, fit: Fit) -> tuple[Array, Array]:
    """Return the derivatives of the parameters by the logarithm of the drive gain.

    The first array has those of the physical parameters, (p,), the second those of the regression's
    parameters, (k,).

    Without known terms every linear parameter is proportional to the gain. A known term does not
    change with the gain, and neither does a force of the drive that does not depend on its gain:
    the parameters then change with the rest of the force. The inverse model is linear in the force,
    which is on the left side only, and has exact derivatives. Those of the direct model are
    differences of two solutions.
    """
    if isinstance(form, InverseForm):
        rows = problem.stacked(lambda data: data.reduce(data.force_by_gain))
        slope = fit.solution.response.T @ (problem.row_weights * rows)
        return slope, slope
    # Signals with a larger and a smaller gain. A measured force does not depend on the gain.
    shifted = [
        [replace(d.signals, force=d.signals.force + step * d.force_by_gain) for d in problem.data]
        for step in (_GAIN_STEP, -_GAIN_STEP)
    ]
    ahead, behind = (fit.solver(form, problem.reduced(form, each)).theta for each in shifted)
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _GAIN_STEP), (ahead - behind) / (2 * _GAIN_STEP)


def _correction_by_replicas(
    fit: Fit, form: Form, pivot: Covariance, bootstrap: Bootstrap | None
) -> BootstrapCorrection | str:
    """Return the correction of an estimate by simulated replicas, or the reason for having none.

    The reason is a text. It is empty if no replicas were requested, with `bootstrap` None.
    """
    if bootstrap is None:
        return ""
    twins = bootstrap.twins
    if isinstance(twins, str):  # the reason why there are no replicas
        return twins.rstrip(".")
    with suppress(EstimationError):  # the solution of a replica may have no covariance
        correction = bootstrap_correction(twins, form, fit.solver, fit.solution, pivot)
        if correction is not None:
            return correction
    return TOO_FEW


def _with_replicas(
    note: CovarianceNote, problem: Problem, correction: BootstrapCorrection
) -> CovarianceNote:
    """Return a covariance's note with the number of replicas that scale it, and their noise.

    If the replicas have no noise, the note says only that.
    """
    chains = correction.twins.chains
    if all(each.is_silent for each in chains):
        return replace(note, is_silent=True)
    axis = problem.axis
    units = axis.coordinate.unit, axis.drive.unit
    noise = tuple(noise_sources(each, *units).sentence for each in chains)
    return replace(note, replicas=correction.count, noise=noise)


def _scaled(covariance: Array, known: Array, scale: Array, correlation: Array) -> Array:
    """Return a covariance scaled by replicas, except for the part by known values, (p, p).

    Parameters
    ----------
    covariance, known : (p, p) array
        Covariance, and its part by values that are known with a standard deviation.
    scale : (p,) array
        Factors of the standard errors.
    correlation : (p, p) array
        Correlation matrix of the scaled part.
    """
    deviations = scale * np.sqrt(np.maximum(np.diag(covariance - known), 0.0))
    return np.outer(deviations, deviations) * correlation + known


def gain_relative_sd(problem: Problem) -> float:
    """Return the relative standard deviation of the drive gain that scaled the force.

    It is 0 for a measured force, and for an estimated gain, whose uncertainty is in the
    covariances.
    """
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.joint_form is not None and problem.joint_form.gain is not None
    return 0.0 if measured or estimated else problem.axis.drive.relative_sd


def _unweighted(values: Array, weights: Array) -> Array:
    """Return rows, (n,) or (n, k), divided by the weights of their records, (n,)."""
    if np.all(weights == 1):
        return values  # not a copy of all rows
    return values / (weights if values.ndim == 1 else weights[:, None])


def _covariance_by_known_values(problem: Problem, fit: Fit) -> Array:
    """Return the part of the regression's covariance by uncertain known values, (k, k).

    Each known value is changed by its standard deviation. This changes the force of the model row
    by row, and the estimate by the influence of the rows. The part is the sum of the outer products
    of the changes of the estimate. It is 0 for exact values.
    """
    joint, theta = problem.joint_form, fit.solution.theta
    if joint is None:
        return np.zeros((len(theta), len(theta)))
    values = dict(zip((q.name for q in joint.quantities), theta, strict=True))
    residuals = _residuals_of_form(problem, joint, values)
    changes = []
    for perturbed in perturbed_joint_forms(problem.axis, joint):
        change_of_rows = residuals - _residuals_of_form(problem, perturbed, values)
        changes.append(fit.solution.response.T @ change_of_rows)
    stacked = np.reshape(changes, (-1, len(theta)))
    return np.asarray(stacked.T @ stacked)


def _residuals_of_form(problem: Problem, form: Form, values: Mapping[str, float]) -> Array:
    """Return the residual of each row of a form, (n,), for parameters by name.

    A parameter without a value counts as 0: the estimated form has no such parameter, because it
    acts only together with a known value that is 0 there.
    """
    rows = problem.reduced(form, [data.signals for data in problem.data])
    return rows.residuals(np.array([values.get(q.name, 0.0) for q in form.quantities]))
