"""The two forms a model is regressed in: inverse (IDM) and direct (DDM).

Both put the same physics into ``y = X theta + known``; they differ in what is on the left, in the
regressor, and in how their parameters map to the physical ones.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from axisid.codegen import GeneratedAxis, Quantity
from axisid.modeling import ModelError

from .arrays import Array
from .signals import Signals


@dataclass(frozen=True, slots=True)
class Form(ABC):
    """One way to write the axis's model as a linear regression."""

    axis: GeneratedAxis

    @property
    @abstractmethod
    def quantities(self) -> tuple[Quantity, ...]:
        """What the regression estimates."""

    @abstractmethod
    def equations(self, signals: Signals) -> tuple[Array, Array]:
        """``y`` (N,) without its known part, and ``X`` (N, k)."""

    @abstractmethod
    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Physical parameters (p,) of an estimate (k,), and the Jacobian (p, k)."""

    @abstractmethod
    def regressed(self, physical: Array) -> Array:
        """The regression's parameters (k,) of physical ones (p,)."""


@dataclass(frozen=True, slots=True)
class InverseForm(Form):
    """``tau = IDM(q, dq, ddq) theta + known``: the physical parameters themselves."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The physical parameters."""
        return self.axis.parameters

    def equations(self, signals: Signals) -> tuple[Array, Array]:
        """Force, and the inverse regressor."""
        s = signals
        row, known = self.axis.rows(
            "idm_regressor", s.position, s.velocity, s.acceleration, s.direction
        )
        return s.force - known[:, 0], row

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """The estimate itself."""
        return theta, np.eye(len(theta))

    def regressed(self, physical: Array) -> Array:
        """The parameters themselves."""
        return physical


@dataclass(frozen=True, slots=True)
class DirectForm(Form):
    """``ddq = DDM(tau, q, dq) theta_ddm + known``: quotients by the inertia."""

    def __post_init__(self) -> None:
        if self.axis.ddm_refusal:
            raise ModelError(self.axis.ddm_refusal)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """``theta_ddm``."""
        return self.axis.ddm_parameters

    def equations(self, signals: Signals) -> tuple[Array, Array]:
        """Acceleration, and the direct regressor."""
        s = signals
        row, known = self.axis.rows("ddm_regressor", s.position, s.velocity, s.force, s.direction)
        return s.acceleration - known[:, 0], row

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Through the generated inverse map."""
        return self.axis.mapped("physical_from_ddm", theta)

    def regressed(self, physical: Array) -> Array:
        """Through the generated map."""
        return self.axis.mapped("ddm_from_physical", physical)[0]
