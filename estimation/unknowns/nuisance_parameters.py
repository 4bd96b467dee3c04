"""What is searched for beside the model's parameters: starts of loops, gains, a time of the drive.

A record tells where its loop starts, but for its noise: the first position is one sample, and the
first velocity is of a parabola through some. A search may have both, of each stretch its own. What
the law remembers there is of what it measured, which the record has.

A loop by another drive gain g is that by the declared gain g0 with every force times g0/g: what
enters the force linearly is searched for as it is, and simulated times that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, Quantity
from axisid.estimation.law_replay import loop_starts
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.estimation.simulation import LoopInputs
from axisid.modeling.quantities import Parameter, fresh_name
from axisid.support.arrays import Array
from axisid.support.errors import ModelError, refuse

from .joint_parameters import GAIN, JointForm, drive_gain_of

#: How parameters of a start are called, and what asks for both.
INITIAL_STATE_PARAMETERS, START = ("start_position", "start_velocity"), "start"
_SIZE = 1e-2  # of the range of positions, and of the mean speed: a start's least size

_NEXT_TO_0 = 1e-9  # of what a gain is declared as
_MOTIONS, _SEED = 64, 0  # on which a force is held against what enters linearly
_SAME = 1e-9  # of the largest force


@dataclass(frozen=True, slots=True)
class ExtendedForm(InverseForm):
    """A form whose physical parameters may have more behind them, which no row is linear in.

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
    starts : mapping of (int, int) to mapping of str to Parameter
        First positions and velocities of each stretch, by record and segment: what is free of them
        by its name in `INITIAL_STATE_PARAMETERS`.
    start_sizes : tuple of float
        Their least sizes, from which steps are taken.
    time : tuple of Parameter
        The drive's ``lag`` or ``delay``, s.
    """

    of_model: Form = field(kw_only=True)
    axes: tuple[GeneratedAxis, ...] = field(kw_only=True)
    drive_gain: tuple[Parameter, ...] = field(default=(), kw_only=True)
    gains: tuple[Parameter, ...] = field(default=(), kw_only=True)
    starts: Mapping[tuple[int, int], Mapping[str, Parameter]] = field(
        default_factory=dict, kw_only=True
    )
    start_sizes: tuple[float, ...] = field(default=(), kw_only=True)
    time: tuple[Parameter, ...] = field(default=(), kw_only=True)

    @property
    def more(self) -> tuple[Parameter, ...]:
        """What is behind the parameters of the model."""
        starts = (p for start in self.starts.values() for p in start.values())
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
        """Names of each parameter that records have for themselves, by record.

        Of starts where there are several records and each has one stretch.
        """
        found = dict(self.of_model.local) if isinstance(self.of_model, JointForm) else {}
        every = [*self.starts.values()]
        if len(every) > 1 and not any(segment for _, segment in self.starts):
            found |= {name: tuple(each[name].name for each in every) for name in every[0]}
        return found

    def with_drive_gain(self) -> "ExtendedForm":
        """With the drive's gain; itself where a known force has it searched already.

        What is declared of its deviation was known before.

        Raises
        ------
        ModelError
            The force of the drive, or of an axis, is no multiple of what would be searched.
        """
        if isinstance(self.of_model, JointForm) and self.of_model.gain is not None:
            return self
        for axis in self.axes:
            _check_gain(axis, [q.name for q in self.physical_quantities])
        gain, drive = drive_gain_of(self.axes[0]), self.axes[0].axis.drive
        value = float(drive.gain)
        gain = replace(gain, lower=0.0) if value > 0 else replace(gain, upper=0.0)
        if drive.relative_sd:
            gain = replace(gain, known=value, known_sd=abs(value) * drive.relative_sd)
        return replace(self, drive_gain=(gain,))

    def with_gains(self, names: Sequence[str]) -> "ExtendedForm":
        """With gains of the law that are free, and the same for all records.

        No gain changes its sign.

        Raises
        ------
        ModelError
            The axis has no law whose gains could change, or not that gain.
        """
        free = tuple(dict.fromkeys(names))
        law, *_ = [axis.loop_with(free)[1] for axis in self.axes]
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
        return replace(self, gains=gains)

    def with_starts(self, records: Sequence[Record], asked: Sequence[str]) -> "ExtendedForm":
        """With what is asked for of the starts of all stretches of the records."""
        names = [name for name in INITIAL_STATE_PARAMETERS if START in asked or name in asked]
        stretches = [
            (i, segment, start)
            for i, pair in enumerate(zip(self.axes, records, strict=True))
            for segment, start in enumerate(loop_starts(*pair))
        ]
        taken, q = {q.name.lower() for q in self.physical_quantities}, self.axes[0].axis.coordinate
        found, sizes = dict[tuple[int, int], dict[str, Parameter]](), list[float]()
        for number, (i, segment, start) in enumerate(stretches, 1):
            after = f"_{number}" if len(stretches) > 1 else ""
            position, period = (
                records[i].position[slice(*records[i].spans[segment])],
                records[i].period,
            )
            reach = float(np.ptp(position)) or 1.0
            most = reach / (period * len(position))  # of which a motion there and back makes more
            speed = float(np.abs(np.diff(position)).mean()) / period if len(position) > 1 else 0.0
            every = zip(
                INITIAL_STATE_PARAMETERS,
                (q.unit, q.velocity_unit),
                (start.position, start.velocity),
                (_SIZE * reach, _SIZE * max(speed, most)),
                strict=True,
            )
            chosen = [each for each in every if each[0] in names]
            found[i, segment] = {
                name: Parameter(fresh_name(name + after, taken), str(unit), nominal=float(value))
                for name, unit, value, _ in chosen
            }
            sizes += [size for *_, size in chosen]
        return replace(self, starts=found, start_sizes=tuple(sizes))


def least_sizes(form: Form) -> Array:
    """Least sizes of physical parameters, from which steps are taken: of starts, else 0, (P,)."""
    sizes = np.zeros(len(form.physical_quantities))
    if isinstance(form, ExtendedForm):
        first = form.place_of_gains.stop
        sizes[first : first + len(form.start_sizes)] = form.start_sizes
    return sizes


def started_at(
    form: Form, physical: Array, record: int, segment: int, inputs: LoopInputs
) -> LoopInputs:
    """What a stretch is simulated from, where physical parameters (P,) or (B, P) let it start."""
    if not (isinstance(form, ExtendedForm) and form.starts):
        return inputs
    names = form.starts[record, segment]
    first = form.place_of_gains.stop + [*form.starts].index((record, segment)) * len(names)
    values = dict(zip(names, np.moveaxis(physical, -1, 0)[first:], strict=False))
    start = replace(
        inputs.start,
        **{name.removeprefix("start_"): value for name, value in values.items()},
    )
    return replace(inputs, start=start)


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
    declared = float(axis.drive.gain)
    least = np.copysign(_NEXT_TO_0 * declared, declared)
    used = max(gain, least) if declared > 0 else min(gain, least)
    return np.where(axis.nonlinear, physical, physical * (declared / used))


def _check_gain(axis: GeneratedAxis, names: Sequence[str]) -> None:
    """Refuse to search for the drive's gain beside names where the force is no multiple of it."""
    drive = axis.drive
    refuse(
        ModelError,
        (
            GAIN in names,
            f"a parameter of the axis has its name, {GAIN}; call that another",
        ),
        (
            axis.states,
            "its friction remembers, and what it remembers need not grow with its forces; give the "
            "gain as the data sheet has it",
        ),
        (
            not drive.is_times_gain,
            f"the force of its drive, {drive.force}, is no multiple of it; give it as the data "
            "sheet has it, or a drive of another formula",
        ),
        (
            not (axis.states or _is_multiple(axis)),
            "its equation of motion has a force of numbers alone, such as that of a rotor's "
            "inertia, which another gain would move; declare the number as a parameter, and say "
            "its value of the record; known NAME=VALUE",
        ),
        before=f"the drive gain of axis {axis.name!r} cannot be free: ",
        code="free",
    )


def _is_multiple(axis: GeneratedAxis) -> bool:
    """Whether all of the force is made by what enters linearly."""
    random = np.random.default_rng(_SEED)
    motion = random.uniform(0.1, 1.0, (3, _MOTIONS))
    recorded = random.uniform(0.1, 1.0, (len(axis.signals), _MOTIONS))
    direction = np.sign(random.uniform(-1.0, 1.0, _MOTIONS))
    motion[1] *= direction
    values = random.uniform(0.5, 1.5, len(axis.nominal)) * np.where(axis.nominal, axis.nominal, 1.0)
    about = () if axis.is_linear else (values,)
    with np.errstate(all="ignore"):
        row, rest = axis.evaluate("idm_regressor", *motion, direction, *recorded, *about)
        force = row @ values + rest[:, 0]
        other = np.abs(force - row @ np.where(axis.nonlinear, 0.0, values))
    finite = np.isfinite(other)
    return bool(np.all(other[finite] <= _SAME * np.abs(force[finite]).max(initial=0.0)))
