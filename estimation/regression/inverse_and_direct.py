"""The two forms a model is regressed in: inverse (IDM) and direct (DDM).

Both put the same physics into ``y = X theta + intercept``; they differ in what is on the left, in
the regressor, and in how their parameters map to the physical ones.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis, Quantity
from axisid.estimation.signals import FilteredRecord, Signals
from axisid.estimation.simulation import at_rest
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import Missing, ModelError


@dataclass(frozen=True, slots=True, kw_only=True)
class Equations:
    """``left = regressor theta + intercept``, row by row.

    Attributes
    ----------
    left : (n,) array
        Force (IDM) or acceleration (DDM).
    intercept : (n,) array
        What no parameter scales.
    regressor : (n, k) array
    """

    left: Array
    intercept: Array
    regressor: Array

    def reduced(self, data: FilteredRecord) -> "Equations":
        """The rows that the record's filter keeps, every column filtered alike."""
        k = self.regressor.shape[1]
        known = (self.intercept,) if np.any(self.intercept) else ()
        rows = data.reduce(np.column_stack([self.regressor, self.left, *known]))
        return Equations(
            left=rows[:, k].copy(),
            intercept=rows[:, k + 1].copy() if known else np.zeros(len(rows)),
            regressor=rows[:, :k],
        )

    def predicted(self, theta: Array) -> Array:
        """Left side with parameters (k,), (n,)."""
        return np.asarray(self.regressor @ theta + self.intercept, dtype=float)

    def residuals(self, theta: Array) -> Array:
        """What parameters (k,) leave of the left side, (n,)."""
        return np.asarray(self.left - self.intercept - self.regressor @ theta, dtype=float)

    @classmethod
    def stacked(cls, pieces: Sequence["Equations"]) -> "Equations":
        """The rows of several, one after the other."""
        if len(pieces) == 1:
            return pieces[0]
        return cls(
            left=np.concatenate([piece.left for piece in pieces]),
            intercept=np.concatenate([piece.intercept for piece in pieces]),
            regressor=np.concatenate([piece.regressor for piece in pieces]),
        )


@dataclass(frozen=True, slots=True)
class Form(ABC):
    """One way to write the axis's model as a linear regression."""

    axis: GeneratedAxis

    #: What stands on the left of the equations.
    left: ClassVar[str]

    @property
    def start(self) -> Array:
        """Physical parameters (p,) that an iteration starts from."""
        return self.axis.nominal

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What the regression estimates: the physical parameters, unless it is of others."""
        return self.axis.parameters

    @abstractmethod
    def equations(self, signals: Signals) -> Equations:
        """The model's rows for signals, (N,)."""

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """The physical parameters, length p."""
        return self.axis.parameters

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """The same with the bounds that they were declared with."""
        return self.axis.axis.parameters

    @property
    def is_linear(self) -> bool:
        """Whether the force is linear in all of them."""
        return self.axis.is_linear

    def describe(self, physical: Array) -> str:
        """Physical parameters (p,) in words, as ``M = 95.1 kg, Fv = 203.5 N/(m/s)``."""
        pairs = zip(self.physical_quantities, physical, strict=True)
        return ", ".join(f"{q.name} = {value:.6g} {q.unit}" for q, value in pairs)

    def have_inertia(self, physical: Array) -> NDArray[np.bool_]:
        """Which sets of physical parameters, (B, p), have a positive and finite inertia."""
        return at_rest(
            self.axis, physical, np.zeros(len(physical)), np.ones(len(self.axis.axis.signals))
        )[0]

    def of_record(self, record: int) -> "Form":  # noqa: ARG002
        """The form of one of several records, in that record's own parameters."""
        return self

    def own(self, physical: Array, record: int) -> Array:  # noqa: ARG002
        """Parameters of the axis of one of several records from physical ones (p,)."""
        return physical

    def record_jacobian(self, record: int) -> Array:  # noqa: ARG002
        """Of a record's own parameters by the regression's, (b, k)."""
        return np.eye(len(self.quantities))

    def placed(self, record: int, intercept: Array, regressor: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """A record's intercept, (n,), and regressor by the parameters of all records."""
        return intercept, regressor

    def at(self, physical: Array) -> "Form":  # noqa: ARG002
        """The form linearised about physical parameters (p,); itself if it is linear."""
        return self

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Physical parameters (p,) of an estimate (k,), and the Jacobian (p, k)."""
        return theta, np.eye(len(theta))

    def regressed(self, physical: Array) -> Array:
        """The regression's parameters (k,) of physical ones (p,)."""
        return physical


@dataclass(frozen=True, slots=True)
class InverseForm(Form):
    """``tau = IDM(q, dq, ddq) theta + intercept``: the physical parameters themselves.

    Attributes
    ----------
    point : (p,) array or None
        Where a partially linear model is linearised; its nominal values by default.
    """

    point: Array | None = None

    left: ClassVar[str] = "force"

    def equations(self, signals: Signals) -> Equations:
        """Force by the inverse regressor."""
        s = signals
        motion = (s.position, s.velocity, s.acceleration, s.direction)
        about = () if self.axis.is_linear else (self.start,)
        row, intercept = self.axis.evaluate("idm_regressor", *motion, *s.recorded, *about)
        return Equations(left=s.force, intercept=intercept[:, 0], regressor=row)

    def at(self, physical: Array) -> "InverseForm":
        """See `Form.at`."""
        return self if self.is_linear else replace(self, point=physical)

    @property
    def start(self) -> Array:
        """See `Form.start`; where it is linearised, if it is."""
        nominal = np.array([p.nominal for p in self.declared], dtype=float)
        return nominal if self.point is None else self.point


@dataclass(frozen=True, slots=True)
class DirectForm(Form):
    """``ddq = DDM(tau, q, dq) theta_ddm + intercept``: quotients by the inertia."""

    left: ClassVar[str] = "acceleration"

    def __post_init__(self) -> None:
        _ = self.quantities  # refuses an axis without

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """``theta_ddm``."""
        if isinstance(self.axis.ddm_parameters, Missing):
            raise ModelError(self.axis.ddm_parameters.reason)
        return self.axis.ddm_parameters

    def equations(self, signals: Signals) -> Equations:
        """Acceleration by the direct regressor."""
        s = signals
        motion = (s.position, s.velocity, s.force, s.direction)
        row, intercept = self.axis.evaluate("ddm_regressor", *motion, *s.recorded)
        return Equations(left=s.acceleration, intercept=intercept[:, 0], regressor=row)

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Through the generated inverse map."""
        return self.axis.mapped("physical_from_ddm", theta)

    def regressed(self, physical: Array) -> Array:
        """Through the generated map."""
        return self.axis.mapped("ddm_from_physical", physical)[0]
