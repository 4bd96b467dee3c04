"""Where loops start, searched for with the parameters of the model.

A record tells where its loop starts, but for its noise: the first position is one sample, and the
first velocity is of a parabola through some. A search may have both, of each stretch its own. What
the law remembers there is of what it measured, which the record has.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.loops import loop_starts
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.estimation.simulation import LoopInputs
from axisid.modeling.quantities import Parameter, fresh_name
from axisid.support.arrays import Array

from .time import FormByTime

#: How parameters of a start are called, and what asks for both.
STARTS, START = ("start_position", "start_velocity"), "start"
_SIZE = 1e-2  # of the range of positions, and of the mean speed: a start's least size


@dataclass(frozen=True, slots=True, kw_only=True)
class _Start:
    """Of one stretch."""

    record: int
    segment: int
    parameters: tuple[Parameter, ...]  # what is free of position and velocity
    sizes: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class FormByStart(InverseForm):
    """A form whose physical parameters have first positions and velocities behind them.

    Attributes
    ----------
    of_model : Form
        Of the others.
    names : tuple of str
        Of `STARTS`, what is free.
    starts : tuple
        Of each stretch, those of a record one after the other.
    """

    of_model: Form = field(kw_only=True)
    names: tuple[str, ...] = field(kw_only=True)
    starts: tuple[_Start, ...] = field(kw_only=True)

    @classmethod
    def of(
        cls,
        form: Form,
        axes: Sequence[GeneratedAxis],
        records: Sequence[Record],
        asked: Sequence[str],
    ) -> "FormByStart":
        """A form with what is asked for of the starts of all stretches of the records behind it."""
        names = tuple(name for name in STARTS if START in asked or name in asked)
        stretches = [
            (i, segment, start)
            for i, pair in enumerate(zip(axes, records, strict=True))
            for segment, start in enumerate(loop_starts(*pair))
        ]
        taken = {q.name.lower() for q in form.physical_quantities}
        q, found = axes[0].axis.coordinate, []
        for number, (i, segment, start) in enumerate(stretches, 1):
            after = f"_{number}" if len(stretches) > 1 else ""
            rows = slice(*records[i].spans[segment])
            sizes = start_sizes(records[i].position[rows], records[i].period)
            units, values = (q.unit, q.velocity_unit), (start.position, start.velocity)
            told = zip(STARTS, map(str, units), map(float, values), sizes, strict=True)
            chosen = [each for each in told if each[0] in names]
            parameters = tuple(
                Parameter(fresh_name(name + after, taken), unit, nominal=value)
                for name, unit, value, _ in chosen
            )
            found.append(
                _Start(
                    record=i,
                    segment=segment,
                    parameters=parameters,
                    sizes=tuple(size for *_, size in chosen),
                )
            )
        return cls(axes[0], of_model=form, names=names, starts=tuple(found))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Of the starts, position and velocity of each stretch."""
        return tuple(p for start in self.starts for p in start.parameters)

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        starts = (Quantity(name=p.name, unit=p.unit) for p in self.parameters)
        return (*self.of_model.physical_quantities, *starts)

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """See `Form.declared`."""
        return (*self.of_model.declared, *self.parameters)

    @property
    def start(self) -> Array:
        """See `Form.start`."""
        return np.append(self.of_model.start, [float(p.nominal or 0.0) for p in self.parameters])

    @property
    def local(self) -> dict[str, tuple[str, ...]]:
        """Names by record, where there are several and each has one stretch."""
        if len(self.starts) == 1 or any(start.segment for start in self.starts):
            return {}
        by_name = zip(*(start.parameters for start in self.starts), strict=True)
        pairs = zip(self.names, by_name, strict=True)
        return {name: tuple(p.name for p in of_records) for name, of_records in pairs}

    def own(self, physical: Array, record: int) -> Array:
        """See `Form.own`; without the starts."""
        return self.of_model.own(physical[: len(physical) - len(self.parameters)], record)


def are_starts(form: Form) -> NDArray[np.bool_]:
    """Which physical parameters are first positions and velocities of loops, (P,)."""
    if isinstance(form, FormByTime):
        return np.append(are_starts(form.of_model), False)
    found = np.zeros(len(form.physical_quantities), dtype=bool)
    if isinstance(form, FormByStart):
        found[len(found) - len(form.parameters) :] = True
    return found


def least_sizes(form: Form) -> Array:
    """Least sizes of physical parameters, from which steps are taken: of starts, else 0, (P,)."""
    if isinstance(form, FormByTime):
        return np.append(least_sizes(form.of_model), 0.0)
    found = np.zeros(len(form.physical_quantities))
    if isinstance(form, FormByStart):
        own = np.ravel([start.sizes for start in form.starts])
        found[len(found) - len(own) :] = own
    return found


def started_at(
    form: Form, physical: Array, record: int, segment: int, inputs: LoopInputs
) -> LoopInputs:
    """What a stretch is simulated from, where physical parameters (P,) or (B, P) let it start."""
    if isinstance(form, FormByTime):
        return started_at(form.of_model, physical[..., :-1], record, segment, inputs)
    if not isinstance(form, FormByStart):
        return inputs
    place = [(s.record, s.segment) for s in form.starts].index((record, segment))
    first = physical.shape[-1] - len(form.names) * (len(form.starts) - place)
    values = dict(zip(form.names, np.moveaxis(physical, -1, 0)[first:], strict=False))
    position, velocity = (values.get(name) for name in STARTS)
    start = inputs.start
    if position is not None:
        start = replace(start, position=position)
    if velocity is not None:
        start = replace(start, velocity=velocity)
    return replace(inputs, start=start)


def start_sizes(position: Array, period: float) -> tuple[float, float]:
    """Least sizes of a first position and velocity of a stretch, from which steps are taken."""
    reach = float(np.ptp(position)) or 1.0
    most = reach / (period * len(position))  # of which a motion there and back makes more
    speed = float(np.abs(np.diff(position)).mean()) / period if len(position) > 1 else 0.0
    return _SIZE * reach, _SIZE * max(speed, most)
