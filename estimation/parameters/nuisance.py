"""What is searched for beside the model's parameters: starts of loops, gains, a time of the drive.

A record tells where its loop starts, but for its noise: the first position is one sample, and the
first velocity is of a parabola through some. A search may have both, of each stretch its own. What
the law remembers there is of what it measured, which the record has.

A loop by another drive gain g is that by the declared gain g0 with every force times g0/g: what
enters the force linearly is searched for as it is, and simulated times that.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.loops import loop_starts
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.estimation.simulation import LoopInputs
from axisid.modeling.quantities import Parameter, fresh_name
from axisid.support.arrays import Array
from axisid.support.errors import ModelError

from .layout import GAIN, JointForm, drive_gain_of

#: How parameters of a start are called, and what asks for both.
START_PARAMETERS, START = ("start_position", "start_velocity"), "start"
_SIZE = 1e-2  # of the range of positions, and of the mean speed: a start's least size

_NEXT_TO_0 = 1e-9  # of what a gain is declared as
_MOTIONS, _SEED = 64, 0  # on which a force is held against twice its parameters
_SAME = 1e-9  # of the largest force


@dataclass(frozen=True, slots=True, kw_only=True)
class _Start:
    """Of one stretch."""

    record: int
    segment: int
    parameters: dict[
        str, Parameter
    ]  # by what is free of position and velocity, of `START_PARAMETERS`
    sizes: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ExtendedForm(InverseForm):
    """A form whose physical parameters have more behind them, which no row is linear in.

    They stand in the order of the attributes, and a search starts from their nominal values.

    Attributes
    ----------
    of_model : Form
        Of the others.
    axes : tuple of GeneratedAxis
        By record.
    drive_gain : tuple of Parameter
        The drive's gain; its nominal value is the declared one.
    gains : tuple of Parameter
        Gains of the law, the same for all records.
    starts : tuple
        First positions and velocities of each stretch, those of a record one after the other.
    time : tuple of Parameter
        The drive's ``lag`` or ``delay``, s.
    """

    of_model: Form = field(kw_only=True)
    axes: tuple[GeneratedAxis, ...] = field(kw_only=True)
    drive_gain: tuple[Parameter, ...] = field(default=(), kw_only=True)
    gains: tuple[Parameter, ...] = field(default=(), kw_only=True)
    starts: tuple[_Start, ...] = field(default=(), kw_only=True)
    time: tuple[Parameter, ...] = field(default=(), kw_only=True)

    @classmethod
    def of(cls, form: Form, axes: Sequence[GeneratedAxis]) -> "ExtendedForm":
        """A form with nothing behind it yet, by the axes of the records; or itself."""
        return form if isinstance(form, cls) else cls(axes[0], of_model=form, axes=tuple(axes))

    @property
    def more(self) -> tuple[Parameter, ...]:
        """What is behind the parameters of the model."""
        starts = (p for start in self.starts for p in start.parameters.values())
        return (*self.drive_gain, *self.gains, *starts, *self.time)

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """See `Form.physical_quantities`."""
        more = (Quantity(name=p.name, unit="" if p.unit == "1" else p.unit) for p in self.more)
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
        """See `Form.own`; those with which the declared gain moves the axis alike."""
        count = len(self.of_model.physical_quantities)
        own = self.of_model.own(physical[:count], record)
        if not self.drive_gain:
            return own
        return by_declared_gain(self.axes[record], own, float(physical[count]))

    @property
    def place_of_gains(self) -> slice:
        """Where the law's gains are among all parameters; what is behind them, starts begin."""
        first = len(self.of_model.physical_quantities) + len(self.drive_gain)
        return slice(first, first + len(self.gains))

    @property
    def local(self) -> dict[str, tuple[str, ...]]:
        """Names by record, where there are several and each has one stretch."""
        if len(self.starts) < 2 or any(start.segment for start in self.starts):
            return {}
        return {
            name: tuple(start.parameters[name].name for start in self.starts)
            for name in self.starts[0].parameters
        }


def with_drive_gain(form: Form, axes: Sequence[GeneratedAxis]) -> Form:
    """A form with the drive's gain behind it; itself where a known force has it searched already.

    Raises
    ------
    ModelError
        The force of the drive, or of an axis, is no multiple of what would be searched.
    """
    if isinstance(form, JointForm) and form.gain is not None:
        return form
    gain = searched_gain(axes, [q.name for q in form.physical_quantities])
    return replace(ExtendedForm.of(form, axes), drive_gain=(gain,))


def with_gains(form: Form, axes: Sequence[GeneratedAxis], names: Sequence[str]) -> ExtendedForm:
    """A form with gains of the law that are free, and the same for all records.

    No gain changes its sign.

    Raises
    ------
    ModelError
        The axis has no law whose gains could change, or not that gain.
    """
    free = tuple(dict.fromkeys(names))
    law, *_ = [axis.loop_with(free)[1] for axis in axes]
    values = [(name, float(law.gains[name])) for name in free]
    gains = tuple(
        Parameter(
            name,
            "1",
            nominal=value,
            lower=0.0 if value > 0 else -np.inf,
            upper=0.0 if value < 0 else np.inf,
        )
        for name, value in values
    )
    return replace(ExtendedForm.of(form, axes), gains=gains)


def with_starts(
    form: Form, axes: Sequence[GeneratedAxis], records: Sequence[Record], asked: Sequence[str]
) -> ExtendedForm:
    """A form with what is asked for of the starts of all stretches of the records behind it."""
    names = [name for name in START_PARAMETERS if START in asked or name in asked]
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
        every = zip(START_PARAMETERS, map(str, units), map(float, values), sizes, strict=True)
        chosen = [each for each in every if each[0] in names]
        found.append(
            _Start(
                record=i,
                segment=segment,
                parameters={
                    name: Parameter(fresh_name(name + after, taken), unit, nominal=value)
                    for name, unit, value, _ in chosen
                },
                sizes=tuple(size for *_, size in chosen),
            )
        )
    return replace(ExtendedForm.of(form, axes), starts=tuple(found))


def with_time(form: Form, axes: Sequence[GeneratedAxis], time: Parameter) -> ExtendedForm:
    """A form with a time of the drive behind it; its nominal value is where a search starts."""
    return replace(ExtendedForm.of(form, axes), time=(time,))


def are_starts(form: Form) -> NDArray[np.bool_]:
    """Which physical parameters are first positions and velocities of loops, (P,)."""
    return least_sizes(form) > 0


def least_sizes(form: Form) -> Array:
    """Least sizes of physical parameters, from which steps are taken: of starts, else 0, (P,)."""
    sizes = np.zeros(len(form.physical_quantities))
    if isinstance(form, ExtendedForm):
        own, first = np.ravel([start.sizes for start in form.starts]), form.place_of_gains.stop
        sizes[first : first + len(own)] = own
    return sizes


def started_at(
    form: Form, physical: Array, record: int, segment: int, inputs: LoopInputs
) -> LoopInputs:
    """What a stretch is simulated from, where physical parameters (P,) or (B, P) let it start."""
    if not (isinstance(form, ExtendedForm) and form.starts):
        return inputs
    number = [(s.record, s.segment) for s in form.starts].index((record, segment))
    names = form.starts[number].parameters
    first = form.place_of_gains.stop + number * len(names)
    values = dict(zip(names, np.moveaxis(physical, -1, 0)[first:], strict=False))
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


def gains_in(form: Form, physical: Array) -> dict[str, Array]:
    """The free gains among physical parameters (P,) or (B, P), by name.

    One that a law has above 0 alone, such as a time, stays there where a search steps to 0.
    """
    if not (isinstance(form, ExtendedForm) and form.gains):
        return {}
    names = [p.name for p in form.gains]
    law = form.axes[0].loop_with(names)[1]
    least = [_NEXT_TO_0 * law.gains[n] if n in law.positive else -np.inf for n in names]
    values = np.maximum(physical[..., form.place_of_gains], least)
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
    if memory is None:  # that of an axis at rest
        first = (float(values[0]) for values in inputs.signals)
        measured = float(np.ravel(inputs.start.position)[0])
        state = axis.functions["control_start"](float(inputs.reference[0]), measured, *first)
        memory = np.asarray(state.full().ravel())
    return replace(inputs, start=replace(inputs.start, memory=memory))


def by_declared_gain(axis: GeneratedAxis, physical: Array, gain: float) -> Array:
    """Parameters (p,) with which the declared gain moves an axis as these do with another gain."""
    declared = float(axis.axis.drive.gain)
    least = math.copysign(_NEXT_TO_0 * declared, declared)
    used = max(gain, least) if declared > 0 else min(gain, least)
    return np.where(axis.nonlinear, physical, physical * (declared / used))


def searched_gain(axes: Sequence[GeneratedAxis], names: Sequence[str]) -> Parameter:
    """The gain from where it is declared; what is declared of its deviation was known before.

    Parameters
    ----------
    axes : sequence of GeneratedAxis
        By record.
    names : sequence of str
        Of what else is searched.

    Raises
    ------
    ModelError
        The force of the drive, or of an axis, is no multiple of what would be searched.
    """
    for axis in axes:
        _check(axis, names)
    found, drive = drive_gain_of(axes[0]), axes[0].axis.drive
    value = float(drive.gain)
    found = replace(found, lower=0.0) if value > 0 else replace(found, upper=0.0)
    if not drive.relative_sd:
        return found
    return replace(found, known=value, known_sd=abs(value) * drive.relative_sd)


def _check(axis: GeneratedAxis, names: Sequence[str]) -> None:
    drive, name = axis.axis.drive, axis.axis.name
    if GAIN in names:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: a parameter of the axis has its "
            f"name, {GAIN}; call that another.",
            code="free",
        )
    if axis.states:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: its friction remembers, and what it "
            "remembers need not grow with its forces; give the gain as the data sheet has it.",
            code="free",
        )
    if not drive.is_times_gain:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: the force of its drive, "
            f"{drive.force}, is no multiple of it; give it as the data sheet has it, or a drive "
            "of another formula.",
            code="free",
        )
    if not _is_multiple(axis):
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: its equation of motion has a "
            "force of numbers alone, such as that of a rotor's inertia, which another gain "
            "would move; declare the number as a parameter, and say its value of the record; "
            "known NAME=VALUE.",
            code="free",
        )


def _is_multiple(axis: GeneratedAxis) -> bool:
    """Whether the force is twice as large with twice of what enters linearly."""
    random = np.random.default_rng(_SEED)
    motion = random.uniform(0.1, 1.0, (3, _MOTIONS))
    recorded = random.uniform(0.1, 1.0, (len(axis.axis.signals), _MOTIONS))
    direction = np.sign(random.uniform(-1.0, 1.0, _MOTIONS))
    motion[1] *= direction
    values = random.uniform(0.5, 1.5, len(axis.nominal)) * np.where(axis.nominal, axis.nominal, 1.0)

    def force(physical: Array) -> Array:
        about = () if axis.is_linear else (physical,)
        row, rest = axis.evaluate("idm_regressor", *motion, direction, *recorded, *about)
        return np.asarray(row @ physical + rest[:, 0])

    with np.errstate(all="ignore"):
        once, twice = force(values), force(np.where(axis.nonlinear, values, 2 * values))
    finite = np.isfinite(once) & np.isfinite(twice)
    off = np.abs(twice - 2 * once)[finite]
    return bool(np.all(off <= _SAME * np.abs(once[finite]).max(initial=0.0)))
