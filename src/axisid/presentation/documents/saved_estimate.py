"""One method's estimate as its file has it: what can be said without the rows it was made from."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from axisid.codegen.artefacts import Quantity
from axisid.estimation.estimates import CURVED, Iterate, Named, Value, student_interval
from axisid.estimation.regression import Drawn, ResidualTests
from axisid.modeling.text import FunctionLike, parameter_function
from axisid.presentation.schema import Matrix, WrittenEstimate, WrittenValue
from axisid.support.arrays import Array, frozen
from axisid.support.errors import EstimationError, UsageError
from axisid.support.shown import Shown

from .saved_diagnosis import read_residual_tests

_SAME = 1e-9  # relative


@dataclass(frozen=True, kw_only=True)
class SavedForm:
    """What a regression estimated, and what stood on its left."""

    quantities: tuple[Quantity, ...]
    left: str


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedEstimate(Shown):
    """An estimate that was read from a file, with the names of `Estimate`.

    Attributes
    ----------
    document : WrittenEstimate
        What the file holds of it.
    row_period : float
        Time from one row of the regression to the next, s.
    """

    document: WrittenEstimate
    row_period: float

    def __repr__(self) -> str:
        values = (
            f"{n} = {v.value:.6g} +- {v.deviation:.2g} {v.unit}" for n, v in self.parameters.items()
        )
        return f"{self.method}: {', '.join(values)}"

    def __getstate__(self) -> dict[str, Any]:
        """Without what is computed when it is asked for."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def method(self) -> str:
        """``idm-ls``, ``ddm-ls``, ``idm-iv`` or ``ddm-iv``."""
        return self.document.method

    @property
    def chosen(self) -> str:
        """Of `covariances`, what intervals, draws, curvatures and tests are of."""
        return self.document.chosen_covariance

    @cached_property
    def parameters(self) -> Named:
        """Physical parameters by name."""
        return named(self.document.parameters, self.chosen)

    @cached_property
    def ddm_parameters(self) -> Named:
        """Parameters of the direct model by name; empty for an inverse model."""
        return named(self.document.theta_ddm or {}, self.chosen)

    @property
    def is_direct(self) -> bool:
        """Whether a direct model was regressed."""
        return bool(self.ddm_parameters)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Physical parameters, length p; base parameters with what they are made of."""
        made = self.document.physical.base if self.document.physical else {}
        return tuple(
            Quantity(name=name, unit=v.unit, expression=made.get(name, ""))
            for name, v in self.parameters.items()
        )

    @property
    def ddm_quantities(self) -> tuple[Quantity, ...]:
        """Of the direct model, length m; empty for an inverse model."""
        written = self.document.theta_ddm or {}
        return tuple(
            Quantity(name=name, unit=v.unit, expression=v.expression) for name, v in written.items()
        )

    @property
    def form(self) -> SavedForm:
        """What the regression estimated."""
        if self.ddm_quantities:
            return SavedForm(quantities=self.ddm_quantities, left="acceleration")
        return SavedForm(quantities=self.quantities, left="force")

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""
        return frozen([v.value for v in self.parameters.values()])

    @property
    def filter_bias(self) -> Array | None:
        """What the prefilter alone moves the physical parameters by, (p,), where it is known."""
        biases = [v.filter_bias for v in self.parameters.values()]
        return None if None in biases else frozen([b for b in biases if b is not None])

    @property
    def corrected(self) -> Array:
        """Physical parameters less the filter's own bias, where that is known, (p,)."""
        return frozen([v.corrected for v in self.parameters.values()])

    @cached_property
    def covariances(self) -> Mapping[str, Array]:
        """Of `physical`, (p, p), by name: ``iid``, ``robust`` and ``hac``."""
        d = self.document
        return _arrays(iid=d.covariance, robust=d.covariance_robust, hac=d.covariance_hac)

    @property
    def covariance(self) -> Array:
        """Of the physical parameters for independent residuals; see `covariances` for others."""
        return self.covariances["iid"]

    @cached_property
    def ddm_covariances(self) -> Mapping[str, Array]:
        """Of the direct model's parameters, (m, m): ``iid`` and ``hac``."""
        d = self.document
        return _arrays(iid=d.theta_ddm_covariance, hac=d.theta_ddm_covariance_hac)

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the physical parameters, (p, p), of the chosen covariance."""
        return frozen(self.document.correlation)

    @property
    def covariance_names(self) -> Mapping[str, str]:
        """What each covariance is, with lags and corrections."""
        return self.document.covariance_names

    @property
    def dof(self) -> int:
        """Degrees of freedom of the residuals, n - k."""
        return self.document.rows - len(self.form.quantities)

    @property
    def equation_error_percent(self) -> float:
        """``100 ||y - X theta|| / ||y||``."""
        return self.document.equation_error_percent

    @property
    def simulation_error_percent(self) -> float | None:
        """``100 ||y - simulated|| / ||y||``; None where the loop could not be simulated."""
        return self.document.simulation_error_percent

    @property
    def condition_number(self) -> float:
        """Of the regressor as it was, not scaled."""
        return self.document.condition_number

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the user should know about this estimate."""
        return self.document.remarks

    @property
    def curvatures(self) -> Array:
        """Second-order part of each physical parameter's deviation against the first, (p,)."""
        values = self.document.curvatures.values()
        return frozen([math.inf if c is None else c for c in values])

    @property
    def iterates(self) -> tuple[Iterate, ...]:
        """The start and every iterate; empty for least squares."""
        d = self.document
        return tuple(
            Iterate(
                physical=frozen([*physical.values()]),
                theta=frozen([*theta.values()]),
                simulation_error_percent=error,
            )
            for physical, theta, error in zip(
                d.iterations,
                d.theta_ddm_iterations or d.iterations,
                d.iteration_simulation_errors_percent,
                strict=True,
            )
        )

    @cached_property
    def residual_tests(self) -> ResidualTests:
        """Tests of the residuals."""
        return read_residual_tests(self.document.residual_tests)

    def derive(self, function: FunctionLike) -> Value:
        """Any function of the physical parameters, with its unit and interval.

        As `Estimate.derive` has it, by the delta method under every covariance. What the drive
        gain's deviation adds is NaN where the file does not tell which way the parameters move
        with the gain.

        Parameters
        ----------
        function : str or SymPy expression
            Such as ``"M/Fv"``.

        Raises
        ------
        UsageError
            The function cannot be read, or its units do not fit.
        EstimationError
            It has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function bends within the uncertainty, so that the delta method is not enough.
        """
        read = parameter_function(function, {name: v.unit for name, v in self.parameters.items()})
        value, slopes, bends = read.at([float(x) for x in self.physical])
        gradient, hessian = np.array(slopes), np.array(bends)
        if not np.all(np.isfinite([value, *gradient, *hessian.ravel()])):
            raise EstimationError(
                f"{function} is not a finite real number with finite derivatives at the estimate; "
                f"its value is {value:g}."
            )
        if self._curvature(gradient, hessian) > CURVED:
            warnings.warn(
                f"{function} bends within the uncertainty, so that its deviation to first order is "
                "not enough; identify again and draw: propagate()",
                RuntimeWarning,
                stacklevel=2,
            )
        sds = {
            name: math.sqrt(max(float(gradient @ c @ gradient), 0.0))
            for name, c in self.covariances.items()
        }
        bias = None if self.filter_bias is None else float(gradient @ self.filter_bias)
        return Value(
            value=value,
            unit=str(read.unit),
            sd=sds["iid"],
            sd_robust=sds["robust"],
            sd_hac=sds["hac"],
            interval=student_interval(value - (bias or 0.0), sds[self.chosen], self.dof),
            sd_gain=abs(float(gradient @ self._moved_by_gain)),
            filter_bias=bias,
            chosen=self.chosen,
        )

    def propagate(self, function: str, *, draws: int) -> Drawn:
        """A parameter over draws, as the file has it.

        Parameters
        ----------
        function : str
            A parameter's name.
        draws : int
            As many as were drawn.

        Raises
        ------
        UsageError
            The file has no such draws.
        """
        drawn = (self.document.drawn or {}).get(function)
        if drawn is None or drawn.draws + drawn.lost != draws:
            raise UsageError(
                f"the file holds no {draws} draws of {function!r} by {self.method}; identify again "
                f"with --draws {draws}."
            )
        median, low, high = (
            math.nan if x is None else x for x in (drawn.median, *drawn.interval_95)
        )
        value = self.parameters[function]
        return Drawn(
            value=value.value,
            unit=value.unit,
            median=median,
            interval=(low, high),
            draws=drawn.draws,
            lost=drawn.lost,
            seed=drawn.seed,
        )

    def _curvature(self, gradient: Array, hessian: Array) -> float:
        """Second-order part of a function's deviation against the first.

        The map of a direct model bends too; of that the file has each parameter's own part.
        """
        covariance = self.covariances[self.chosen]
        first = math.sqrt(max(float(gradient @ covariance @ gradient), 0.0))
        bent = hessian @ covariance
        second = math.sqrt(max(float(np.trace(bent @ bent)), 0.0) / 2)
        own = second / first if first else math.inf if second else 0.0
        return float(max(own, 0.0, *self.curvatures[gradient != 0]))

    @property
    def gain_relative_sd(self) -> float:
        """Of the drive gain, where its deviation moves the parameters in proportion; else NaN."""
        moved = self._moved_by_gain
        return float(np.max(np.abs(moved / self.physical))) if np.any(moved) else 0.0

    @property
    def _moved_by_gain(self) -> Array:
        """What a deviation of the drive gain moves the physical parameters by, (p,).

        A gain scales the force, and with it every parameter that is in proportion to the force.
        """
        sizes = np.array([v.sd_gain for v in self.parameters.values()])
        if not np.any(sizes):
            return np.zeros(len(sizes))
        scale = float(np.max(sizes)) / float(np.abs(self.physical)[np.argmax(sizes)])
        moved = scale * self.physical
        in_proportion = np.allclose(np.abs(moved), sizes, rtol=_SAME, atol=0.0)
        return moved if in_proportion else np.full(len(sizes), math.nan)


def _arrays(**written: Matrix | None) -> dict[str, Array]:
    return {name: frozen(matrix) for name, matrix in written.items() if matrix is not None}


def named(written: Mapping[str, WrittenValue], chosen: str = "hac") -> Named:
    """Values by name, as an estimate has them; `chosen` is the covariance of their intervals."""
    return Named((name, _value(value, chosen)) for name, value in written.items())


def _value(written: WrittenValue, chosen: str) -> Value:
    return Value(
        value=written.value,
        unit=written.unit,
        sd=written.sd,
        sd_robust=written.sd_robust,
        sd_hac=written.sd_hac,
        interval=written.interval_95,
        sd_gain=written.sd_gain,
        filter_bias=written.filter_bias,
        chosen=chosen,
    )
