"""The regression of several records in their own parameters, and the drive gain if it is shown.

Where a known force is among what the records need, the force of a control, ``g0 u`` by the declared
gain, is ``g0/g`` times all of it. So with ``kappa = g0/g``

    g0 u = X mu' + kappa known,    mu = mu' / kappa,    g = g0 / kappa,

which is linear, and a loop that is simulated with ``mu'``, ``kappa known`` and the declared gain is
the loop of ``mu``, ``known`` and g.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import Quantity
from axisid.estimation.regression import Form, InverseForm
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array

from .layout import Layout


@dataclass(frozen=True, slots=True)
class JointForm(InverseForm):
    """The inverse model of several records, linear in the parameters of a layout.

    Attributes
    ----------
    layout : Layout
    """

    layout: Layout = field(kw_only=True)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The parameters, scaled by the gain, and its inverse in the declared one's."""
        return self.physical_quantities

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        return self.layout.quantities

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """See `Form.declared`."""
        return self.layout.parameters

    @property
    def is_linear(self) -> bool:
        """See `Form.is_linear`; what is not linear is refused by the layout."""
        return True

    @property
    def start(self) -> Array:
        """See `Form.start`."""
        return self.layout.nominal

    def at(self, physical: Array) -> "JointForm":  # noqa: ARG002
        """See `Form.at`."""
        return self

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """See `Form.physical`."""
        gain = self.layout.gain
        if gain is None:
            return InverseForm.physical(self, theta)
        scaled, kappa = theta[:-1], theta[-1]
        k = len(scaled)
        jacobian = np.zeros((k + 1, k + 1))
        jacobian[:k, :k] = np.eye(k) / kappa
        jacobian[:k, k] = -scaled / kappa**2
        jacobian[k, k] = -gain / kappa**2
        return np.append(scaled, gain) / kappa, jacobian

    def regressed(self, physical: Array) -> Array:
        """See `Form.regressed`."""
        gain = self.layout.gain
        if gain is None:
            return physical
        kappa = gain / physical[-1]
        return np.append(physical[:-1] * kappa, kappa)

    def have_inertia(self, physical: Array) -> NDArray[np.bool_]:
        """See `Form.have_inertia`; in every record."""
        found = np.ones(len(physical), dtype=bool)
        for i in range(len(self.layout.members)):
            own = np.array([self.own(each, i) for each in physical])
            found &= self.of_record(i).have_inertia(own)
        return found

    def of_record(self, record: int) -> Form:
        """See `Form.of_record`."""
        return InverseForm(self.layout.members[record].axis)

    def own(self, physical: Array, record: int) -> Array:
        """See `Form.own`."""
        return self.layout.own(self.regressed(physical), record)

    def slopes(self, record: int) -> Array:
        """See `Form.slopes`."""
        return self.layout.slopes(record)

    def placed(self, record: int, intercept: Array, regressor: Array) -> tuple[Array, Array]:
        """See `Form.placed`."""
        return self.layout.placed(record, intercept, regressor)
