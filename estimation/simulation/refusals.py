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
        f"axis {name!r} has no control law, so its closed loop cannot be simulated. Declare one "
        "(the table [control] in TOML, control=... in Python).",
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
    then the optional inputs. The arguments are those of `simulate`, or of `simulate_batch` if
    `many`.

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
    lanes, samples = theta.shape[:many], len(ref) if ref.ndim else 0
    shapes = tuple(dict.fromkeys(((samples,), (samples, *lanes))))
    if (
        theta.shape != (*lanes, len(axis.parameters))
        or ref.shape not in shapes
        or not (ref.size and theta.size and np.isfinite(ref).all())
    ):
        wanted = "(B, p) and (N,) or (N, B)" if many else "(p,) and (N,)"
        raise UsageError(
            f"axis {axis.name!r} has {len(axis.parameters)} parameters "
            f"({', '.join(axis.names)}); the given parameters have the shape {theta.shape}, the "
            f"reference {ref.shape}. Give {wanted}, the reference finite.",
            code="simulation-input",
        )
    # Sampling period, encoder resolution and steps per sample.
    check_sample_period(period)
    law, counts = law_of(axis), is_real(resolution) and 0 <= resolution < math.inf
    if not counts or (resolution and law.continuous):
        raise UsageError(
            f"the resolution is {quoted(resolution)}; give 0 or more, and 0 with a continuous law, "
            "which takes no samples.",
            code="simulation-input",
        )
    check_whole("the substeps", substeps, MOST_SUBSTEPS)
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


def check_whole(what: str, value: int | None, most: int) -> None:
    """Refuse a value that is neither None nor a whole number from 1 to `most`."""
    if value is not None and not (is_whole(value) and 1 <= value <= most):
        raise UsageError(
            f"{what} are {quoted(value)}; give a whole number from 1 to {most}.",
            code="simulation-input",
        )


def contiguous(values: ArrayLike, what: str) -> Array:
    """Return values as a contiguous, aligned float array for compiled loops."""
    return np.require(real_array(values, what), requirements=["C", "A"])


def checked_array(values: ArrayLike, what: str, *shapes: tuple[int, ...]) -> Array:
    """Return values as an array of finite numbers with one of the given shapes.

    Raises
    ------
    UsageError
        The array has another shape, or a number is not finite.
    """
    array = contiguous(values, what)
    if array.shape not in shapes or not np.all(np.isfinite(array)):
        said = f"has the shape {array.shape}" if array.ndim else f"is {array}"
        wanted = " or ".join(str(shape) if shape else "one number" for shape in shapes)
        raise UsageError(f"{what} {said}; give {wanted}, all finite.", code="simulation-input")
    return array


def optional_array(values: ArrayLike | None, what: str, *shapes: tuple[int, ...]) -> Array | None:
    """Return None for None, or values checked by `checked_array`."""
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
        A signal is missing, is not declared, or has another length.
    """
    given = {} if signals is None else signals
    if not isinstance(given, Mapping):
        raise UsageError(
            f"the signals are {quoted(given)}; give arrays by name, such as "
            "{'pressure': values}.",
            code="simulation-input",
        )
    names = [signal.name for signal in axis.signals]
    if {*given} != {*names}:
        missing = ", ".join(name for name in names if name not in given)
        unknown = ", ".join(str(name) for name in given if name not in names)
        raise UsageError(
            f"axis {axis.name!r} has the recorded signals {', '.join(names) or 'none'}; "
            f"{missing and f'not given: {missing}. '}{unknown and f'not declared: {unknown}. '}"
            "Give signals={'name': values} with one value for each sample of the reference.",
            code="simulation-input",
        )
    return tuple(checked_array(given[name], f"the signal {name!r}", *shapes) for name in names)


def gains_by_lane(
    axis: GeneratedAxis, gains: Mapping[str, ArrayLike] | None, lanes: int
) -> Array | None:
    """Return all gains of the law for each lane, (B, g); None if all gains are as declared.

    Raises
    ------
    ModelError
        The axis has no law with variable gains, or the law lacks a given gain.
    UsageError
        The number of values is not the number of lanes, or they are not finite.
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
            said = f"has the shape {values.shape}" if values.shape else f"is {values}"
            if bad.size and values.shape:
                said = f"of lane {bad[0]} is {values.flat[bad[0]]:g}"
            raise UsageError(
                f"the gain {name} {said}; give a finite number{' above 0' * positive}, or one for "
                f"each of {lanes} lanes.",
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
        A mapping has a number for each name, or a number for each lane, (B,).

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
        said = " and ".join(f"{first_of(each)} {what}" for each, what in faults if each)
        raise UsageError(
            f"the parameters of axis {axis.name!r} by name: {said}; give a value for each of "
            f"{', '.join(names)}.",
            code="simulation-input",
        )
    values = {name: real_array(parameters[name], f"the values of {name}") for name in names}
    if len({each.shape for each in values.values()} - {()}) > 1:
        shapes = ", ".join(f"{name} {each.shape}" for name, each in values.items())
        raise UsageError(
            f"the parameters by name have the shapes {shapes}; give each parameter one number, or "
            "one for each lane.",
            code="simulation-input",
        )
    return np.stack(np.broadcast_arrays(*values.values()), axis=-1)


#: Position and velocity, and the recorded signals there.
Place = tuple[tuple[float, float], tuple[float, ...]]

_ROUNDING = 1e-9
_EPSILON = float(np.finfo(float).eps)
#: Force and friction direction: pushed, left alone, held by friction forward and backward.
_PUSHES = np.array([1.0, 0.0, 0.0, 0.0])
_DIRECTIONS = np.array([0.0, 0.0, 1.0, -1.0])


def place_at(signals: Mapping[str, Array], sample: int, recorded: Sequence[Array]) -> Place:
    """Return position, velocity and recorded signals at a sample."""
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
    alone = most == most_substeps(samples)
    whose = f"the most for {samples} samples"
    if not alone:
        whose = "the most that remain after other simulations of the search"
    return EstimationError(
        f"axis {axis.name!r} is too stiff to simulate with {axis.describe(parameters)}: "
        f"{_why(axis, parameters, at, period)} asks for more than {most} steps in a sample, "
        f"{whose}. Check the nominal values and units, or leave so fast a motion out of the model.",
        code="simulation",
    )


def _why(axis: GeneratedAxis, parameters: Array, at: Place, period: float) -> str:
    """Return the cause of short steps as a text: a term and its place, or a general cause."""
    term, rate = stiffest_term(axis.axis, parameters.tolist(), *at)
    if rate * period > 1:
        q, (position, velocity) = axis.coordinate, at[0]
        return (
            f"the term {term} at {q.name} = {position:.4g} {q.unit} and {q.velocity} = "
            f"{velocity:.4g} {q.unit}/s"
        )
    return "its damping, its stiffness or the speed at which it passes a wave of the position"


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
            f"{what} changes the friction direction{or_side} without end {where}; check the "
            "equation of motion there."
        )
    if STATUSES[status] == "unresolved":
        return (
            f"{what} is too fast to follow {where}: a contact is too stiff, or a wave of the "
            f"position too short for the speed; {_why(axis, parameters, at, period)} takes too "
            "many steps. Check the nominal values and units, or leave so fast a motion out of the "
            "model."
        )
    how = "leaves the range" if STATUSES[status] == "out of range" else "is not finite"
    return (
        f"{what} diverges: the position {how} {where}. Check the control law's gains and period, "
        "the drive gain and the nominal values."
    )


def states_refusal(axis: GeneratedAxis, parameters: Array) -> str:
    """Return the error message for parameters (p,) with an invalid friction state, or ""."""
    for part, value_of in state_limits(axis.axis):
        value = value_of(parameters.tolist())
        if not part.allows(value):
            named = "" if part.value.is_Number else f", {part.value},"
            return (
                f"{part.what}{named} is {value:.6g} {part.unit}, with which axis "
                f"{axis.name!r} is not simulated; it must be {part.least}. Correct the "
                "nominal value, or give the fit a bound."
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
        # Four cases per lane: pushed, free, held by friction forward and backward.
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
        # A push has to accelerate the axis. Forward friction must not accelerate it more than
        # backward friction does.
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
    """Return the rate of damping and stiffness at a start, 1/s, after checks of the parameters.

    The rate is 0 if the integrator chooses its steps itself.

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
                f"{p.unit}, so axis {axis.name!r} is not simulated with it: friction beyond "
                "its bounds drives the axis. Give a value within them, or declare others."
            )
    if bounded and not friction_holds:
        raise EstimationError(
            f"the friction of axis {axis.name!r} drives it with {axis.describe(parameters)}: "
            "it would accelerate the axis in the direction of its motion. Check the signs of the "
            "friction."
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
            f"cannot be simulated: its force has no finite value {where}; see the term {term}. "
            "Write a term that is finite wherever the axis can be and at rest: "
            "b*v/(v**2 + v0**2) in place of b/v, a root or logarithm of a positive argument."
        )
    elif abs(force) * _EPSILON > 1:
        why = (
            f"cannot be simulated: its force is {force:.3g} {q.force_unit} {where}, beyond the "
            f"range of any drive; see the term {term}. Correct its factor, its units, or the "
            "parameters in it."
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
