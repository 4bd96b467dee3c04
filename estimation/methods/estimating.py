"""From a problem and a method to an estimate: fit, map, covariances and remarks."""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.estimates import (
    COVARIANCES,
    Estimate,
    Inference,
    NotSimulated,
    covariance_of,
    few_rows,
    fewest,
)
from axisid.estimation.parameters import moved_layouts
from axisid.estimation.problems import Problem, noise_free_residuals, slopes_by_gain
from axisid.estimation.regression import (
    Covariance,
    CovarianceEstimate,
    DirectForm,
    Form,
    condition_number,
    delta_method,
)
from axisid.estimation.signals import rests_first
from axisid.estimation.thresholds import NO_RELATION
from axisid.estimation.twins import BootstrapCorrection, Chain, Twins, bootstrap_correction
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.deferred import Deferred
from axisid.support.errors import DataError, EstimationError, ModelError

from .bootstrap import TOO_FEW, Bootstrap, with_loops
from .method import Fit, Method, loss_remarks

_BOUND_TOLERANCE = 1e-6  # relative distance of a nonlinear parameter from a bound that it is at

_PIVOT = "hac"  # whose deviations twins scale


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
    models = {name: covariance_of(name, lags) for name in reversed(COVARIANCES)}
    known = _known_spread(problem, fit)
    applied = _applied(method, fit, models, known, jacobian)
    direct, solver = isinstance(form, DirectForm), fit.solver
    residuals, left = _own_rows(solution.residuals, weights), _own_rows(y, weights)
    point = _FittedPoint(
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
        simulated = _own_rows(simulated, weights)
    return Estimate(
        method=method.name,
        form=point.form,
        quantities=form.physical_quantities,
        theta=solution.theta,
        physical=physical,
        jacobian=jacobian,
        ddm_quantities=form.quantities if direct else (),
        y=left,
        X=_own_rows((solver.slopes or fit.measured).regressor, weights),
        Z=None if solver.loop is None else _own_rows(solver.loop.columns, weights),
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
        remarks=remarks,
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
) -> dict[str, CovarianceEstimate]:
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


def _not_finite(method: Method, form: Form) -> EstimationError:
    return EstimationError(
        f"{method.name}: the regression is not finite, or the {form.left} is zero in every row; "
        "check the signals' size and the known terms of the equation of motion.",
        code="not-finite",
    )


def _row_times(problem: Problem) -> Array | None:
    """Of rows that are not the period times their number, since their record's first sample."""
    times = [data.row_times for data in problem.data]
    return times[0] if len(times) == 1 else problem.stacked(lambda data: data.times_of_rows)


def _remarks(problem: Problem, fit: Fit) -> list[str]:
    """What the user should know whatever the method."""
    every = (data.sampling.filter.remarks() for data in problem.data)
    remarks: list[str] = [*dict.fromkeys(remark for of_one in every for remark in of_one)]
    if few := few_rows(*fit.measured.regressor.shape):
        remarks.append(f"{few}; record longer, or decimate less")
    if math.inf > fit.simulation_error_percent > NO_RELATION.value:
        remarks.append(
            "the simulated loop does not follow the record; "
            + (
                rests_first(problem.rest)
                or "check the control law, the reference and the signs and units of the columns"
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


@dataclass(frozen=True, slots=True, kw_only=True)
class _FittedPoint:
    """A fit at its point, with what its solution alone tells of its error.

    Attributes
    ----------
    problem : Problem
    fit : Fit
    form : Form
        At the estimate.
    jacobian : (p, k) array
        Of the physical parameters by the regression's own.
    applied : dict of str to Applied
        The covariances of the regression's own parameters.
    pivot : Covariance
        That twins scale.
    known : (k, k) array or None
        What values that are known with a deviation add to each covariance.
    bootstrap : Bootstrap or None
        Whose twins tell what filter and noise do, where they can be drawn.
    """

    problem: Problem
    fit: Fit
    form: Form
    jacobian: Array
    applied: Mapping[str, CovarianceEstimate]
    pivot: Covariance
    known: Array | None = None
    bootstrap: Bootstrap | None = None

    def inference(self) -> Inference:
        """What filter, noise and gain do to the estimate, and its covariances with that."""
        # What is not finite is told by what is missing; NumPy's own warnings would only repeat it.
        with np.errstate(all="ignore"):
            quiet, found = self._noise_free(), self._calibrated()
            own = {name: each.matrix for name, each in self.applied.items()}
            mapped = {name: delta_method(each, self.jacobian) for name, each in own.items()}
            freedom = {name: each.freedom for name, each in self.applied.items()}
            names = {n: f"{each.description}{self._widened(n)}" for n, each in self.applied.items()}
            if isinstance(found, str):
                names[_PIVOT] += found
                chains: tuple[Chain, ...] = ()
                bias = left = off = None
            else:
                twins, told = found
                known = np.zeros_like(own[_PIVOT]) if self.known is None else self.known
                by_known = delta_method(known, self.jacobian)
                own[_PIVOT] = _scaled(own[_PIVOT], known, told.own_scale, told.own_correlation)
                mapped[_PIVOT] = _scaled(mapped[_PIVOT], by_known, told.scale, told.correlation)
                names[_PIVOT] += self._noise(twins, told.count)
                left = _own_rows(told.residuals, self.problem.row_weights)
                if told.count > 1:
                    freedom[_PIVOT] = np.full(len(told.own_scale), float(told.freedom))
                chains, bias, off = twins.chains, told.bias, told.own_off
                if quiet is not None:
                    quiet = left.mean(axis=1)
            direct = isinstance(self.form, DirectForm)
            by_gain, theta_by_gain = self._slopes()
            return Inference(
                covariances=mapped,
                covariance_names=names,
                ddm_covariances=own if direct else {},
                freedom={name: fewest(each, self.jacobian) for name, each in freedom.items()},
                ddm_freedom=freedom if direct else {},
                gain_slopes=by_gain,
                theta_gain_slopes=theta_by_gain,
                noise_free=quiet,
                bias=bias,
                twins_residuals=None if left is None or left.shape[1] < 2 else left,
                twins_off=off,
                chains=chains,
            )

    def _calibrated(self) -> tuple[Twins, BootstrapCorrection] | str:
        """What twins tell; or, as a part of a note, that none do."""
        if self.bootstrap is None:
            return ""
        twins = self.bootstrap.twins
        if isinstance(twins, str):
            return f", by no twins: {twins.rstrip('.')}"
        fit = self.fit
        with suppress(EstimationError):  # the solution of a twin may have no covariance
            found = bootstrap_correction(twins, self.form, fit.solver, fit.solution, self.pivot)
            if found is not None:
                return twins, found
        return f", by no twins: {TOO_FEW}"

    def _noise(self, twins: Twins, count: int) -> str:
        if all(each.is_silent for each in twins.chains):
            return ", of a loop that shows no noise"
        axis = self.problem.axis.axis
        noise = [each.told(axis.coordinate.unit, axis.drive.unit) for each in twins.chains]
        if len(noise) > 1:
            noise = [f"record {number}: {told}" for number, told in enumerate(noise, 1)]
        return f", as {count} twins with {'; '.join(noise)} scatter"

    def _noise_free(self) -> Array | None:
        """What is left of the estimate's own loop; None where it does not follow."""
        with suppress(ModelError, DataError, EstimationError):
            fit = with_loops(self.problem, self.fit)
            if fit.follows:
                return noise_free_residuals(self.form, self.problem, fit.loops, fit.solver)
        return None

    def _slopes(self) -> tuple[Array | None, Array | None]:
        """What the gain moves the estimate by, and the regression's parameters."""
        if gain_relative_sd(self.problem):
            with suppress(DataError, EstimationError):  # nor those of another gain
                fit = self.fit
                return slopes_by_gain(self.form, self.problem, fit.solution, fit.solver)
        return None, None

    def _widened(self, name: str) -> str:
        """Whose deviations are those of autoregressive residuals, as scores are few; for notes."""
        widened = self.applied[name].widened
        if widened is None or not np.any(widened):
            return ""
        of_some = np.any(self.jacobian[:, widened] != 0, axis=1)
        named = [p.name for p, yes in zip(self.form.declared, of_some, strict=True) if yes]
        return (
            f"; {', '.join(named)}: the larger deviation of residuals that are an AR(1), as few "
            "scores are independent"
        )


def _scaled(covariance: Array, known: Array, scale: Array, correlation: Array) -> Array:
    """A covariance as twins scatter, but for what known values add: they are no noise."""
    deviations = scale * np.sqrt(np.maximum(np.diag(covariance - known), 0.0))
    return np.outer(deviations, deviations) * correlation + known


def gain_relative_sd(problem: Problem) -> float:
    """Of the gain that scaled the force; 0 for a measured force, and where it is estimated."""
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.layout is not None and problem.layout.gain is not None
    return 0.0 if measured or estimated else problem.axis.axis.drive.relative_sd


def _own_rows(values: Array, weights: Array | None) -> Array:
    """Rows, (n,) or (n, k), as they were before each was weighted."""
    if weights is None:
        return values
    return values / (weights if values.ndim == 1 else weights[:, None])


def _known_spread(problem: Problem, fit: Fit) -> Array | None:
    """What wrong known values add to the regression's covariance, (k, k); None for exact ones.

    A value that is wrong by a deviation changes the force that the model needs, row by row, and the
    estimate by the influence of the rows.
    """
    layout = problem.layout
    if layout is None:
        return None
    values = dict(zip((q.name for q in layout.quantities), fit.solution.theta, strict=True))
    own = _unexplained(problem, layout, values)
    moved = [
        fit.solution.response.T @ (own - _unexplained(problem, other, values))
        for other in moved_layouts(problem.axis, layout)
    ]
    return np.transpose(moved) @ moved if moved else None


def _unexplained(problem: Problem, form: Form, values: Mapping[str, float]) -> Array:
    """What the model leaves of each row with parameters by name, (n,).

    What appears only beside a value, as at one of 0, has no estimate.
    """
    rows = problem.reduced(form, [data.signals for data in problem.data])
    theta = np.array([values.get(q.name, 0.0) for q in form.quantities])
    return np.asarray(rows.left - rows.intercept - rows.regressor @ theta, dtype=float)
