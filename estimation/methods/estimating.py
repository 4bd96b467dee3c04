"""From a problem and a method to an estimate: fit, map, covariances, bias and remarks."""

from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.estimation.estimates import COVARIANCES, Estimate, NotSimulated
from axisid.estimation.problems import (
    NoiseFree,
    Problem,
    confirmed,
    encoder_error,
    noise_free,
    noise_free_at,
    noise_free_following,
    settled_noise_free,
    slopes_by_gain,
)
from axisid.estimation.regression import (
    Covariance,
    DirectForm,
    Form,
    Solution,
    StepsError,
    condition_number,
    delta_method,
    encoder_step,
)
from axisid.estimation.signals import rests_first
from axisid.estimation.thresholds.estimates import (
    BOUND_TOLERANCE,
    MIN_ROWS_PER_PARAMETER,
    NO_RELATION,
)
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError
from axisid.support.remedy import Note

from .known_spread import known_spread
from .method import Fit, Method


def estimate_by(
    problem: Problem, method: Method, lags: int | None = None, covariance: str = "hac"
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
    covariances = _covariances(method, fit, models, known_spread(problem, fit))
    names = {name: c.describe(solution) for name, c in models.items()}
    at = form.at(physical)
    first = _noise_free(at, problem, fit, physical)
    stepped = _encoder_error(first, at, problem, fit, physical, covariances["hac"])
    for name in covariances:
        if stepped is not None and COVARIANCES[name].allows_autocorrelation:
            covariances[name] = covariances[name] + stepped.covariance
            names[name] += _and_steps(stepped, problem)
    mapped = {name: _mapped(method, form, c, jacobian) for name, c in covariances.items()}
    freedom = {name: model.freedom(solution) for name, model in models.items()}
    direct = isinstance(form, DirectForm)
    model = models[covariance]
    deviations = np.sqrt(np.maximum(np.diag(mapped[covariance]), 0.0))
    residuals = own(solution.residuals, weights)
    plain = replace(solution, residuals=residuals)
    quiet = _settled(first, at, problem, fit, plain, physical, deviations, model)
    slopes = _slopes(at, problem, fit)
    remarks = (*_remarks(problem, fit), *fit.remarks, *_outside_bounds(form, physical))
    left, simulated = own(y, weights), fit.simulated
    if not isinstance(simulated, NotSimulated):
        simulated = own(simulated, weights)
    return Estimate(
        method=method.name,
        form=at,
        quantities=form.physical_quantities,
        theta=solution.theta,
        physical=physical,
        covariances=mapped,
        jacobian=jacobian,
        ddm_quantities=form.quantities if direct else (),
        ddm_covariances=covariances if direct else {},
        freedom={name: _fewest(f, jacobian) for name, f in freedom.items()},
        ddm_freedom=freedom if direct else {},
        y=left,
        X=own(fit.measured.regressor, weights),
        Z=None if fit.instruments is None else own(fit.instruments.columns, weights),
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
        covariance_names=names,
        remarks=tuple(map(Note.of, remarks)),
        covariance_model=model,
        chosen=covariance,
        gain_relative_sd=_gain_relative_sd(problem),
        gain_slopes=slopes[0],
        theta_gain_slopes=slopes[1],
        noise_free=quiet,
        weights=weights,
    )


def own(values: Array, weights: Array | None) -> Array:
    """Rows, (n,) or (n, k), as they were before each was weighted."""
    if weights is None:
        return values
    return values / (weights if values.ndim == 1 else weights[:, None])


def _covariances(
    method: Method, fit: Fit, models: dict[str, Covariance], known: Array | None
) -> dict[str, Array]:
    """Of the regression's own parameters, by name; refused where the residuals are not finite.

    To each is added what comes of values that are known with a deviation, (k, k).
    """
    y = fit.measured.left
    if not (float(y @ y) > 0 and np.all(np.isfinite(fit.solution.residuals))):
        raise _not_finite(method, fit.form)
    found = {name: covariance.matrix(fit.solution) for name, covariance in models.items()}
    return found if known is None else {name: matrix + known for name, matrix in found.items()}


def _mapped(method: Method, form: Form, covariance: Array, jacobian: Array) -> Array:
    mapped = delta_method(covariance, jacobian)
    if not np.all(np.isfinite(mapped)):
        raise _not_finite(method, form)
    return mapped


def _fewest(freedom: Array, jacobian: Array) -> Array:
    """Degrees of freedom of mapped parameters, (p,): the fewest of those that each is made of."""
    return np.asarray(np.min(np.where(jacobian != 0, freedom, np.inf), axis=1), dtype=float)


def _not_finite(method: Method, form: Form) -> EstimationError:
    return EstimationError(
        f"{method.name}: the regression is not finite, or the {form.left} is zero in every row; "
        "check the signals' size and the known terms of the equation of motion.",
        code="regression-not-finite",
    )


def _gain_relative_sd(problem: Problem) -> float:
    """Of the gain that scaled the force; 0 for a measured force, and where it is estimated."""
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.layout is not None and problem.layout.gain is not None
    return 0.0 if measured or estimated else problem.axis.axis.drive.relative_sd


def _row_times(problem: Problem) -> Array | None:
    """Of rows that are not the period times their number, since their record's first sample."""
    times = [data.row_times for data in problem.data]
    return times[0] if len(times) == 1 else problem.stacked(lambda data: data.times_of_rows)


def _noise_free(form: Form, problem: Problem, fit: Fit, physical: Array) -> NoiseFree | None:
    """What the filter makes of the estimate's own loop; None where there is none that follows."""
    if fit.follows:
        with suppress(DataError, EstimationError):  # rows of a simulated record may not be solved
            return noise_free(form, problem, fit.loops, physical, fit.instruments)
    return None


def _settled(
    first: NoiseFree | None,
    form: Form,
    problem: Problem,
    fit: Fit,
    solution: Solution,
    physical: Array,
    deviations: Array,
    covariance: Covariance,
) -> NoiseFree | None:
    """The same where it leads, or by a loop that follows the record; None where there is none."""
    if not fit.follows:
        return _noise_free_following(form, problem, fit, physical, deviations)
    if first is None:
        return None
    with suppress(DataError, EstimationError):  # nor those of another loop
        found_at = partial(noise_free_at, form, problem, instruments=fit.instruments)
        quiet = settled_noise_free(first, found_at, physical, deviations)
        return quiet if quiet is first else confirmed(quiet, solution, covariance)
    return None


def _noise_free_following(
    form: Form, problem: Problem, fit: Fit, physical: Array, deviations: Array
) -> NoiseFree | None:
    """The same of loops that follow records without a reference; None where there are none."""
    alone = len(problem.data) == 1 and problem.layout is None
    if alone and problem.data[0].record.reference is None:
        with suppress(ModelError, DataError, EstimationError):
            found_at = partial(noise_free_following, form, problem, fit.measured.left)
            first = found_at(physical)
            return first and settled_noise_free(first, found_at, physical, deviations)
    return None


def _slopes(form: Form, problem: Problem, fit: Fit) -> tuple[Array | None, Array | None]:
    """What the gain moves the estimate by, and the regression's parameters."""
    if _gain_relative_sd(problem):
        with suppress(DataError, EstimationError):  # nor those of another gain
            return slopes_by_gain(form, problem, fit.solution, fit.instruments)
    return None, None


def _encoder_error(
    quiet: NoiseFree | None,
    form: Form,
    problem: Problem,
    fit: Fit,
    physical: Array,
    covariance: Array,
) -> StepsError | None:
    """What the encoder's steps do, against a covariance (k, k) of the fit."""
    if quiet is None:
        return None
    deviations = np.sqrt(np.diag(covariance))
    with suppress(DataError, EstimationError):  # nor rows of a loop with such an encoder
        return encoder_error(form, problem, quiet, physical, fit.instruments, deviations)
    return None


def _and_steps(stepped: StepsError, problem: Problem) -> str:
    """What a covariance holds besides, for notes."""
    steps = [encoder_step(problem.axis, data.record) for data in problem.data]
    unit = problem.axis.axis.coordinate.unit
    return (
        f", with what {stepped.loops} simulated loops have by an encoder's steps of "
        f"{max(steps):.3g} {unit}"
    )


def _remarks(problem: Problem, fit: Fit) -> list[str | Note]:
    """What the user should know whatever the method."""
    measured, simulated = fit.measured, fit.simulated
    every = (data.sampling.filter.remarks() for data in problem.data)
    remarks: list[str | Note] = [*dict.fromkeys(remark for of_one in every for remark in of_one)]
    n, k = measured.regressor.shape
    if n < MIN_ROWS_PER_PARAMETER.value * k:
        remarks.append(
            f"{n} rows for {k} parameters are few: standard deviations cannot be believed; "
            "record longer, or decimate less"
        )
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
            and min(abs(value - p.lower), abs(value - p.upper))
            <= BOUND_TOLERANCE.value * abs(value)
        ]
        if not form.is_linear
        else []
    )
    return stopped + [
        p.out_of_bounds(value)
        for p, value in zip(form.declared, physical, strict=True)
        if not p.allows(value)
    ]
