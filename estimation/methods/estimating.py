"""From a problem and a method to an estimate: fit, map, covariances and remarks.

Bias and deviations are by the parametric bootstrap of the problem's records, whose twins are the
same for all estimates.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from axisid.estimation.bootstrap import (
    BootstrapCorrection,
    Chain,
    Twins,
    bootstrap_correction,
    measured_chain,
)
from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.estimates import (
    COVARIANCES,
    Estimate,
    Inference,
    NotSimulated,
    covariance_of,
    fewest,
)
from axisid.estimation.estimation_problem import Problem, jacobian_by_gain, noise_free_residuals
from axisid.estimation.parameters import perturbed_layouts
from axisid.estimation.regression import (
    Covariance,
    CovarianceEstimate,
    DirectForm,
    Form,
    Hac,
    LoopDataError,
    condition_number,
    delta_method,
    recorded_loops,
)
from axisid.estimation.signals import FilteredRecord, Prefilter, advice_on_rests
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import NO_RELATION
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Deferred, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError

from .method import Fit, Method, loss_remarks
from .methods import METHODS

_BOUND_TOLERANCE = 1e-6  # relative distance of a nonlinear parameter from a bound that it is at

_PIVOT = "hac"  # whose deviations twins scale

_TOO_FEW = "more than half of the loops with its noise cannot be simulated, or estimated from"
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
                fit = _with_loops(self.problem, METHODS[method].fitted(self.problem))
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
                    measured_chain(data, form.own(at, i), of_one)
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
                return _TOO_FEW
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


def _with_loops(problem: Problem, fit: Fit) -> Fit:
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
    fit = method.fitted(problem)
    form, solution, solver, y = fit.form, fit.solution, fit.solver, fit.measured.left
    weights = problem.row_weights
    physical, jacobian = form.physical(solution.theta)
    models = {name: covariance_of(name, lags) for name in reversed(COVARIANCES)}
    known = _known_spread(problem, fit)
    applied = _applied(method, fit, models, known, jacobian)
    direct = isinstance(form, DirectForm)
    residuals, left = _own_rows(solution.residuals, weights), _own_rows(y, weights)
    simulated, error = fit.simulated, None
    if not isinstance(simulated, NotSimulated):
        simulated = _own_rows(simulated, weights)
        error = relative_error_percent(left - simulated, left)
    has_times = len(problem.data) > 1 or problem.data[0].record.segments
    inference = partial(_inference, problem, fit, applied, models[_PIVOT], known, bootstrap)
    return Estimate(
        method=method.name,
        form=form.at(physical),
        quantities=form.physical_quantities,
        theta=solution.theta,
        physical=physical,
        jacobian=jacobian,
        ddm_quantities=form.quantities if direct else (),
        y=left,
        X=_own_rows((solver.slopes or fit.measured).regressor, weights),
        Z=None if solver.loop is None else _own_rows(solver.loop.columns, weights),
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
        deferred=Deferred(inference),
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
    y, solution = fit.measured.left, fit.solution
    found: dict[str, CovarianceEstimate] = {}
    if float(y @ y) > 0 and np.all(np.isfinite(solution.residuals)):
        found = {name: covariance.applied(solution) for name, covariance in models.items()}
    mapped = [delta_method(each.matrix, jacobian) for each in found.values()]
    if not mapped or not np.all(np.isfinite(mapped)):
        raise EstimationError(
            f"{method.name}: the regression is not finite, or the {fit.form.left} is zero in every "
            "row; check the signals' size and the known terms of the equation of motion.",
            code="not-finite",
        )
    if known is None:
        return found
    return {name: replace(each, matrix=each.matrix + known) for name, each in found.items()}


def _remarks(problem: Problem, fit: Fit, loss: str) -> Iterator[str]:
    """What the user should know of an estimate."""
    every = (data.sampling.filter.remarks() for data in problem.data)
    yield from dict.fromkeys(remark for of_one in every for remark in of_one)
    if math.inf > fit.simulation_error_percent > NO_RELATION.value:
        cause = advice_on_rests(problem.rest) or (
            "check the control law, the reference and the signs and units of the columns"
        )
        yield f"the simulated loop does not follow the record; {cause}"
    yield from loss_remarks(loss, fit.solution)
    yield from fit.remarks
    form = fit.form
    values = [*zip(form.declared, fit.physical, strict=True)]
    searched = () if form.is_linear else form.axis.nonlinear
    for (p, value), is_searched in zip(values, searched, strict=False):
        reach = min(abs(value - p.lower), abs(value - p.upper))
        if is_searched and reach <= _BOUND_TOLERANCE * abs(value):
            yield f"{p.name} = {value:.6g} {p.unit} is at its bound: the search would go further"
    yield from (p.out_of_bounds(value) for p, value in values if not p.allows(value))


def _inference(
    problem: Problem,
    fit: Fit,
    applied: Mapping[str, CovarianceEstimate],
    pivot: Covariance,
    known: Array | None,
    bootstrap: Bootstrap | None,
) -> Inference:
    """What filter, noise and gain do to an estimate, and its covariances with that.

    Parameters
    ----------
    problem : Problem
    fit : Fit
    applied : dict of str to CovarianceEstimate
        The covariances of the regression's own parameters.
    pivot : Covariance
        That twins scale.
    known : (k, k) array or None
        What values that are known with a deviation add to each covariance.
    bootstrap : Bootstrap or None
        Whose twins tell what filter and noise do, where they can be drawn.
    """
    solution, form = fit.solution, fit.form.at(fit.physical)
    jacobian = form.physical(solution.theta)[1]
    quiet, by_gain, theta_by_gain = None, None, None
    # What is not finite is told by what is missing; NumPy's own warnings would only repeat it.
    with np.errstate(all="ignore"):
        with suppress(ModelError, DataError, EstimationError):
            looped = _with_loops(problem, fit)
            if looped.follows:
                quiet = noise_free_residuals(form, problem, looped.loops, fit.solver)
        if gain_relative_sd(problem):
            with suppress(DataError, EstimationError):
                by_gain, theta_by_gain = jacobian_by_gain(form, problem, solution, fit.solver)
        told = _by_twins(fit, form, pivot, bootstrap)
        own = {name: each.matrix for name, each in applied.items()}
        mapped = {name: delta_method(each, jacobian) for name, each in own.items()}
        freedom = {name: each.freedom for name, each in applied.items()}
        names = {name: each.description for name, each in applied.items()}
        chains: tuple[Chain, ...] = ()
        bias = left = off = None
        if isinstance(told, str):
            names[_PIVOT] += told
        else:
            known = np.zeros_like(own[_PIVOT]) if known is None else known
            by_known = delta_method(known, jacobian)
            own[_PIVOT] = _scaled(own[_PIVOT], known, *told.theta_scaled)
            mapped[_PIVOT] = _scaled(mapped[_PIVOT], by_known, *told.scaled)
            names[_PIVOT] += _noise(problem.axis.axis, told)
            left = _own_rows(told.residuals, problem.row_weights)
            if told.count > 1:  # of the scale: as many pairs of opposite twins are a sample
                freedom[_PIVOT] = np.full(len(solution.theta), float(told.count // 2))
            chains, bias, off = told.twins.chains, told.bias, told.theta_error
            quiet = None if quiet is None else left.mean(axis=1)
        direct = isinstance(form, DirectForm)
        return Inference(
            covariances=mapped,
            covariance_names=names,
            ddm_covariances=own if direct else {},
            freedom={name: fewest(each, jacobian) for name, each in freedom.items()},
            ddm_freedom=freedom if direct else {},
            gain_slopes=by_gain,
            theta_gain_slopes=theta_by_gain,
            noise_free=quiet,
            bias=bias,
            twins_residuals=None if left is None or left.shape[1] < 2 else left,
            twin_errors=off,
            chains=chains,
        )


def _by_twins(
    fit: Fit, form: Form, pivot: Covariance, bootstrap: Bootstrap | None
) -> BootstrapCorrection | str:
    """What twins tell; or, as a part of a note, that none do."""
    if bootstrap is None:
        return ""
    twins = bootstrap.twins
    if isinstance(twins, str):
        return f", by no twins: {twins.rstrip('.')}"
    with suppress(EstimationError):  # the solution of a twin may have no covariance
        correction = bootstrap_correction(twins, form, fit.solver, fit.solution, pivot)
        if correction is not None:
            return correction
    return f", by no twins: {_TOO_FEW}"


def _noise(axis: Axis, correction: BootstrapCorrection) -> str:
    """The noise of twins, as a part of a note."""
    chains = correction.twins.chains
    if all(each.is_silent for each in chains):
        return ", of a loop that shows no noise"
    noise = [each.told(axis.coordinate.unit, axis.drive.unit) for each in chains]
    if len(noise) > 1:
        noise = [f"record {number}: {each}" for number, each in enumerate(noise, 1)]
    return f", as {correction.count} twins with {'; '.join(noise)} scatter"


def _scaled(covariance: Array, known: Array, scale: Array, correlation: Array) -> Array:
    """A covariance as twins scatter, but for what known values add: they are no noise."""
    deviations = scale * np.sqrt(np.maximum(np.diag(covariance - known), 0.0))
    return np.outer(deviations, deviations) * correlation + known


def gain_relative_sd(problem: Problem) -> float:
    """Of the gain that scaled the force; 0 for a measured force, and where it is estimated."""
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.layout is not None and problem.layout.gain is not None
    return 0.0 if measured or estimated else problem.axis.axis.drive.relative_sd


def _own_rows(values: Array, weights: Array) -> Array:
    """Rows, (n,) or (n, k), as they were before each was weighted."""
    if np.all(weights == 1):
        return values  # not a copy of all rows
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
    unexplained = _unexplained(problem, layout, values)
    changes = [
        fit.solution.response.T @ (unexplained - _unexplained(problem, other, values))
        for other in perturbed_layouts(problem.axis, layout)
    ]
    return np.transpose(changes) @ changes if changes else None


def _unexplained(problem: Problem, form: Form, values: Mapping[str, float]) -> Array:
    """What the model leaves of each row with parameters by name, (n,).

    What appears only beside a value, as at one of 0, has no estimate.
    """
    rows = problem.reduced(form, [data.signals for data in problem.data])
    return rows.residuals(np.array([values.get(q.name, 0.0) for q in form.quantities]))
