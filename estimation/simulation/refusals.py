"""Checks of the arguments of simulations, and errors of loops that are refused or end early."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import STATUSES, LoopStart, stiffest_term
from axisid.estimation.records import check_sample_period
from axisid.modeling.derivation import forces_at_rest, state_limits
from axisid.support.arrays import Array
from axisid.support.checks import is_real, is_whole, real_array
from axisid.support.errors import EstimationError, ModelError, UsageError
from axisid.support.wording import first_of, quoted

from .integration_steps import MOST_SUBSTEPS, Recorded, most_substeps, rates_at_start
from .loop_inputs import LoopInputs, clocks_of, law_of


def no_control_law(name: str) -> ModelError:
    """Return the error of an axis without a control law."""
    return ModelError(
        f"axis {name!r} has no control law, so its closed loop cannot be simulated. Declare a "
        "control law (the table [control] in TOML, control=... in Python).",
        code="no-control-law",
    )


def checked_loop(
    axis: GeneratedAxis,
    parameters: ArrayLike | Mapping[str, ArrayLike],
    reference: ArrayLike,
    period: float,
    *,
    many: bool = False,
    start: ArrayLike | None = None,
    start_velocity: ArrayLike | None = None,
    memory: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    injected: ArrayLike | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    gains: Mapping[str, ArrayLike] | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
) -> tuple[Array, LoopInputs]:
    """Return checked parameters, (p,) or (B, p), and a loop's inputs at the law's evaluations.

    Parameters and reference are checked first, then period, resolution and steps, then the start,
    then the optional inputs. The arguments are those of `simulate`, or those of `simulate_batch`
    if `many` is True.

    Raises
    ------
    UsageError, ModelError
        As in `simulate` and `simulate_batch`.
    """
    if axis.control is None:
        raise no_control_law(axis.name)
    # Parameters and reference, of one loop or of B lanes.
    given = in_order(axis, parameters)
    theta, ref = contiguous(given, "the parameters"), contiguous(reference, "the reference")
    # Shape of one value for each lane, () for one loop; and shapes of signals.
    lanes = theta.shape[:1] if many else ()
    samples = len(ref) if ref.ndim else 0
    shapes = tuple(dict.fromkeys(((samples,), (samples, *lanes))))
    if (
        theta.shape != (*lanes, len(axis.parameters))
        or ref.shape not in shapes
        or not (ref.size and theta.size and np.isfinite(ref).all())
    ):
        wanted = "(p,) and a finite reference of the shape (N,)"
        if many:
            wanted = "(B, p) and a finite reference of the shape (N,) or (N, B)"
        raise UsageError(
            f"axis {axis.name!r} has {len(axis.parameters)} parameters "
            f"({', '.join(axis.names)}). The given parameters have the shape {theta.shape}, and "
            f"the reference has the shape {ref.shape}. Give parameters of the shape {wanted}.",
            code="simulation-input",
        )
    # Sampling period, encoder resolution and steps per sample.
    check_sample_period(period)
    law, is_step = law_of(axis), is_real(resolution) and 0 <= resolution < math.inf
    if not is_step or (resolution and law.continuous):
        raise UsageError(
            f"the resolution is {quoted(resolution)}. Give 0 or more, and exactly 0 for a "
            "continuous control law, which takes no samples.",
            code="simulation-input",
        )
    check_whole("substeps", substeps, MOST_SUBSTEPS)
    # Start: position, memory of law and drive, velocity.
    begin = ref[0] if start is None else checked_array(start, "the start", lanes)
    if memory is not None:
        response = axis.response
        drive = () if response is None else response.remembered
        names = [*(each.name for each in law.memory), *law.delay_line, *drive]
        what = f"the memory ({', '.join(names) or 'the law has none'})"
        memory = checked_array(memory, what, (*lanes, len(names)))
    velocity = np.zeros(lanes)
    if start_velocity is not None:
        velocity = checked_array(start_velocity, "the start velocity", lanes)
    inputs = LoopInputs(
        reference=ref,
        period=period,
        start=LoopStart(
            position=np.broadcast_to(begin, lanes)[()],
            velocity=velocity[()],
            memory=memory,
        ),
        noise=optional_array(position_noise, "the noise", (samples, *lanes)),
        injected=optional_array(injected, "the injected signal", *shapes),
        signals=checked_signals(axis, signals, shapes),
        gains=gains_by_lane(axis, gains, len(theta)),
        resolution=resolution,
    )
    return theta, inputs.at_law(axis, clocks_of(law, samples, period))


def check_whole(counted: str, value: int | None, most: int) -> None:
    """Refuse a number of `counted` that is neither None nor a whole number from 1 to `most`."""
    if value is not None and not (is_whole(value) and 1 <= value <= most):
        raise UsageError(
            f"the number of {counted} is {quoted(value)}. Give a whole number from 1 to {most}.",
            code="simulation-input",
        )


def contiguous(values: ArrayLike, what: str) -> Array:
    """Return values as a contiguous, aligned float array for compiled loops.

    `what` describes the values in messages, such as ``the reference``.
    """
    return np.require(real_array(values, what), requirements=["C", "A"])


def checked_array(values: ArrayLike, what: str, *shapes: tuple[int, ...]) -> Array:
    """Return values as an array of finite numbers with one of the given shapes.

    `what` describes the values in messages, such as ``the start``.

    Raises
    ------
    UsageError
        The array has another shape, or a number is not finite.
    """
    array = contiguous(values, what)
    if array.shape not in shapes or not np.all(np.isfinite(array)):
        if not array.ndim:
            given = f"is {array}"
        elif array.shape in shapes:
            given = "has values that are not finite"
        else:
            given = f"has the shape {array.shape}"
        wanted = f"finite values of the shape {' or '.join(map(str, shapes))}"
        if () in shapes:
            wanted = "one finite number"
        raise UsageError(f"{what} {given}. Give {wanted}.", code="simulation-input")
    return array


def optional_array(values: ArrayLike | None, what: str, *shapes: tuple[int, ...]) -> Array | None:
    """Return the values as checked by `checked_array`; None for None."""
    return None if values is None else checked_array(values, what, *shapes)


def checked_signals(
    axis: GeneratedAxis,
    signals: Mapping[str, ArrayLike] | None,
    shapes: Sequence[tuple[int, ...]],
) -> tuple[Array, ...]:
    """Return the recorded signals in the order of the axis's declaration, (N,) or (N, B) each.

    Raises
    ------
    UsageError
        A signal is missing, is not declared, has another shape, or has values that are not finite.
    """
    given = {} if signals is None else signals
    if not isinstance(given, Mapping):
        raise UsageError(
            f"the signals are {quoted(given)}. Give arrays by name, such as "
            "{'pressure': values}.",
            code="simulation-input",
        )
    names = [signal.name for signal in axis.signals]
    if {*given} != {*names}:
        missing = ", ".join(name for name in names if name not in given)
        unknown = ", ".join(str(name) for name in given if name not in names)
        sentences = [f"axis {axis.name!r} declares no recorded signals."]
        remedy = "Leave out the argument signals."
        if names:
            sentences = [f"axis {axis.name!r} declares the recorded signals {', '.join(names)}."]
            remedy = (
                "Give signals={'name': values} with one value for each sample of the reference."
            )
        if missing:
            sentences.append(f"These signals are not given: {missing}.")
        if unknown:
            sentences.append(f"These signals are not declared: {unknown}.")
        raise UsageError(" ".join([*sentences, remedy]), code="simulation-input")
    return tuple(checked_array(given[name], f"the signal {name!r}", *shapes) for name in names)


def gains_by_lane(
    axis: GeneratedAxis, gains: Mapping[str, ArrayLike] | None, lanes: int
) -> Array | None:
    """Return all gains of the law for each lane, (B, g); None if all gains are as declared.

    Raises
    ------
    ModelError
        The axis has no law with variable gains, or the law has no gain of a given name.
    UsageError
        A gain has another number of values than lanes, or a value that is not finite or not
        positive where the law requires it.
    """
    if not gains:
        return None
    _, law = axis.loop_with(gains)
    by_lane, names = np.tile([*law.gains.values()], (lanes, 1)), [*law.gains]
    for name, given in gains.items():
        values = real_array(given, f"the gain {name}")
        positive = name in law.positive
        bad = np.flatnonzero(~np.isfinite(values) | (positive & (values <= 0)))
        if values.shape not in ((), (lanes,)) or bad.size:
            if not values.shape:
                given_as = f"is {values}"
            elif bad.size:
                given_as = f"of lane {bad[0]} is {values.flat[bad[0]]:g}"
            else:
                given_as = f"has the shape {values.shape}"
            raise UsageError(
                f"the gain {name} {given_as}. Give a finite number{' above 0' * positive}, or such "
                f"a number for each of the {lanes} lanes.",
                code="simulation-input",
            )
        by_lane[:, names.index(name)] = values
    return by_lane


def in_order(
    axis: GeneratedAxis, parameters: ArrayLike | Mapping[str, ArrayLike]
) -> ArrayLike | Array:
    """Return parameters given by name in the axis's order; an array is returned unchanged.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : array_like or mapping of str to array_like
        A mapping has for each name one number, or one number for each lane, (B,).

    Returns
    -------
    (p,) or (B, p) array

    Raises
    ------
    UsageError
        A name is no parameter, or a parameter is missing.
    """
    if not isinstance(parameters, Mapping):
        return parameters
    names = tuple(p.name for p in axis.axis_parameters)
    if {*parameters} != {*names}:
        unknown = [quoted(name) for name in parameters if name not in names]
        missing = [name for name in names if name not in parameters]
        faults = ((unknown, "is no parameter"), (missing, "is missing"))
        wrong = " and ".join(f"{first_of(each)} {what}" for each, what in faults if each)
        raise UsageError(
            f"the parameters of axis {axis.name!r} are given by name, but {wrong}. Give a value "
            f"for each of {', '.join(names)}.",
            code="simulation-input",
        )
    values = {name: real_array(parameters[name], f"the values of {name}") for name in names}
    if len({each.shape for each in values.values()} - {()}) > 1:
        shapes = ", ".join(f"{name} {each.shape}" for name, each in values.items())
        raise UsageError(
            f"the parameters by name have the shapes {shapes}. Give one number for each "
            "parameter, or one number for each lane.",
            code="simulation-input",
        )
    return np.stack(np.broadcast_arrays(*values.values()), axis=-1)


#: State of an axis in messages: position and velocity, and the recorded signals at that sample.
Place = tuple[tuple[float, float], tuple[float, ...]]

_ROUNDING = 1e-9  # relative to accelerations
_EPSILON = float(np.finfo(float).eps)
#: Force and friction direction of four cases: with a force of 1, without force, without force under
#: forward friction, and without force under backward friction.
_PUSHES = np.array([1.0, 0.0, 0.0, 0.0])
_DIRECTIONS = np.array([0.0, 0.0, 1.0, -1.0])


def place_at(signals: Mapping[str, Array], sample: int, recorded: Sequence[Array]) -> Place:
    """Return position, velocity and recorded signals at a sample of a simulation."""
    motion = (float(signals["position"][sample]), float(signals["velocity"][sample]))
    return motion, tuple(float(values[sample]) for values in recorded)


def too_stiff(
    axis: GeneratedAxis, parameters: Array, at: Place, period: float, samples: int, left: int
) -> EstimationError:
    """Return the error of a parameter set that needs more steps per sample than allowed.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    at : Place
        Position, velocity and recorded signals at which the most steps are needed.
    period : float
        Sampling period, s.
    samples, left : int
        Samples of the simulation, and remaining steps of the search.
    """
    most = most_substeps(samples, left)
    limit = f"the largest number for {samples} samples"
    if most < most_substeps(samples):
        limit = "the largest number that remains after the other simulations of the search"
    return EstimationError(
        f"axis {axis.name!r} is too stiff to simulate with {axis.describe(parameters)}: "
        f"{_why(axis, parameters, at, period)} requires more than {most} steps per sample, "
        f"{limit}. Check the nominal values and units, or remove the fast motion from the model.",
        code="simulation",
    )


def _why(axis: GeneratedAxis, parameters: Array, at: Place, period: float) -> str:
    """Return the cause of short steps as text: the stiffest term, and position and velocity there.

    If no term of the model alone needs short steps, the text is a general one.
    """
    term, rate = stiffest_term(axis.axis, parameters.tolist(), *at)
    if rate * period > 1:
        q, (position, velocity) = axis.coordinate, at[0]
        return (
            f"the term {term} at {q.name} = {position:.4g} {q.unit} and {q.velocity} = "
            f"{velocity:.4g} {q.unit}/s"
        )
    return "its damping, its stiffness or the speed at which it passes a wave over the position"


def failure(
    axis: GeneratedAxis,
    parameters: Array,
    status: int,
    sample: int,
    period: float,
    at: Place,
) -> str:
    """Return the error message of a loop that ended early, with sample, parameters and remedy.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    status, sample : int
        Index in `STATUSES`, and the sample at which the loop ended.
    period : float
        Sampling period, s.
    at : Place
        Position, velocity and recorded signals at that sample.
    """
    where = f"at sample {sample} ({sample * period:g} s) with {axis.describe(parameters)}"
    what = f"the simulated closed loop of axis {axis.name!r}"
    if STATUSES[status] == "chatter":
        or_side = ", or the side of a kink or jump over the position," if axis.has_sides else ""
        return (
            f"{what} changes the friction direction{or_side} without end {where}. Check the "
            "equation of motion there."
        )
    if STATUSES[status] == "unresolved":
        return (
            f"{what} is too fast to follow {where}: a contact is too stiff, or a wave over the "
            "position is too short for the speed. Too many steps are required by "
            f"{_why(axis, parameters, at, period)}. Check the nominal values and units, or remove "
            "the fast motion from the model."
        )
    how = "leaves the range" if STATUSES[status] == "out of range" else "is not finite"
    return (
        f"{what} diverges: the position {how} {where}. Check the control law's gains and period, "
        "the drive gain and the nominal values."
    )


def states_refusal(axis: GeneratedAxis, parameters: Array) -> str:
    """Return the error message for parameters (p,) that make a friction state invalid.

    Empty if the parameters are valid.
    """
    for part, value_of in state_limits(axis.axis):
        value = value_of(parameters.tolist())
        if not part.allows(value):
            named = "" if part.value.is_Number else f", {part.value},"
            return (
                f"{part.what}{named} is {value:.6g} {part.unit}, but it must be {part.least} for "
                f"a simulation of axis {axis.name!r}. Correct the nominal value, or give the fit a "
                "bound."
            )
    return ""


def at_rest(
    axis: GeneratedAxis, parameters: Array, position: Array, recorded: Recorded
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], Array]:
    """Return inertia check, friction check and rates of lanes at rest, (B,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    position : (B,) array
        Position of each lane.
    recorded : (s,) or (s, B) array
        Recorded signals, for all lanes or for each lane.

    Returns
    -------
    array of bool
        True for lanes with a positive and finite inertia at their positions.
    array of bool
        True for lanes whose friction does not drive the axis.
    array
        Rates of damping and stiffness, 1/s; 0 if the integrator chooses its steps itself.
    """
    library = axis.native.evaluator("from_rest")
    if library is None:
        # Accelerations of each lane in the four cases of `_PUSHES` and `_DIRECTIONS`.
        cases, count = len(_PUSHES), len(position)
        forces, directions = np.repeat(_PUSHES, count), np.repeat(_DIRECTIONS, count)
        motion = np.tile(position, cases), np.zeros(len(forces)), forces, directions
        tiled = (np.tile(np.broadcast_to(s, count), cases) for s in recorded)
        sets = np.tile(parameters, (cases, 1))
        rows = axis.evaluate("direct_dynamics", *motion, *tiled, sets)[0]
        accelerations = rows.reshape(cases, count).T
    else:
        lanes = [np.broadcast_to(values, len(position)) for values in recorded]
        signals = np.array(lanes, dtype=float).reshape(-1, len(position)).T
        accelerations, rates = library.from_rest(
            *map(np.ascontiguousarray, (position, signals, parameters))
        )
    if axis.has_sides:
        rates = np.zeros((len(position), 1))
    elif library is None or axis.states:  # the compiled start has no rates of internal states
        rates = rates_at_start(axis, parameters, position, recorded)
    with np.errstate(invalid="ignore"):
        push, rest, forward, backward = accelerations.T
        # A force of 1 has to accelerate the axis. Forward friction must not accelerate the axis
        # more than backward friction does.
        pushed, rounding = push - rest, _ROUNDING * (abs(forward) + abs(backward))
        has_mass = (pushed > 0) & (pushed < np.inf) & np.isfinite(parameters).all(axis=1)
        return has_mass, ~(forward - backward > rounding), rates.max(axis=1)


def checked_rate(
    axis: GeneratedAxis,
    parameters: Array,
    position: float,
    recorded: tuple[float, ...],
    *,
    bounded: bool,
) -> float:
    """Return the rate of damping and stiffness at the start of a loop, 1/s, for checked parameters.

    Parameters with which the loop cannot start are refused. The rate is 0 if the integrator chooses
    its steps itself.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    position : float
        Position at the start.
    recorded : tuple of float
        Recorded signals at the start.
    bounded : bool
        True if parameters beyond their bounds, and friction that drives the axis, are refused.

    Raises
    ------
    UsageError
        A parameter is beyond a bound.
    EstimationError
        The inertia is not positive, the force has no finite value, friction drives the axis, or a
        parameter of a friction state is not valid.
    """
    if refusal := states_refusal(axis, parameters):
        raise EstimationError(refusal, code="simulation")
    has_mass, friction_holds, rate = _rest(axis, parameters.tobytes(), position, recorded)
    if not has_mass:
        raise _no_inertia(axis, parameters, position, recorded)
    for p, value in zip(axis.axis_parameters, parameters, strict=True):
        if bounded and not p.allows(value):
            side, bound = ("above", p.upper) if value > p.upper else ("below", p.lower)
            raise UsageError(
                f"{p.name} = {value:.6g} {p.unit} is {side} its declared bound of {bound:g} "
                f"{p.unit}. Axis {axis.name!r} is not simulated with this value, because friction "
                "beyond its bounds drives the axis. Give a value within the bounds, or declare "
                "other bounds."
            )
    if bounded and not friction_holds:
        raise EstimationError(
            f"the friction of axis {axis.name!r} drives the axis with "
            f"{axis.describe(parameters)}: the friction would accelerate the axis in the direction "
            "of motion. Check the signs of the friction parameters."
        )
    return rate


def _no_inertia(
    axis: GeneratedAxis, parameters: Array, position: float, recorded: Sequence[float]
) -> EstimationError:
    """Return the error of a parameter set without a positive inertia or a finite force."""
    q, given = axis.coordinate, axis.describe(parameters)
    forces = forces_at_rest(axis.axis, parameters.tolist(), float(position), recorded)
    # A force that is not a number counts as the largest.
    term, force = max(forces, key=lambda pair: (math.isnan(pair[1]), abs(pair[1])))
    where = f"at rest at {q.name} = {position:g} {q.unit} with {given}"
    if not np.isfinite(parameters).all():
        why = f"cannot be simulated with {given}. Give finite parameters."
    elif math.isnan(force):
        why = (
            f"cannot be simulated: its force has no finite value {where}. See the term {term}. "
            "Write a term that is finite wherever the axis can be and at rest: "
            "b*v/(v**2 + v0**2) in place of b/v, a root or logarithm of a positive argument."
        )
    elif abs(force) * _EPSILON > 1:
        why = (
            f"cannot be simulated: its force is {force:.3g} {q.force_unit} {where}, beyond the "
            f"range of any drive. See the term {term}. Correct its factor, its units, or its "
            "parameters."
        )
    else:
        why = (
            f"has no positive inertia with {given}, so it cannot be simulated. Give its inertial "
            "parameters a positive nominal value, or check the signs of force and position in the "
            "record."
        )
    return EstimationError(f"axis {axis.name!r} {why}", code="simulation")


@lru_cache(maxsize=64)
def _rest(
    axis: GeneratedAxis, parameters: bytes, position: float, recorded: tuple[float, ...]
) -> tuple[bool, bool, float]:
    """Return `at_rest` of one parameter set: inertia check, friction check and rate in 1/s.

    Cached, as a loop is often simulated again with other noise or another reference.
    """
    lane = np.frombuffer(parameters)[None, :], np.array([position])
    has_mass, friction_holds, rates = at_rest(axis, *lane, np.array(recorded))
    return bool(has_mass[0]), bool(friction_holds[0]), float(rates[0])
