"""A lag or a delay of the drive that is searched for with the parameters of the model."""

from dataclasses import dataclass, field

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.regression import Form, InverseForm
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array


@dataclass(frozen=True, slots=True)
class FormByTime(InverseForm):
    """A form whose physical parameters have a time of the drive behind them.

    Attributes
    ----------
    of_model : Form
        Of the others.
    time : Parameter
        ``lag`` or ``delay``, s; its nominal value is where a search starts.
    """

    of_model: Form = field(kw_only=True)
    time: Parameter = field(kw_only=True)

    @classmethod
    def of(cls, form: Form, axis: GeneratedAxis, time: Parameter) -> "FormByTime":
        """A form with a time behind it."""
        return cls(axis, of_model=form, time=time)

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        return (*self.of_model.physical_quantities, Quantity(name=self.time.name, unit="s"))

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """See `Form.declared`."""
        return (*self.of_model.declared, self.time)

    @property
    def start(self) -> Array:
        """See `Form.start`."""
        return np.append(self.of_model.start, float(self.time.nominal or 0.0))

    def own(self, physical: Array, record: int) -> Array:
        """See `Form.own`; without the time."""
        return self.of_model.own(physical[:-1], record)
