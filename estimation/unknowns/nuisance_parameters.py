"""Nuisance parameters of a search: initial states of loops, gains, and a time of the drive.

A record shows the initial state of its loop with noise: the initial position is one sample, and the
initial velocity is that of a parabola through the first samples. A search may free both for each
stretch, that is, for each segment of a record. The memory of the law at the start depends on the
signals that the law read, which the record has.

A loop with another drive gain g equals that with the declared gain g0 with every force multiplied
by g0/g: parameters that enter linearly are searched with their true values, and multiplied by g0/g
for the simulation.
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
from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.settings import setting

from .joint_parameters import GAIN, JointForm, drive_gain_of

#: Names of the parameters of an initial state, and the name that frees both.
INITIAL_STATE_PARAMETERS, START = ("start_position", "start_velocity"), "start"
_SIZE = 1e-2  # smallest scale of an initial state, relative to position range and mean speed

_NEXT_TO_0 = 1e-9  # smallest gain, relative to the declared gain
_MOTIONS, _SEED = 64, 0  # random motions on which the linearity of the force is tested
_SAME = 1e-9  # difference of forces, relative to the largest force, that is rounding


@dataclass(frozen=True, slots=True)
class ExtendedForm(InverseForm):
    """A form with nuisance parameters after the physical parameters of the model.

    The nuisance parameters are in the order of the attributes; a search starts from their nominal
    values. The regression is not linear in them.

    Attributes
    ----------
    of_model : Form
        Form of the model's parameters.
    axes : tuple of GeneratedAxis
        Axis of each record.
    drive_gain : tuple of Parameter
        The drive's gain, with the declared value as nominal value.
    gains : tuple of Parameter
        Gains of the law, equal for all records.
    starts : mapping of (int, int) to mapping of str to Parameter
        Free initial positions and velocities of each stretch, by record and segment, then by name
        in `INITIAL_STATE_PARAMETERS`.
    start_sizes : tuple of float
        Smallest scales of the initial states, for steps.
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
        """All nuisance parameters, in their order after the parameters of the model."""
        starts = (p for start in self.starts.values() for p in start.values())
        return (*self.drive_gain, *self.gains, *starts, *self.time)

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """Parameters of the model, then the nuisance parameters, length P."""
        more = (Quantity(name=p.name, unit="" if p.unit == "1" else p.unit) for p in self.more)
        return (*self.of_model.physical_quantities, *more)

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """All parameters with their bounds, length P."""
        return (*self.of_model.declared, *self.more)

    @property
    def start(self) -> Array:
        """Start values of all parameters, (P,)."""
        return np.append(self.of_model.start, [float(p.nominal or 0.0) for p in self.more])

    def own(self, physical: Array, record: int) -> Array:
        """Return the parameters of one record's axis, (b,), for all parameters (P,).

        With a free drive gain, the returned parameters give the same motion with the declared gain,
        see `by_declared_gain`.
        """
        count = len(self.of_model.physical_quantities)
        own = self.of_model.own(physical[:count], record)
        if not self.drive_gain:
            return own
        return by_declared_gain(self.axes[record], own, float(physical[count]))

    @property
    def place_of_gains(self) -> slice:
        """Slice of the law's gains among all parameters; initial states follow."""
        first = len(self.of_model.physical_quantities) + len(self.drive_gain)
        return slice(first, first + len(self.gains))

    @property
    def local(self) -> dict[str, tuple[str, ...]]:
        """Names of each local parameter by record.

        Initial states are included if there are several records of one stretch each.
        """
        found = dict(self.of_model.local) if isinstance(self.of_model, JointForm) else {}
        every = [*self.starts.values()]
        if len(every) > 1 and not any(segment for _, segment in self.starts):
            found |= {name: tuple(each[name].name for each in every) for name in every[0]}
        return found

    def with_drive_gain(self) -> "ExtendedForm":
        """Return the form with a free drive gain; unchanged if a known force identifies the gain.

        A declared relative standard deviation of the gain is a prior.

        Raises
        ------
        ModelError
            The force of the drive, or of the axis, is not proportional to the free parameters.
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
        """Return the form with free gains of the law, equal for all records.

        No gain changes its sign.

        Raises
        ------
        ModelError
            The axis has no law with variable gains, or the law lacks a given gain.
        """
        free = tuple(dict.fromkeys(names))
        law, *_ = [axis.loop_with(free)[1] for axis in self.axes]  # each axis is checked
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
        """Return the form with free initial states of all stretches of the records.

        Parameters
        ----------
        records : sequence of Record
        asked : sequence of str
            Names of `INITIAL_STATE_PARAMETERS`, or `START` for both.
        """
        names = [name for name in INITIAL_STATE_PARAMETERS if START in asked or name in asked]
        stretches = [
            (index, segment, start)
            for index, (axis, record) in enumerate(zip(self.axes, records, strict=True))
            for segment, start in enumerate(loop_starts(axis, record))
        ]
        taken = {quantity.name.lower() for quantity in self.physical_quantities}
        q = self.axes[0].axis.coordinate
        found, sizes = dict[tuple[int, int], dict[str, Parameter]](), list[float]()
        for number, (index, segment, start) in enumerate(stretches, 1):
            suffix = f"_{number}" if len(stretches) > 1 else ""
            # Smallest scales from the range of positions and the mean speed of the stretch.
            record = records[index]
            position = record.position[slice(*record.spans[segment])]
            reach = float(np.ptp(position)) or 1.0
            speed = reach / (record.period * len(position))  # of a motion in one direction
            if len(position) > 1:
                speed = max(float(np.abs(np.diff(position)).mean()) / record.period, speed)
            both = zip(
                INITIAL_STATE_PARAMETERS,
                (q.unit, q.velocity_unit),
                (start.position, start.velocity),
                (_SIZE * reach, _SIZE * speed),
                strict=True,
            )
            chosen = [each for each in both if each[0] in names]
            found[index, segment] = {
                name: Parameter(fresh_name(name + suffix, taken), str(unit), nominal=float(value))
                for name, unit, value, _ in chosen
            }
            sizes += [size for *_, size in chosen]
        return replace(self, starts=found, start_sizes=tuple(sizes))


def least_sizes(form: Form) -> Array:
    """Return the smallest scale of each parameter for the steps of a search, (P,).

    It is 0 except for initial states.
    """
    sizes = np.zeros(len(form.physical_quantities))
    if isinstance(form, ExtendedForm):
        first = form.place_of_gains.stop
        sizes[first : first + len(form.start_sizes)] = form.start_sizes
    return sizes


def started_at(
    form: Form, physical: Array, record: int, segment: int, inputs: LoopInputs
) -> LoopInputs:
    """Return the inputs of a stretch with the initial state that parameters (P,) or (B, P) give.

    The stretch is a segment of a record, both by their index. Inputs are unchanged if initial
    states are not free.
    """
    if not (isinstance(form, ExtendedForm) and form.starts):
        return inputs
    names = form.starts[record, segment]
    # The initial states of all stretches follow the gains.
    first = form.place_of_gains.stop + [*form.starts].index((record, segment)) * len(names)
    values = dict(zip(names, np.moveaxis(physical, -1, 0)[first:], strict=False))
    start = replace(
        inputs.start,
        **{name.removeprefix("start_"): value for name, value in values.items()},
    )
    return replace(inputs, start=start)


def gains_in(form: Form, physical: Array) -> dict[str, Array]:
    """Return the free law gains of parameters (P,) or (B, P), by name.

    A gain that must be positive, such as a time, stays slightly above 0 if a search steps to 0.
    """
    if not (isinstance(form, ExtendedForm) and form.gains):
        return {}
    names = [p.name for p in form.gains]
    law = form.axes[0].loop_with(names)[1]
    least = [_NEXT_TO_0 * law.gains[n] if n in law.positive else -np.inf for n in names]
    values = np.maximum(physical[..., form.place_of_gains], least)
    return dict(zip(names, np.moveaxis(values, -1, 0), strict=True))


def axis_at(axis: GeneratedAxis, form: Form, physical: Array) -> GeneratedAxis:
    """Return the axis of a record with the law gains that parameters (P,) give.

    The axis is unchanged if gains are not free.
    """
    gains = gains_in(form, physical)
    if not gains:
        return axis
    return _with_gains(axis, tuple((name, float(value)) for name, value in gains.items()))


# Most lanes of a step have the same gains, and other parameters.
@lru_cache(maxsize=64)
def _with_gains(axis: GeneratedAxis, gains: tuple[tuple[str, float], ...]) -> GeneratedAxis:
    """Return the axis with other gains of its law, by name."""
    return axis.with_gains(dict(gains))


def inputs_at(axis: GeneratedAxis, record: Record, segment: int, inputs: LoopInputs) -> LoopInputs:
    """Return the inputs of a loop with the memory of the axis's law at the start of a segment.

    The memory depends on the gains of the law. `segment` is the index of the segment.
    """
    memory = loop_starts(axis, record)[segment].memory
    if memory is None:  # the declared memory of an axis at rest
        first = (float(values[0]) for values in inputs.signals)
        measured = float(np.ravel(inputs.start.position)[0])
        state = axis.functions["control_start"](float(inputs.reference[0]), measured, *first)
        memory = np.asarray(state.full().ravel())
    return replace(inputs, start=replace(inputs.start, memory=memory))


def by_declared_gain(axis: GeneratedAxis, physical: Array, gain: float) -> Array:
    """Return the parameters (p,) that with the declared gain give the motion of another gain.

    Linear parameters are multiplied by ``g0/g`` of the declared and the other gain.
    """
    declared = float(axis.drive.gain)
    least = np.copysign(_NEXT_TO_0 * declared, declared)
    used = max(gain, least) if declared > 0 else min(gain, least)
    return np.where(axis.nonlinear, physical, physical * (declared / used))


def _check_gain(axis: GeneratedAxis, names: Sequence[str]) -> None:
    """Refuse a free drive gain if the force is not proportional to the free parameters.

    Parameters
    ----------
    axis : GeneratedAxis
    names : sequence of str
        Names of the free parameters.
    """
    drive = axis.drive
    refuse(
        ModelError,
        (
            GAIN in names,
            f"a parameter of the axis is also named {GAIN}. Rename this parameter",
        ),
        (
            axis.states,
            "the friction has an internal state, which need not scale with the forces. Declare the "
            "gain of the data sheet",
        ),
        (
            not drive.is_times_gain,
            f"the force of the drive, {drive.force}, is not proportional to the gain. Declare the "
            "gain of the data sheet, or a drive with another formula",
        ),
        (
            not (axis.states or _is_proportional(axis)),
            "the equation of motion has a force without parameters, such as the inertial force of "
            "a rotor of known inertia, and this force would change with the gain. Declare the "
            "number as a parameter, and give its value for the record: "
            f"{setting('known', {'NAME': ('VALUE',)})}",
        ),
        before=f"the drive gain of axis {axis.name!r} cannot be free: ",
        code="free",
    )


def _is_proportional(axis: GeneratedAxis) -> bool:
    """Return True if the force is proportional to the parameters that enter linearly.

    The force at random motions and parameters is compared with the sum of the terms of these
    parameters.
    """
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
