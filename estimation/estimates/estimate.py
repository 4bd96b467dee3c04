"""Results of an estimator."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

import numpy as np

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.choices import ROW_LOSSES, is_output_error
from axisid.estimation.noise_models import Chain
from axisid.estimation.regression import (
    Covariance,
    CovarianceNote,
    DrawSummary,
    Form,
    LossWeights,
    ResidualTests,
    correlation,
    curvature,
    delta_method,
    draw_parameters,
    residual_tests,
    scaled_gradients_and_hessians,
    summary_of_draws,
)
from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import LIGHT_ROW
from axisid.modeling.parsing import FunctionLike, parameter_function
from axisid.support.arrays import Array, Deferred, Exact
from axisid.support.checks import is_among, is_whole, refuse
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable, view_of
from axisid.support.wording import quoted

from .estimated_values import NamedValues, SamplingDistribution, Value


@dataclass(frozen=True, slots=True)
class NotSimulated(Missing):
    """Reason why no loop was simulated with an estimate.

    Attributes
    ----------
    by_estimate : bool
        True if the estimate is the reason: there are a law and a reference, but the loop with this
        estimate is too stiff, has no inertia, or diverges. False if law or reference are missing.
    """

    by_estimate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Iterate(Exact):
    """One iterate of the instrumental-variable estimate.

    Attributes
    ----------
    physical : (p,) array
        Physical parameters.
    theta : (k,) array
        Parameters of the regression, which the physical parameters are calculated from.
    simulation_error_percent : float
        Simulation error of the loop with this iterate, percent of the measured left side (rms).
    """

    physical: Array
    theta: Array
    simulation_error_percent: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inference(Exact):
    """Inference that needs further simulated loops, and is therefore computed on request.

    Attributes
    ----------
    covariances : dict of str to (p, p) array
        Covariances of the physical parameters, by name: ``iid``, ``robust`` and ``hac``; by the
        delta method for a direct model. ``hac`` is scaled by simulated replicas where there are
        any.
    covariance_notes : dict of str to CovarianceNote
        Notes on each covariance: kind, lags, corrections and replicas.
    ddm_covariances : dict of str to (m, m) array
        Covariances of a direct model's own parameters; empty for an inverse model.
    freedom, ddm_freedom : dict of str to array
        Degrees of freedom of the variances in the covariances, (p,) and (m,).
    gain_slopes : (p,) array or None
        Derivatives of the physical parameters by the logarithm of the drive gain; None for an exact
        gain.
    theta_gain_slopes : (k,) array or None
        Derivatives of the regression's own parameters by the logarithm of the drive gain; None for
        an exact gain.
    noise_free : (n,) array or None
        Residuals of the same estimator and filter for loops simulated with the estimate, or the
        mean residuals of replicas: errors of the filter, without their effect on the estimate. The
        loops follow the references of the records, or the records themselves without references.
        None where they could not be simulated, or do not follow the records.
    bias : (p,) array or None
        Bias of the physical parameters by filter and noise, by simulated replicas; None without
        replicas.
    chains : tuple of Chain
        Noise of each record in its replicas; empty without replicas.
    twins_residuals : (n, R) array or None
        Residuals of the estimator in each replica; None without replicas with noise.
    twin_errors : (R, k) array or None
        Errors of the regression's own parameters in each replica; None without replicas.
    """

    covariances: Mapping[str, Array]
    covariance_notes: Mapping[str, CovarianceNote]
    ddm_covariances: Mapping[str, Array]
    freedom: Mapping[str, Array]
    ddm_freedom: Mapping[str, Array]
    gain_slopes: Array | None = None
    theta_gain_slopes: Array | None = None
    noise_free: Array | None = None
    bias: Array | None = None
    chains: tuple[Chain, ...] = ()
    twins_residuals: Array | None = None
    twin_errors: Array | None = None


class _HasDistribution(Protocol):
    """Members that the properties of `EstimateFacts` need from the class that inherits them."""

    @property
    def method(self) -> str: ...
    @property
    def parameters(self) -> NamedValues: ...
    @property
    def distribution(self) -> SamplingDistribution: ...


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class EstimateFacts:
    """Members of an estimate that do not need its rows; also those of an estimate from a file.

    The fields are described in `Estimate`.
    """

    method: str
    quantities: tuple[Quantity, ...]
    physical: Array
    ddm_quantities: tuple[Quantity, ...]
    row_period: float
    equation_error_percent: float
    simulation_error_percent: float | None
    condition_number: float
    iterates: tuple[Iterate, ...]
    remarks: tuple[str, ...]
    started: str = ""
    chosen: str = "hac"
    gain_relative_sd: float = 0.0

    def __repr__(self: _HasDistribution) -> str:
        """Return the method, and every parameter with its standard error, on one line."""
        return f"{self.method}: {self.parameters.listed()}"

    def __getitem__(self: _HasDistribution, name: str) -> Value:
        """Return the physical parameter of that name, with unit, standard errors and interval."""
        return self.parameters[name]

    @property
    def is_direct(self) -> bool:
        """True if a direct model was regressed."""
        return bool(self.ddm_quantities)

    @property
    def by_output_error(self) -> bool:
        """True for an output-error method (DIDIM), whose regressor is simulated without noise."""
        return is_output_error(self.method)

    @property
    def filter_bias(self: _HasDistribution) -> Array | None:
        """Bias of the physical parameters by filter and noise, (p,).

        It is found with simulated replicas of the record; None without replicas.
        """
        return self.distribution.bias

    @property
    def corrected(self: _HasDistribution) -> Array:
        """Physical parameters minus `filter_bias`, (p,); not corrected where the bias is None."""
        return self.distribution.corrected

    @property
    def covariance(self: _HasDistribution) -> Array:
        """Covariance of the physical parameters, (p, p), by the estimator named in `chosen`.

        The printed standard errors and intervals are from this covariance.
        """
        return self.distribution.covariances[self.distribution.chosen]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Estimate(EstimateFacts, Presentable, Exact):
    """Estimate of the physical parameters, and of a direct model's own parameters.

    Attributes
    ----------
    method : str
        ``idm-ls``, ``ddm-ls``, ``idm-iv``, ``ddm-iv`` or ``didim``.
    form : Form
        Form of the regression, with the map from its parameters to the physical ones.
    quantities : tuple of Quantity
        Physical parameters, length p.
    theta : (k,) array
        Regression's own parameters.
    physical : (p,) array
        Physical parameters.
    jacobian : (p, k) array
        Derivatives of the physical parameters by the regression's own.
    ddm_quantities : tuple of Quantity
        Length m; empty for an inverse model.
    y : (n,) array
        Left side of the regression: force (IDM) or acceleration (DDM).
    X : (n, k) array
        Regressor: of the measured motion, or the derivatives of the simulated left side by each
        parameter, see `by_output_error`.
    Z : (n, k) array or None
        Instruments: columns of the simulated loop; None for least squares.
    rows : (n,) array
        Sample number of each row.
    neighbours : RowTimes
        Order of the rows in time, with their gaps.
    period : float
        Sample period, s.
    row_period : float
        Time between successive rows, s.
    times : (n,) array or None
        Time of each row since the record's first sample, s, for a record with gaps; None where it
        is ``rows * period``.
    residuals : (n,) array
        ``y - X theta`` minus the known terms of the model, if any; for output error, ``y`` minus
        the simulated left side.
    simulated : (n,) array or NotSimulated
        Left side of the simulated loop, or the reason why no loop was simulated.
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||``. Not a quality of an instrumental-variable estimate.
    simulation_error_percent : float or None
        ``100 ||y - simulated|| / ||y||``; None where no loop was simulated.
    condition_number : float
        Condition number of X without scaling.
    iterates : tuple of Iterate
        The start and every iterate; empty for least squares.
    started : str
        Start of the iteration, ``least-squares`` or ``nominal``; empty for least squares.
    remarks : tuple of str
        Remarks on this estimate for the user.
    chosen : str
        Name of the covariance that intervals, draws, curvatures and tests use.
    covariance_model : Covariance
        Assumptions of this covariance on the residuals, with its lags if it has any.
    gain_relative_sd : float
        Relative standard deviation of the drive gain that scaled the force: 0 if the force was
        measured or the gain is exact.
    loss : str
        Loss of the rows, of `ROW_LOSSES`.
    counts : LossWeights or None
        Weight of each row by the loss, 1 for a small residual; None if all weights are equal.
    weights : (n,) array
        Weights of the rows in the fit by the noise of their records, 1 for a single record; rows
        and residuals are given without them.
    deferred : Deferred of Inference
        Covariances, the bias by filter and noise, and the uncertainty by the gain; see `inference`.
    """

    form: Form
    theta: Array
    jacobian: Array
    y: Array
    X: Array
    Z: Array | None
    rows: Array
    neighbours: RowTimes
    period: float
    residuals: Array
    simulated: Array | NotSimulated
    covariance_model: Covariance
    deferred: Deferred[Inference]
    weights: Array
    times: Array | None = None
    loss: str = ROW_LOSSES[0]
    counts: LossWeights | None = None

    @property
    def inference(self) -> Inference:
        """Bias, covariances and gain slopes of the estimate, computed on first request."""
        return self.deferred.value

    def with_inference(self, **changed: Any) -> "Estimate":
        """Return the estimate with some members of its `inference` replaced.

        The keywords are names of members of `Inference`, with their new values.
        """
        return replace(self, deferred=Deferred.of(replace(self.inference, **changed)))

    @property
    def covariances(self) -> Mapping[str, Array]:
        """Covariances of the physical parameters, (p, p) each, by name; see `Inference`."""
        return self.inference.covariances

    @property
    def covariance_notes(self) -> Mapping[str, CovarianceNote]:
        """Notes on each covariance: kind, lags, corrections and replicas."""
        return self.inference.covariance_notes

    @property
    def covariance_names(self) -> Mapping[str, str]:
        """Notes on each covariance as text, by name of the covariance."""
        return {name: view_of("covariance_name", n) for name, n in self.covariance_notes.items()}

    @property
    def ddm_covariances(self) -> Mapping[str, Array]:
        """Covariances of the direct model's parameters, (m, m) each, by name.

        Empty for an inverse model.
        """
        return self.inference.ddm_covariances

    @property
    def freedom(self) -> Mapping[str, Array]:
        """Degrees of freedom of the variances in `covariances`, (p,) each, by the same names."""
        return self.inference.freedom

    @property
    def net_residuals(self) -> Array:
        """Residuals minus the errors of the filter, (n,), in the unit of the left side.

        The errors of the filter are `Inference.noise_free`; where they are None, the residuals are
        returned unchanged.
        """
        filter_errors = self.inference.noise_free
        return self.residuals if filter_errors is None else self.residuals - filter_errors

    @property
    def score_columns(self) -> Array:
        """Columns to which the residuals are orthogonal in the solution, (n, k).

        They are the instruments, or the regressor for least squares. Each row is multiplied by its
        weight under the loss.
        """
        columns = self.X if self.Z is None else self.Z
        return columns if self.counts is None else self.counts.weights[:, None] * columns

    @property
    def slope_columns(self) -> Array:
        """Columns that give the sensitivity of the scores to the parameters, (n, k).

        They are the instruments, or the regressor for least squares. Each row is multiplied by the
        derivative ``psi'`` of its loss function.
        """
        columns = self.X if self.Z is None else self.Z
        return columns if self.counts is None else self.counts.slopes[:, None] * columns

    @property
    def light_rows(self) -> Array:
        """True for each row, (n,), with a weight of less than one half under the loss."""
        if self.counts is None:
            return np.zeros(len(self.y), dtype=bool)
        return np.asarray(self.counts.weights < LIGHT_ROW.value)

    @property
    def theta_ddm(self) -> Array:
        """Regression parameters of the direct model, (m,); empty for an inverse model."""
        return self.theta[: len(self.ddm_quantities)]

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the physical parameters, (p, p), of the chosen covariance."""
        return correlation(self.covariance)

    @property
    def distribution(self) -> SamplingDistribution:
        """Sampling distribution of the physical parameters, with bias and effect of the gain."""
        by_gain = self.inference.gain_slopes
        return SamplingDistribution(
            quantities=self.quantities,
            theta=self.physical,
            covariances=self.covariances,
            freedom=self.freedom,
            chosen=self.chosen,
            bias=self.inference.bias,
            by_gain=None if by_gain is None else self.gain_relative_sd * by_gain,
        )

    @property
    def parameters(self) -> NamedValues:
        """Physical parameters by name, with units, standard errors and intervals."""
        return self.distribution.values

    @property
    def ddm_parameters(self) -> NamedValues:
        """Parameters of the direct model by name, with units, standard errors and intervals.

        Empty for an inverse model.
        """
        bias, by_gain = None, self.inference.theta_gain_slopes
        # The bias is that of the physical parameters, mapped to those of the direct model.
        if self.ddm_quantities and self.filter_bias is not None:
            bias = self.theta_ddm - self.form.regressed(self.corrected)
        return SamplingDistribution(
            quantities=self.ddm_quantities,
            theta=self.theta_ddm,
            covariances=self.ddm_covariances,
            freedom=self.inference.ddm_freedom,
            chosen=self.chosen,
            bias=bias,
            by_gain=None if by_gain is None else self.gain_relative_sd * by_gain,
        ).values

    def derive(self, function: FunctionLike) -> Value:
        """Return a function of the physical parameters, with its unit and interval.

        Parameters
        ----------
        function : str or SymPy expression
            Such as ``"M/Fv"``, a time constant in s. Text may use ``+ - * / **``, pi and the
            functions of an axis in TOML, such as sqrt, exp and log.

        Returns
        -------
        Value
            Value of the function, with standard errors by the delta method for every covariance.

        Raises
        ------
        UsageError
            The function cannot be read, or its units do not fit.
        EstimationError
            It has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function is nonlinear within the uncertainty: the delta method is not accurate.
        """
        return self.distribution.derived(function, "use draws: propagate()", self._curvature)

    @property
    def curvatures(self) -> Array:
        """Second-order part of each parameter's standard error relative to its first order, (p,).

        Zero where the regression is in the physical parameters themselves; the delta method is
        enough up to about 0.1.
        """
        curvature_of, p = self._curvature, len(self.physical)
        # A parameter as a function of all parameters: its gradient is a row of the identity.
        return np.array([curvature_of(row, np.zeros((p, p))) for row in np.eye(p)])

    def propagate(
        self,
        function: FunctionLike,
        *,
        draws: int = 10_000,
        seed: int = 0,
        covariance: str | None = None,
    ) -> DrawSummary:
        """Return a function of the physical parameters over draws from their distribution.

        The regression's own parameters are drawn from Student's multivariate distribution and
        mapped exactly. Unlike in `derive`, neither the map nor the function is linearised. The bias
        by filter and noise is subtracted from the draws, as from every interval.

        Parameters
        ----------
        function : str or SymPy expression
            As in `derive`; the name of a parameter for its own distribution.
        draws, seed : int
            Number of draws, and seed of the random numbers.
        covariance : {"hac", "robust", "iid"}, optional
            Covariance that the draws are from; that of `chosen` by default.

        Raises
        ------
        UsageError
            As in `derive`; or too few or too many draws, or an unknown covariance or seed.
        """
        covariance = self.chosen if covariance is None else covariance
        refuse(
            UsageError,
            (
                not is_among(covariance, self.covariances),
                f"there is no covariance {quoted(covariance)}. Choose from "
                f"{', '.join(self.covariances)}",
            ),
            (
                not (is_whole(seed) and seed >= 0),
                f"the seed is {quoted(seed)}. Give a whole number of 0 or more",
            ),
            code="result",
        )
        read = parameter_function(function, {q.name: q.unit for q in self.quantities})
        freedom = (self.inference.ddm_freedom or self.freedom)[covariance]
        of_theta = self._covariance_of_theta(covariance)
        drawn, lost = draw_parameters(self.form, self.theta, of_theta, freedom, draws, seed)
        drawn += self.corrected - self.physical  # minus the bias by filter and noise
        return summary_of_draws(read.value, self.physical, str(read.unit), drawn, lost, seed)

    @property
    def residual_tests(self) -> ResidualTests:
        """Tests of the net residuals, multiplied by the weights of their records."""
        return residual_tests(self.weights * self.net_residuals, neighbours=self.neighbours)

    @property
    def _curvature(self) -> Callable[[Array, Array], float]:
        """Function that returns the curvature of a function f of the physical parameters.

        Its arguments are the gradient, (p,), and the Hessian, (p, p), of f. The curvature is the
        second-order part of the standard error of f, relative to the first-order part.
        """
        of_theta = self._covariance_of_theta(self.chosen)
        return partial(curvature, *scaled_gradients_and_hessians(self.form, self.theta, of_theta))

    def _covariance_of_theta(self, name: str) -> Array:
        """Return the covariance of the regression's own parameters, (k, k), by its name.

        For a direct model, these covariances are known. Otherwise the covariance of the physical
        parameters is mapped back by the inverse Jacobian.
        """
        if self.is_direct:
            return self.ddm_covariances[name]
        inverse = np.asarray(np.linalg.inv(self.jacobian), dtype=float)
        return delta_method(self.covariances[name], inverse)
