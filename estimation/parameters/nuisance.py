"""What is searched for beside the model's parameters: starts of loops, gains, a time of the drive.

A record tells where its loop starts, but for its noise: the first position is one sample, and the
first velocity is of a parabola through some. A search may have both, of each stretch its own. What
the law remembers there is of what it measured, which the record has.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import loop_starts
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.estimation.simulation import LoopInputs
from axisid.modeling.quantities import Parameter, fresh_name
from axisid.support.arrays import Array

#: How parameters of a start are called, and what asks for both.
STARTS, START = ("start_position", "start_velocity"), "start"
_SIZE = 1e-2  # of the range of positions, and of the mean speed: a start's least size

_NEXT_TO_0 = 1e-9  # of what a gain is declared as


@dataclass(frozen=True, slots=True)
class FormByMore(InverseForm):
    """A form whose physical parameters have more behind them, which no row is linear in.

    Attributes
    ----------
    of_model : Form
        Of the others.
    """

    of_model: Form = field(kw_only=True)

    @property
    @abstractmethod
    def more(self) -> tuple[Parameter, ...]:
        """What is behind them; a search starts from nominal values."""

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        more = (Quantity(name=p.name, unit=p.unit) for p in self.more)
        return (*self.of_model.physical_quantities, *more)

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """See `Form.declared`."""
        return (*self.of_model.declared, *self.more)

    @property
    def start(self) -> Array:
        """See `Form.start`."""
        return np.append(self.of_model.start, [float(p.nominal or 0.0) for p in self.more])

    def own(self, physical: Array, record: int) -> Array:
        """See `Form.own`; without what is behind."""
        return self.of_model.own(physical[: len(physical) - len(self.more)], record)


_F = TypeVar("_F", bound=FormByMore)


def _more_of(form: Form, kind: type[_F]) -> tuple[_F, slice] | None:
    """The form of a kind within a form, and where its own stand among all parameters."""
    end = len(form.physical_quantities)
    while isinstance(form, FormByMore):
        first = end - len(form.more)
        if isinstance(form, kind):
            return form, slice(first, end)
        form, end = form.of_model, first
    return None


@dataclass(frozen=True, slots=True)
class FormByTime(FormByMore):
    """A form with a time of the drive behind it.

    Attributes
    ----------
    time : Parameter
        ``lag`` or ``delay``, s; its nominal value is where a search starts.
    """

    time: Parameter = field(kw_only=True)

    @property
    def more(self) -> tuple[Parameter, ...]:
        """See `FormByMore.more`."""
        return (self.time,)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Start:
    """Of one stretch."""

    record: int
    segment: int
    parameters: tuple[Parameter, ...]  # what is free of position and velocity
    sizes: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class FormByStart(FormByMore):
    """A form with first positions and velocities behind it.

    Attributes
    ----------
    names : tuple of str
        Of `STARTS`, what is free.
    starts : tuple
        Of each stretch, those of a record one after the other.
    """

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
    def more(self) -> tuple[Parameter, ...]:
        """See `FormByMore.more`; position and velocity of each stretch."""
        return tuple(p for start in self.starts for p in start.parameters)

    @property
    def local(self) -> dict[str, tuple[str, ...]]:
        """Names by record, where there are several and each has one stretch."""
        if len(self.starts) == 1 or any(start.segment for start in self.starts):
            return {}
        by_name = zip(*(start.parameters for start in self.starts), strict=True)
        pairs = zip(self.names, by_name, strict=True)
        return {name: tuple(p.name for p in of_records) for name, of_records in pairs}


def are_starts(form: Form) -> NDArray[np.bool_]:
    """Which physical parameters are first positions and velocities of loops, (P,)."""
    return least_sizes(form) > 0


def least_sizes(form: Form) -> Array:
    """Least sizes of physical parameters, from which steps are taken: of starts, else 0, (P,)."""
    sizes = np.zeros(len(form.physical_quantities))
    if found := _more_of(form, FormByStart):
        of_starts, place = found
        sizes[place] = np.ravel([start.sizes for start in of_starts.starts])
    return sizes


def started_at(
    form: Form, physical: Array, record: int, segment: int, inputs: LoopInputs
) -> LoopInputs:
    """What a stretch is simulated from, where physical parameters (P,) or (B, P) let it start."""
    found = _more_of(form, FormByStart)
    if found is None:
        return inputs
    of_starts, place = found
    number = [(s.record, s.segment) for s in of_starts.starts].index((record, segment))
    first = place.start + number * len(of_starts.names)
    values = dict(zip(of_starts.names, np.moveaxis(physical, -1, 0)[first:], strict=False))
    start = replace(
        inputs.start,
        **{name.removeprefix("start_"): value for name, value in values.items()},
    )
    return replace(inputs, start=start)


def start_sizes(position: Array, period: float) -> tuple[float, float]:
    """Least sizes of a first position and velocity of a stretch, from which steps are taken."""
    reach = float(np.ptp(position)) or 1.0
    most = reach / (period * len(position))  # of which a motion there and back makes more
    speed = float(np.abs(np.diff(position)).mean()) / period if len(position) > 1 else 0.0
    return _SIZE * reach, _SIZE * max(speed, most)


@dataclass(frozen=True, slots=True)
class FormByGains(FormByMore):
    """A form with gains of the law behind it.

    Attributes
    ----------
    gains : tuple of str
    """

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
    def more(self) -> tuple[Parameter, ...]:
        """See `FormByMore.more`; no gain changes its sign."""
        law = self.axis.loop_with(self.gains)[1]
        values = [(name, float(law.gains[name])) for name in self.gains]
        return tuple(
            Parameter(
                name,
                "1",
                nominal=value,
                lower=0.0 if value > 0 else -np.inf,
                upper=0.0 if value < 0 else np.inf,
            )
            for name, value in values
        )

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        gains = (Quantity(name=name, unit="") for name in self.gains)
        return (*self.of_model.physical_quantities, *gains)


def gains_in(form: Form, physical: Array) -> dict[str, Array]:
    """The free gains among physical parameters (P,) or (B, P), by name.

    One that a law has above 0 alone, such as a time, stays there where a search steps to 0.
    """
    found = _more_of(form, FormByGains)
    if found is None:
        return {}
    of_gains, place = found
    names, law = of_gains.gains, of_gains.axis.loop_with(of_gains.gains)[1]
    least = [_NEXT_TO_0 * law.gains[n] if n in law.positive else -np.inf for n in names]
    values = np.maximum(physical[..., place], least)
    return dict(zip(names, np.moveaxis(values, -1, 0), strict=True))


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
