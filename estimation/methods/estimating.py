"""From a problem and a method to an estimate: fit, map, covariances and remarks."""

from dataclasses import replace

import numpy as np

from axisid.estimation.estimates import COVARIANCES, Estimate, NotSimulated, few_rows
from axisid.estimation.problems import Problem
from axisid.estimation.regression import (
    Applied,
    Covariance,
    DirectForm,
    Form,
    condition_number,
    delta_method,
)
from axisid.estimation.signals import rests_first
from axisid.estimation.thresholds import NO_RELATION
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.deferred import Deferred
from axisid.support.errors import EstimationError
from axisid.support.remedy import Note

from .bootstrap import Bootstrap
from .fitted_point import FittedPoint, gain_relative_sd, own_rows
from .known_spread import known_spread
from .method import Fit, Method
from .robust import loss_remarks

_BOUND_TOLERANCE = 1e-6  # relative distance of a nonlinear parameter from a bound that it is at


def estimate_by(
    problem: Problem,
    method: Method,
    lags: int | None = None,
    covariance: str = "hac",
    bootstrap: Bootstrap | None = None,
) -> Estimate:
    """An estimate by one method.

    Parameters
    ----------
    problem : Problem
    method : Method
    lags : int, optional
        Of the autocorrelation-consistent covariance; chosen from the data by default.
    covariance : str
        Of `COVARIANCES`: what intervals, draws and tests are of.
    bootstrap : Bootstrap, optional
        Whose twins tell bias and HAC deviations, where they can be drawn.

    Raises
    ------
    ModelError, LoopDataError
        The axis, or the record, does not allow the method.
    EstimationError
        The rows cannot be solved, or what comes of them is not finite.
    """
    fit = method.fit(problem)
    form, solution, y = fit.form, fit.solution, fit.measured.left
    weights = problem.row_weights
    physical, jacobian = form.physical(solution.theta)
    models = {name: COVARIANCES[name].covariance(lags) for name in reversed(COVARIANCES)}
    known = known_spread(problem, fit)
    applied = _applied(method, fit, models, known, jacobian)
    freedom = {name: each.freedom for name, each in applied.items()}
    direct = isinstance(form, DirectForm)
    residuals, left = own_rows(solution.residuals, weights), own_rows(y, weights)
    point = FittedPoint(
        problem=problem,
        fit=fit,
        form=form.at(physical),
        jacobian=jacobian,
        applied=applied,
        pivot=models["hac"],
        known=known,
        bootstrap=bootstrap,
    )
    remarks = (
        *_remarks(problem, fit),
        *loss_remarks(method.loss, solution),
        *fit.remarks,
        *_outside_bounds(form, physical),
    )
    simulated = fit.simulated
    if not isinstance(simulated, NotSimulated):
        simulated = own_rows(simulated, weights)
    return Estimate(
        method=method.name,
        form=point.form,
        quantities=form.physical_quantities,
        theta=solution.theta,
        physical=physical,
        jacobian=jacobian,
        ddm_quantities=form.quantities if direct else (),
        freedom={name: _fewest(f, jacobian) for name, f in freedom.items()},
        ddm_freedom=freedom if direct else {},
        y=left,
        X=own_rows(fit.measured.regressor, weights),
        Z=None if fit.instruments is None else own_rows(fit.instruments.columns, weights),
        rows=problem.stacked(lambda data: data.row_numbers),
        neighbours=problem.neighbours,
        times=_row_times(problem),
        period=problem.data[0].period,
        row_period=problem.row_period,
        residuals=residuals,
        simulated=simulated,
        equation_error_percent=relative_error_percent(residuals, left),
        simulation_error_percent=None
        if isinstance(simulated, NotSimulated)
        else relative_error_percent(left - simulated, left),
        condition_number=condition_number(fit.measured.regressor),
        iterates=fit.iterates,
        started=fit.started,
        remarks=tuple(map(Note.of, remarks)),
        covariance_model=models[covariance],
        chosen=covariance,
        gain_relative_sd=gain_relative_sd(problem),
        deferred=Deferred(point.inference),
        weights=weights,
        loss=method.loss,
        counts=solution.counts,
    )


def _applied(
    method: Method,
    fit: Fit,
    models: dict[str, Covariance],
    known: Array | None,
    jacobian: Array,
) -> dict[str, Applied]:
    """Covariances of the regression's own parameters, by name; refused where they are not finite.

    To each is added what comes of values that are known with a deviation, (k, k).
    """
    y = fit.measured.left
    if not (float(y @ y) > 0 and np.all(np.isfinite(fit.solution.residuals))):
        raise _not_finite(method, fit.form)
    found = {name: covariance.applied(fit.solution) for name, covariance in models.items()}
    if not all(np.all(np.isfinite(delta_method(a.matrix, jacobian))) for a in found.values()):
        raise _not_finite(method, fit.form)
    if known is None:
        return found
    return {name: replace(each, matrix=each.matrix + known) for name, each in found.items()}


def _fewest(freedom: Array, jacobian: Array) -> Array:
    """Degrees of freedom of mapped parameters, (p,): the fewest of those that each is made of."""
    return np.asarray(np.min(np.where(jacobian != 0, freedom, np.inf), axis=1), dtype=float)


def _not_finite(method: Method, form: Form) -> EstimationError:
    return EstimationError(
        f"{method.name}: the regression is not finite, or the {form.left} is zero in every row; "
        "check the signals' size and the known terms of the equation of motion.",
        code="regression-not-finite",
    )


def _row_times(problem: Problem) -> Array | None:
    """Of rows that are not the period times their number, since their record's first sample."""
    times = [data.row_times for data in problem.data]
    return times[0] if len(times) == 1 else problem.stacked(lambda data: data.times_of_rows)


def _remarks(problem: Problem, fit: Fit) -> list[str | Note]:
    """What the user should know whatever the method."""
    measured, simulated = fit.measured, fit.simulated
    every = (data.sampling.filter.remarks() for data in problem.data)
    remarks: list[str | Note] = [*dict.fromkeys(remark for of_one in every for remark in of_one)]
    if few := few_rows(*measured.regressor.shape):
        remarks.append(f"{few}; record longer, or decimate less")
    if isinstance(simulated, NotSimulated):
        return remarks
    if relative_error_percent(measured.left - simulated, measured.left) > NO_RELATION.value:
        remarks.append(
            Note.of(
                "the simulated loop does not follow the record; ",
                rests_first(problem.rest)
                or "check the control law, the reference and the signs and units of the columns",
            )
        )
    return remarks


def _outside_bounds(form: Form, physical: Array) -> list[str]:
    axis = form.axis
    stopped = (
        [
            f"{p.name} = {value:.6g} {p.unit} is at its bound: the search would go further"
            for p, value, is_nonlinear in zip(form.declared, physical, axis.nonlinear, strict=True)
            if is_nonlinear
            and min(abs(value - p.lower), abs(value - p.upper)) <= _BOUND_TOLERANCE * abs(value)
        ]
        if not form.is_linear
        else []
    )
    return stopped + [
        p.out_of_bounds(value)
        for p, value in zip(form.declared, physical, strict=True)
        if not p.allows(value)
    ]
