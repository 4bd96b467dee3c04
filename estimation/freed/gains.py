"""Gains of the control law that are searched for with the parameters of the model."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import loop_starts
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.estimation.simulation import LoopInputs
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array

from .start import FormByStart
from .time import FormByTime

_NEXT_TO_0 = 1e-9  # of what a gain is declared as


@dataclass(frozen=True, slots=True)
class FormByGains(InverseForm):
    """A form whose physical parameters have gains of the law behind them.

    Attributes
    ----------
    of_model : Form
        Of the parameters alone.
    gains : tuple of str
    """

    of_model: Form = field(kw_only=True)
    gains: tuple[str, ...] = field(kw_only=True)

    @classmethod
    def of(cls, form: Form, axes: Sequence[GeneratedAxis], names: Sequence[str]) -> "FormByGains":
        """A form with gains that are free, and the same for all records.

        Raises
        ------
        ModelError
            The axis has no law whose gains could change, or not that gain.
        """
        gains = tuple(dict.fromkeys(names))
        for axis in axes:
            axis.loop_with(gains)
        return cls(axes[0], of_model=form, gains=gains)

    @property
    def declared_gains(self) -> Array:
        """As the law has them, (g,)."""
        law = self.axis.loop_with(self.gains)[1]
        return np.array([law.gains[name] for name in self.gains])

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        gains = (Quantity(name=name, unit="") for name in self.gains)
        return (*self.of_model.physical_quantities, *gains)

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """See `Form.declared`; no gain changes its sign."""
        values = self.declared_gains
        bounds = [(0.0 if v > 0 else -np.inf, 0.0 if v < 0 else np.inf) for v in values]
        gains = (
            Parameter(name, "1", nominal=float(value), lower=low, upper=high)
            for name, value, (low, high) in zip(self.gains, values, bounds, strict=True)
        )
        return (*self.of_model.declared, *gains)

    @property
    def start(self) -> Array:
        """See `Form.start`."""
        return np.append(self.of_model.start, self.declared_gains)

    def own(self, physical: Array, record: int) -> Array:
        """See `Form.own`; without the gains."""
        return self.of_model.own(physical[: len(physical) - len(self.gains)], record)


def gains_in(form: Form, physical: Array) -> dict[str, Array]:
    """The free gains among physical parameters (P,) or (B, P), by name.

    One that a law has above 0 alone, such as a time, stays there where a search steps to 0.
    """
    if isinstance(form, FormByTime):
        return gains_in(form.of_model, physical[..., :-1])
    if isinstance(form, FormByStart):
        return gains_in(form.of_model, physical[..., : -len(form.parameters)])
    if not isinstance(form, FormByGains):
        return {}
    law = form.axis.loop_with(form.gains)[1]
    least = [_NEXT_TO_0 * law.gains[n] if n in law.positive else -np.inf for n in form.gains]
    values = np.maximum(physical[..., -len(form.gains) :], least)
    return dict(zip(form.gains, np.moveaxis(values, -1, 0), strict=True))


def axis_at(axis: GeneratedAxis, form: Form, physical: Array) -> GeneratedAxis:
    """The axis of a record, its law with the gains of physical parameters (P,)."""
    gains = gains_in(form, physical)
    if not gains:
        return axis
    return _with_gains(axis, tuple((name, float(value)) for name, value in gains.items()))


# Most lanes of a step have the same gains, and other parameters.
@lru_cache(maxsize=64)
def _with_gains(axis: GeneratedAxis, gains: tuple[tuple[str, float], ...]) -> GeneratedAxis:
    return axis.with_gains(dict(gains))


def inputs_at(axis: GeneratedAxis, record: Record, segment: int, inputs: LoopInputs) -> LoopInputs:
    """What a loop is simulated from, with what an axis's law remembers where a segment begins."""
    memory = loop_starts(axis, record)[segment].memory
    start = LoopStart(
        position=inputs.start.position,
        velocity=inputs.start.velocity,
        memory=_at_rest(axis, inputs) if memory is None else memory,
    )
    return replace(inputs, start=start)


def _at_rest(axis: GeneratedAxis, inputs: LoopInputs) -> Array:
    first = (float(values[0]) for values in inputs.signals)
    measured = float(np.ravel(inputs.start.position)[0])
    state = axis.functions["control_start"](float(inputs.reference[0]), measured, *first)
    return np.asarray(state.full().ravel())
