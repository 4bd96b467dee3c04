"""From a fit to how far it may be from the truth: what further simulated loops tell of it."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.estimation.estimates import COVARIANCES, Inference
from axisid.estimation.problems import (
    ByInstruments,
    ByOutputError,
    ControlSteps,
    NoiseFree,
    Problem,
    Solver,
    confirmed,
    control_error,
    encoder_error,
    is_not_in,
    noise_free,
    noise_free_at,
    noise_free_following,
    settled_noise_free,
    slopes_by_gain,
    with_loop_noise,
)
from axisid.estimation.regression import (
    Applied,
    Covariance,
    DirectForm,
    Form,
    SensorSteps,
    StepsError,
    delta_method,
    sensor_steps,
)
from axisid.estimation.twins import Twins, calibrated
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError

from .bootstrap import TOO_FEW, Bootstrap
from .method import Fit

_PIVOT = "hac"  # whose deviations twins scale


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedPoint:
    """A fit at its point, with what its solution alone tells of its error.

    Attributes
    ----------
    problem : Problem
    fit : Fit
    form : Form
        At `physical`.
    physical : (p,) array
    jacobian : (p, k) array
        Of these by the regression's own parameters.
    applied : dict of str to Applied
        The covariances of the regression's own parameters.
    model : Covariance
        The chosen one.
    chosen : str
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
    physical: Array
    jacobian: Array
    applied: Mapping[str, Applied]
    model: Covariance
    chosen: str
    pivot: Covariance
    known: Array | None = None
    bootstrap: Bootstrap | None = None

    def inference(self) -> Inference:
        """What filter, encoder and gain do to the estimate, and its covariances with that."""
        # What is not finite is told by what is missing; NumPy's own warnings would only repeat it.
        with np.errstate(all="ignore"):
            first = self._noise_free()
            if first is not None and (by_twins := self._by_twins(first)) is not None:
                return by_twins
            stepped, rounded = self._encoder_error(first), self._control_error()
            errors = [error.covariance for error in (stepped, rounded) if error is not None]
            alone = delta_method(self._with(self.chosen, errors), self.jacobian)
            quiet = self._settled(first, np.sqrt(np.maximum(np.diag(alone), 0.0)))
            errors += [] if quiet is None or quiet.hidden is None else [quiet.hidden]
            covariances = {name: self._with(name, errors) for name in self.applied}
            mapped = {n: delta_method(c, self.jacobian) for n, c in covariances.items()}
            by_gain, theta_by_gain = self._slopes()
            return Inference(
                covariances=mapped,
                covariance_names={n: self._name(n, stepped, rounded, quiet) for n in self.applied},
                ddm_covariances=covariances if isinstance(self.form, DirectForm) else {},
                gain_slopes=by_gain,
                theta_gain_slopes=theta_by_gain,
                noise_free=quiet,
            )

    def _by_twins(self, first: NoiseFree) -> Inference | None:
        """The same by twins; None where there are none, or too few can be solved."""
        twins = self.bootstrap.twins if self.bootstrap else ""
        found = None
        if isinstance(twins, Twins):
            fit, freedom = self.fit, self.applied[_PIVOT].freedom
            with suppress(EstimationError):  # the solution of a twin may have no covariance
                found = calibrated(twins, self.form, fit.solver, fit.solution, self.pivot, freedom)
        if found is None or isinstance(twins, str):
            return None
        own = {name: each.matrix for name, each in self.applied.items()}
        mapped = {name: delta_method(each, self.jacobian) for name, each in own.items()}
        # What known values add is no noise of the record.
        known = np.zeros_like(own[_PIVOT]) if self.known is None else self.known
        by_known = delta_method(known, self.jacobian)
        own[_PIVOT] = np.outer(found.own_scale, found.own_scale) * (own[_PIVOT] - known) + known
        scales = np.outer(found.scale, found.scale)
        mapped[_PIVOT] = scales * (mapped[_PIVOT] - by_known) + by_known
        names = {
            name: f"{each.description}{self._widened(name)}" for name, each in self.applied.items()
        }
        noise = [each.told(self.problem.axis.axis) for each in twins.chains]
        if len(noise) > 1:
            noise = [f"record {number}: {told}" for number, told in enumerate(noise, 1)]
        names[_PIVOT] += f", as {found.count} twins with {'; '.join(noise)} scatter"
        by_gain, theta_by_gain = self._slopes()
        return Inference(
            covariances=mapped,
            covariance_names=names,
            ddm_covariances=own if isinstance(self.form, DirectForm) else {},
            gain_slopes=by_gain,
            theta_gain_slopes=theta_by_gain,
            noise_free=replace(first, bias=found.bias, settled=True, has_noise=True),
            chains=twins.chains,
        )

    def _noise_free(self) -> NoiseFree | None:
        """What the filter makes of the estimate's own loop; None where it does not follow."""
        fit = self.fit
        if fit.follows:
            with suppress(DataError, EstimationError):  # a simulated record may not be solved
                return noise_free(self.form, self.problem, fit.loops, self.physical, fit.solver)
        return None

    def _settled(self, first: NoiseFree | None, deviations: Array) -> NoiseFree | None:
        """The same where it leads, or by a loop that follows the record; None if there is none."""
        if not self.fit.follows:
            return self._following(deviations)
        if first is None:
            return None
        with suppress(DataError, EstimationError):  # nor those of another loop
            solver, solution = self.fit.solver, self.fit.solution
            if isinstance(solver, ByOutputError):
                return self._shaken(first, solver, deviations)
            found_at = partial(noise_free_at, self.form, self.problem, solver=solver)
            quiet = settled_noise_free(first, found_at, self.physical, deviations)
            if quiet is first:
                return quiet
            plain = replace(solution, residuals=own(solution.residuals, self.problem.row_weights))
            if isinstance(solver, ByInstruments) and is_not_in(quiet, plain, self.model):
                noisy = confirmed(self._shaken(first, solver, deviations), plain, self.model)
                if noisy.has_noise and not noisy.doubt:  # nor has the record the quiet loop's own
                    return replace(noisy, residuals=np.zeros_like(noisy.residuals))
            return confirmed(quiet, plain, self.model)
        return None

    def _shaken(self, first: NoiseFree, solver: Solver, deviations: Array) -> NoiseFree:
        """The same of loops with the records' noise, where that is a matter."""
        form, problem = self.form, self.problem

        def found_at(physical: Array) -> NoiseFree | None:
            quiet = noise_free_at(form, problem, physical, solver=solver)
            return quiet and with_loop_noise(quiet, form.at(physical), problem, physical, solver)

        own = (self.physical, solver, deviations, self.fit.loops)
        here = with_loop_noise(first, form, problem, *own)
        return settled_noise_free(here, found_at, self.physical, deviations)

    def _following(self, deviations: Array) -> NoiseFree | None:
        """The same of loops that follow records without a reference; None if there are none."""
        problem = self.problem
        alone = len(problem.data) == 1 and problem.layout is None
        if alone and problem.data[0].record.reference is None:
            with suppress(ModelError, DataError, EstimationError):
                left = self.fit.measured.left
                found_at = partial(noise_free_following, self.form, problem, left)
                first = found_at(self.physical)
                return first and settled_noise_free(first, found_at, self.physical, deviations)
        return None

    def _slopes(self) -> tuple[Array | None, Array | None]:
        """What the gain moves the estimate by, and the regression's parameters."""
        if gain_relative_sd(self.problem):
            with suppress(DataError, EstimationError):  # nor those of another gain
                fit = self.fit
                return slopes_by_gain(self.form, self.problem, fit.solution, fit.solver)
        return None, None

    def _encoder_error(self, quiet: NoiseFree | None) -> StepsError | None:
        """What the encoder's steps do, against the HAC covariance of the fit."""
        if quiet is None:
            return None
        deviations = np.sqrt(np.diag(self.applied["hac"].matrix))
        with suppress(DataError, EstimationError):  # nor rows of a loop with such an encoder
            return encoder_error(
                self.form, self.problem, quiet, self.physical, self.fit.solver, deviations
            )
        return None

    def _control_error(self) -> StepsError | None:
        """What the steps of a recorded control do, against the same."""
        deviations = np.sqrt(np.diag(self.applied["hac"].matrix))
        with suppress(ModelError, DataError, EstimationError):  # nor where there is no loop
            return control_error(
                self.form, self.problem, self.physical, self.fit.solver, deviations
            )
        return None

    def _with(self, name: str, added: Sequence[Array]) -> Array:
        """A covariance with what loops have, where it allows autocorrelation."""
        matrix = self.applied[name].matrix
        if not COVARIANCES[name].allows_autocorrelation:
            return matrix
        return np.asarray(sum(added, start=matrix), dtype=float)

    def _name(
        self,
        name: str,
        stepped: StepsError | None,
        rounded: StepsError | None,
        quiet: NoiseFree | None,
    ) -> str:
        """A covariance with what it holds besides, for notes."""
        said = f"{self.applied[name].description}{self._widened(name)}"
        if not COVARIANCES[name].allows_autocorrelation:
            return said
        if self.bootstrap is not None:
            twins = self.bootstrap.twins
            lost = TOO_FEW if self.fit.follows else "the method's loop does not follow the record"
            said += f", by no twins: {twins if isinstance(twins, str) else lost}"
        if quiet is not None and quiet.hidden is not None:
            said += ", with what simulated loops scatter by with the position's noise"
        axis, records = self.problem.axis, [data.record for data in self.problem.data]
        if stepped is not None:
            every = [sensor_steps(axis, record) for record in records]
            steps = SensorSteps(
                position=max(each.position for each in every),
                velocity=max(each.velocity for each in every),
            )
            unit = axis.axis.coordinate.unit
            said += f", with what {stepped.loops} simulated loops have by {steps.told(unit)}"
        if rounded is not None:
            told = max((ControlSteps.of(record) for record in records), key=lambda s: s.size)
            said += f", with what {told.told(axis.axis)} do, begun at {rounded.loops} places"
        return said

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


def gain_relative_sd(problem: Problem) -> float:
    """Of the gain that scaled the force; 0 for a measured force, and where it is estimated."""
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.layout is not None and problem.layout.gain is not None
    return 0.0 if measured or estimated else problem.axis.axis.drive.relative_sd


def own(values: Array, weights: Array | None) -> Array:
    """Rows, (n,) or (n, k), as they were before each was weighted."""
    if weights is None:
        return values
    return values / (weights if values.ndim == 1 else weights[:, None])
