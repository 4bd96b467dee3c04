"""From a fit to how far it may be from the truth: what further simulated loops tell of it."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.estimates import Inference
from axisid.estimation.problems import NoiseFree, Problem, noise_free, slopes_by_gain
from axisid.estimation.regression import Applied, Covariance, DirectForm, Form, delta_method
from axisid.estimation.twins import Calibration, Chain, Twins, calibrated
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError

from .bootstrap import TOO_FEW, Bootstrap, loops_of
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
    applied: Mapping[str, Applied]
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
            names = {n: f"{each.description}{self._widened(n)}" for n, each in self.applied.items()}
            if isinstance(found, str):
                names[_PIVOT] += found
                chains: tuple[Chain, ...] = ()
                bias = None
            else:
                twins, told = found
                known = np.zeros_like(own[_PIVOT]) if self.known is None else self.known
                by_known = delta_method(known, self.jacobian)
                own[_PIVOT] = _scaled(own[_PIVOT], known, told.own_scale)
                mapped[_PIVOT] = _scaled(mapped[_PIVOT], by_known, told.scale)
                names[_PIVOT] += self._noise(twins, told.count)
                chains, bias = twins.chains, told.bias
                if quiet is not None:
                    residuals = own_rows(told.residuals, self.problem.row_weights)
                    quiet = replace(quiet, residuals=residuals)
            by_gain, theta_by_gain = self._slopes()
            return Inference(
                covariances=mapped,
                covariance_names=names,
                ddm_covariances=own if isinstance(self.form, DirectForm) else {},
                gain_slopes=by_gain,
                theta_gain_slopes=theta_by_gain,
                noise_free=quiet,
                bias=bias,
                chains=chains,
            )

    def _calibrated(self) -> tuple[Twins, Calibration] | str:
        """What twins tell; or, as a part of a note, that none do."""
        if self.bootstrap is None:
            return ""
        twins = self.bootstrap.twins
        if isinstance(twins, str):
            return f", by no twins: {twins.rstrip('.')}"
        fit, freedom = self.fit, self.applied[_PIVOT].freedom
        with suppress(EstimationError):  # the solution of a twin may have no covariance
            found = calibrated(twins, self.form, fit.solver, fit.solution, self.pivot, freedom)
            if found is not None:
                return twins, found
        return f", by no twins: {TOO_FEW}"

    def _noise(self, twins: Twins, count: int) -> str:
        if all(each.is_silent for each in twins.chains):
            return ", of a loop that shows no noise"
        noise = [each.told(self.problem.axis.axis) for each in twins.chains]
        if len(noise) > 1:
            noise = [f"record {number}: {told}" for number, told in enumerate(noise, 1)]
        return f", as {count} twins with {'; '.join(noise)} scatter"

    def _noise_free(self) -> NoiseFree | None:
        """The estimate's own loop behind the filter; None where it does not follow."""
        with suppress(ModelError, DataError, EstimationError):
            loops = loops_of(self.problem, self.fit)
            return noise_free(self.form, self.problem, loops, self.fit.solver)
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


def _scaled(covariance: Array, known: Array, scale: Array) -> Array:
    """A covariance as twins scatter, but for what known values add: they are no noise."""
    return np.outer(scale, scale) * (covariance - known) + known


def gain_relative_sd(problem: Problem) -> float:
    """Of the gain that scaled the force; 0 for a measured force, and where it is estimated."""
    measured = all(data.record.force is not None for data in problem.data)
    estimated = problem.layout is not None and problem.layout.gain is not None
    return 0.0 if measured or estimated else problem.axis.axis.drive.relative_sd


def own_rows(values: Array, weights: Array | None) -> Array:
    """Rows, (n,) or (n, k), as they were before each was weighted."""
    if weights is None:
        return values
    return values / (weights if values.ndim == 1 else weights[:, None])
