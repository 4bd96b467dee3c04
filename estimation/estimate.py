"""What an estimator returns."""

from dataclasses import dataclass

import numpy as np

from axisid.codegen import Quantity

from .arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A number that leaves the program: with unit and standard deviation."""

    value: float
    unit: str
    sd: float

    @property
    def relative_sd_percent(self) -> float:
        """``100 sd / |value|``; infinite for a value of 0."""
        return 100.0 * self.sd / abs(self.value) if self.value else float("inf")


@dataclass(frozen=True, slots=True, kw_only=True)
class Iterate:
    """One iterate of the instrumental-variable estimate.

    Attributes
    ----------
    physical : (p,) array
    theta : (k,) array
        In the regression's own parameters.
    simulation_error_percent : float
        Of the loop simulated with it.
    """

    physical: Array
    theta: Array
    simulation_error_percent: float


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Estimate:
    """An estimate of the physical parameters, and of the direct model's where it is regressed.

    Attributes
    ----------
    method : str
        ``idm-ls``, ``ddm-ls``, ``idm-iv`` or ``ddm-iv``.
    quantities : tuple of Quantity
        Physical parameters, length p.
    physical : (p,) array
    covariance : (p, p) array
        Of `physical`; by the delta method for a direct model.
    ddm_quantities : tuple of Quantity
        Length m; empty for an inverse model.
    theta_ddm : (m,) array
    ddm_covariance : (m, m) array
    y : (n,) array
        Left side of the regression: force (IDM) or acceleration (DDM).
    X : (n, k) array
        Regressor.
    rows : (n,) array
        Sample number of each row.
    residuals : (n,) array
        ``y - X theta``, less the known part of the model if it has one.
    simulated : (n,) array or None
        Left side as the simulated loop has it; None where the loop could not be simulated.
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||``. Not a quality of an instrumental-variable estimate.
    simulation_error_percent : float or None
        ``100 ||y - simulated|| / ||y||``.
    condition_number : float
        Of X as it is, not scaled.
    iterates : tuple of Iterate
        The start and every iterate; empty for least squares.
    covariance_name : str
        Which covariance, for the notes of a table.
    remarks : tuple of str
        What the user should know about this estimate.
    """

    method: str
    quantities: tuple[Quantity, ...]
    physical: Array
    covariance: Array
    ddm_quantities: tuple[Quantity, ...]
    theta_ddm: Array
    ddm_covariance: Array
    y: Array
    X: Array
    rows: Array
    residuals: Array
    simulated: Array | None
    equation_error_percent: float
    simulation_error_percent: float | None
    condition_number: float
    iterates: tuple[Iterate, ...]
    covariance_name: str
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        values = (f"{n} = {v.value:.6g} +- {v.sd:.2g} {v.unit}" for n, v in self.parameters.items())
        return f"{self.method}: {', '.join(values)}"

    @property
    def parameters(self) -> dict[str, Value]:
        """Physical parameters by name."""
        return _values(self.quantities, self.physical, self.covariance)

    @property
    def ddm_parameters(self) -> dict[str, Value]:
        """Parameters of the direct model by name; empty for an inverse model."""
        return _values(self.ddm_quantities, self.theta_ddm, self.ddm_covariance)


def _values(quantities: tuple[Quantity, ...], theta: Array, covariance: Array) -> dict[str, Value]:
    deviations = np.sqrt(np.diag(covariance))
    return {
        quantity.name: Value(value=float(value), unit=quantity.unit, sd=float(sd))
        for quantity, value, sd in zip(quantities, theta, deviations, strict=True)
    }
