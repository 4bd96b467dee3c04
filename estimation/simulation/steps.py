"""What a simulation checks and settles before it starts, and says when it ends early."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import (
    PHASE_PER_STEP,
    PROBE,
    PROBED,
    RESOLVED,
    STATUSES,
    STEPS_IN_ALL,
    STEPS_OF_EACH,
    STEPS_OF_SEARCH,
    stiffest_term,
)
from axisid.estimation.diagnostic_checks import first_case
from axisid.estimation.thresholds import MAX_STIFFNESS_RATIO, MAX_WAVE_RATIO
from axisid.modeling.derivation import forces_at_rest, state_limits
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError

from .inputs import law_of

#: Position and velocity, and the recorded signals there.
Place = tuple[tuple[float, float], tuple[float, ...]]
Recorded = Sequence[Array] | Array

_SLACK = 1e-6
_HALVED = 0.5 ** np.arange(1.0, 13.0)[:, None]  # parts of a velocity, down to rest
_UNIFORM = 2.0  # times longer may steps be where the rates are the same everywhere
_ROUNDING = 1e-9
_EPSILON = float(np.finfo(float).eps)
MOST_SUBSTEPS = 1024
#: Force and friction direction: pushed, left alone, held by friction forward and backward.
_PUSHES = np.array([1.0, 0.0, 0.0, 0.0])
_DIRECTIONS = np.array([0.0, 0.0, 1.0, -1.0])


def visited_signals(axis: GeneratedAxis) -> tuple[str, ...]:
    """The signals that `substeps_along` looks at."""
    return ("position", "velocity", "force", "direction", *["acceleration"] * bool(axis.states))


def states_refusal(axis: GeneratedAxis, parameters: Array) -> str:
    """What to say of parameters (p,) with which friction cannot remember; empty if it can."""
    for part, value_of in state_limits(axis.axis):
        value = value_of(parameters.tolist())
        if not part.allows(value):
            named = "" if part.value.is_Number else f", {part.value},"
            return (
                f"{part.what}{named} is {value:.6g} {part.unit}, with which axis "
                f"{axis.axis.name!r} is not simulated; it must be {part.least}. Correct the "
                "nominal value, or give a fit a bound."
            )
    return ""


def at_rest(
    axis: GeneratedAxis, parameters: Array, position: Array, recorded: Recorded
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], Array]:
    """What lanes with parameters (B, p) are at rest, (B,) each; recorded signals (s,) or (s, B).

    Returns
    -------
    array of bool
        Which have a positive and finite inertia at their positions, (B,).
    array of bool
        Which have no friction that drives the axis from there.
    array
        Rates of damping and stiffness, 0 where the loop looks for them on its way.
    """
    library = axis.native.evaluator("from_rest")
    if library is None:
        accelerations = _from_rest(axis, parameters, position, recorded)
    else:
        lanes = [np.broadcast_to(values, len(position)) for values in recorded]
        signals = np.array(lanes, dtype=float).reshape(-1, len(position)).T
        accelerations, rates = library.from_rest(
            *map(np.ascontiguousarray, (position, signals, parameters))
        )
    if axis.has_sides:
        rates = np.zeros((len(position), 1))
    elif library is None or axis.states:  # the compiled start has no rates of internal states
        rates = _rates_at_start(axis, parameters, position, recorded)
    with np.errstate(invalid="ignore"):
        push, rest, forward, backward = accelerations.T
        pushed, rounding = push - rest, _ROUNDING * (abs(forward) + abs(backward))
        has_mass = (pushed > 0) & (pushed < np.inf) & np.isfinite(parameters).all(axis=1)
        return has_mass, ~(forward - backward > rounding), rates.max(axis=1)


def _from_rest(
    axis: GeneratedAxis,
    parameters: Array,
    position: Array,
    recorded: Recorded,
) -> Array:
    """Accelerations at rest for each of the cases, (B, 4)."""
    cases, lanes = len(_PUSHES), len(position)
    forces, directions = np.repeat(_PUSHES, lanes), np.repeat(_DIRECTIONS, lanes)
    motion = np.tile(position, cases), np.zeros(len(forces)), forces, directions
    tiled = (np.tile(np.broadcast_to(s, lanes), cases) for s in recorded)
    sets = np.tile(parameters, (cases, 1))
    accelerations = axis.evaluate("direct_dynamics", *motion, *tiled, sets)[0]
    return np.asarray(accelerations.reshape(cases, lanes).T)


def has_constant_substeps(axis: GeneratedAxis) -> bool:
    """Whether no motion asks for more steps than the start does.

    The rates are the same everywhere; or the axis has kinks or jumps over the position, and the
    time loop itself takes as many steps as the motion asks for.
    """
    return axis.uniform or axis.has_sides


def _rates_at_start(
    axis: GeneratedAxis, parameters: Array, start: Array, recorded: Recorded
) -> Array:
    """Rates at rest backward and forward, (B, 2), or of all states together, (B, 1)."""
    lanes = len(start)
    if axis.states:
        still = dict.fromkeys(visited_signals(axis), np.zeros(lanes)) | {"position": start}
        return _rates_with_states(axis, parameters, still)[:, None]
    q, s = np.tile(start, 2), np.repeat([-1.0, 1.0], lanes)
    sets = np.tile(parameters, (2, 1))
    signals = [np.tile(np.broadcast_to(v, lanes), 2) for v in recorded]
    return _probed(axis, q, np.zeros(2 * lanes), s, sets, None, signals).reshape(2, lanes).T


def substeps_along(
    axis: GeneratedAxis,
    parameters: Array,
    visited: Mapping[str, Array],
    period: float,
    recorded: Sequence[Array],
) -> tuple[int, int]:
    """Steps in a sample that resolve the rates wherever a simulation went.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    visited : dict of str to (n,) array
        By `visited_signals`. Where the velocity changes its sign between two
        samples, the axis at rest is looked at too, in both directions.
    period : float
    recorded : sequence of (N,) array
        The recorded signals, of at least as many samples.

    Returns
    -------
    int
    int
        The sample that asks for the shortest.
    """
    q, dq, force = visited["position"], visited["velocity"], visited["force"]
    if not len(q):
        return 1, 0
    looked_at, signals = np.arange(len(q)), [values[: len(q)] for values in recorded]
    if axis.states:
        rates, passing = _rates_with_states(axis, parameters, visited), np.zeros(len(q))
    else:
        turns = np.flatnonzero(dq[:-1] * dq[1:] <= 0)
        rows, speeds = (turns[:0], dq[:0]) if axis.evenly_damped else _between(dq)
        s = np.where(visited["direction"] < 0, -1.0, 1.0)
        looked_at = np.concatenate([looked_at, turns, turns, rows])
        rates = _probed(
            axis,
            q[looked_at],
            np.concatenate([dq, np.zeros(2 * len(turns)), speeds]),
            np.concatenate([s, np.full(len(turns), -1.0), np.ones(len(turns)), np.sign(speeds)]),
            parameters,
            force[looked_at],
            [v[looked_at] for v in signals],
        )
        passing = np.zeros(len(rates))
        passing[: len(q)] = _wave_numbers(axis, q, parameters, signals) * np.abs(dq)
    shortest = np.maximum(_by_rate(axis, rates, period), passing * period / PHASE_PER_STEP).argmax()
    steps = steps_by_rate(axis, rates.max(keepdims=True), period, float(passing.max()))
    return int(steps[0]), int(looked_at[shortest])


def _between(dq: Array) -> tuple[NDArray[np.intp], Array]:
    """Velocities that are passed within a sample, and its row: each the half of the last, (n,).

    So a peak of friction about rest is seen that no sample meets.
    """
    here, there = np.abs(dq[:-1]), np.abs(dq[1:])
    least = np.where(dq[:-1] * dq[1:] > 0, np.minimum(here, there), 0.0)
    rows = np.flatnonzero(np.maximum(here, there) > 2 * least)
    ladder = np.stack([dq[rows], dq[rows + 1]])[:, None] * _HALVED
    passed = np.abs(ladder) > least[rows]
    return np.broadcast_to(rows, ladder.shape)[passed], ladder[passed]


def _wave_numbers(
    axis: GeneratedAxis, q: Array, parameters: Array, signals: Sequence[Array]
) -> Array:
    """Reciprocals of the way on which the acceleration may vary; 0 where it is a polynomial."""
    if "wave_number" not in axis.functions:
        return np.zeros(len(q))
    return axis.evaluate("wave_number", q, *signals, parameters)[0][:, 0]


def _probed(
    axis: GeneratedAxis,
    q: Array,
    dq: Array,
    s: Array,
    parameters: Array,
    force: Array | None,
    signals: Sequence[Array],
) -> Array:
    """Rates of damping and stiffness, from how the acceleration changes over a probe, (n,)."""
    waves = _wave_numbers(axis, q, parameters, signals)
    way = PROBE / (1 + PROBE / PROBED * waves)
    positions = np.concatenate([q, q, q + way])
    speeds = np.concatenate([dq, dq + PROBE, dq])
    directions = np.tile(s, 3)
    sets = parameters if parameters.ndim == 1 else np.tile(parameters, (3, 1))
    with np.errstate(all="ignore"):
        if force is not None and not (law_of(axis).continuous or axis.axis.drives_by_motion):
            tiled = (np.tile(values, 3) for values in signals)
            arguments = (positions, speeds, np.tile(force, 3), directions, *tiled, sets)
            accelerations = axis.evaluate("direct_dynamics", *arguments)[0]
        else:
            held = np.tile(_held(axis, q, signals), (3, 1))  # it stays while positions are probed
            arguments = (positions, speeds, held, directions, sets)
            accelerations = axis.evaluate("held_acceleration", *arguments)[0]
        here, faster, further = accelerations.reshape(3, -1)
        damping, stiffness = np.abs(faster - here) / PROBE, np.abs(further - here) / way
        rates = np.maximum(damping, np.sqrt(stiffness))
    return np.where(np.isfinite(rates), rates, 0.0)


def _rates_with_states(
    axis: GeneratedAxis, parameters: Array, visited: Mapping[str, Array]
) -> Array:
    """Rates of motion and internal states together along a motion, (n,).

    The states are where they start, the force is such that the acceleration is that of the motion.
    Parameters are (p,), or of each place their own, (n, p).
    """
    names = ("position", "velocity", "acceleration", "direction")
    q, dq, ddq, direction = (visited[name] for name in names)
    begin = axis.functions["state_start"]
    states = np.array([begin(own)[0].full().ravel() for own in np.atleast_2d(parameters)])
    held = _held(axis, q, ())
    with np.errstate(all="ignore"):
        forces = axis.evaluate("inverse_dynamics", q, dq, ddq, direction, parameters)[0]
        held[:, 0] = forces[:, 0]
        sets = states if parameters.ndim == 2 else states[0]
        rates = axis.evaluate("plant_rate", q, dq, held, direction, sets, parameters)[0][:, 0]
    return np.where(np.isfinite(rates), rates, 0.0)


def _held(axis: GeneratedAxis, position: Array, signals: Sequence[Array]) -> Array:
    """No force, or the reference of a continuous law at the positions, and signals, (n, size)."""
    size = _held_values(axis)
    held = np.zeros((len(position), size))
    held[:, size - 2 * len(signals) :: 2] = np.transpose(signals)
    law = axis.axis.control
    if law is not None and law.continuous:
        held[:, 0] = position
    return held


@lru_cache(maxsize=64)
def _held_values(axis: GeneratedAxis) -> int:
    """How many numbers are held over a sample; asking CasADi takes long."""
    return int(axis.functions["held_acceleration"].size1_in("held"))


def _by_rate(axis: GeneratedAxis, rates: Array, period: float) -> Array:
    return rates * period / (_UNIFORM * RESOLVED if axis.uniform else RESOLVED)


@dataclass(slots=True)
class StepBudget:
    """Steps that simulations may take together, those of one search: `left` are still to take."""

    left: int = STEPS_OF_SEARCH


def most_substeps(samples: int, left: int = STEPS_IN_ALL) -> int:
    """Steps in a sample, at most, of a simulation of so many samples: a power of 2."""
    each = max(min(left, STEPS_IN_ALL) // samples, STEPS_OF_EACH)
    return int(min(2 ** (each.bit_length() - 1), MOST_SUBSTEPS))


def steps_by_rate(
    axis: GeneratedAxis, rates: Array, period: float, passing: Array | float = 0.0
) -> NDArray[np.int64]:
    """Steps from rates, and from waves of the position that pass, rad/s: powers of 2.

    Powers of 2, so that many lanes fall into few groups; more than `MOST_SUBSTEPS` where even that
    would leave the steps unstable, or blind for the waves.
    """
    by_rate = _by_rate(axis, rates, period)
    by_wave = passing * period / PHASE_PER_STEP
    wanted = np.maximum(by_rate, by_wave)
    wanted = wanted * (1 - _SLACK)  # so that rounding does not decide for round numbers
    powers = np.ceil(np.log2(np.clip(wanted, 1, MOST_SUBSTEPS)))
    beyond = (by_rate > MAX_STIFFNESS_RATIO.value * MOST_SUBSTEPS) | (
        by_wave > MAX_WAVE_RATIO.value * MOST_SUBSTEPS
    )
    return np.where(beyond, 2 * MOST_SUBSTEPS, 2**powers).astype(np.int64)


def checked_rate(
    axis: GeneratedAxis,
    parameters: Array,
    position: float,
    recorded: tuple[float, ...],
    *,
    bounded: bool,
) -> float:
    """The rate of damping and stiffness at a start, 0 where the loop looks for it on its way.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    position : float
    recorded : tuple of float
    bounded : bool
        Whether parameters beyond their bounds are refused, and friction that drives the axis.

    Raises
    ------
    UsageError
        A parameter is beyond a bound.
    EstimationError
        There is no inertia, or no force, friction drives the axis, or a state of friction is
        declared by what cannot be.
    """
    if refusal := states_refusal(axis, parameters):
        raise EstimationError(refusal, code="simulation")
    has_mass, friction_holds, rate = _rest(axis, parameters.tobytes(), position, recorded)
    if not has_mass:
        raise _no_inertia(axis, parameters, position, recorded)
    for p, value in zip(axis.axis.parameters, parameters, strict=True):
        if bounded and not p.allows(value):
            side, bound = ("above", p.upper) if value > p.upper else ("below", p.lower)
            raise UsageError(
                f"{p.name} = {value:.6g} {p.unit} is {side} its declared bound of {bound:g} "
                f"{p.unit}, so axis {axis.axis.name!r} is not simulated with it: friction beyond "
                "its bounds drives the axis. Give a value within them, or declare others."
            )
    if bounded and not friction_holds:
        raise EstimationError(
            f"the friction of axis {axis.axis.name!r} drives it with {axis.describe(parameters)}: "
            "it would accelerate the axis in the direction of its motion. Check the signs of the "
            "friction."
        )
    return rate


def _no_inertia(
    axis: GeneratedAxis, parameters: Array, position: float, recorded: Sequence[float]
) -> EstimationError:
    """The error of a parameter set that no motion starts with: it has no inertia, or no force."""
    q, given = axis.axis.coordinate, axis.describe(parameters)
    forces = forces_at_rest(axis.axis, parameters.tolist(), float(position), recorded)
    # What is no number is the largest.
    term, force = max(forces, key=lambda pair: (math.isnan(pair[1]), abs(pair[1])))
    where = f"at rest at {q.name} = {position:g} {q.unit} with {given}"
    why = first_case(
        (
            not np.isfinite(parameters).all(),
            f"cannot be simulated with {given}. Give finite parameters.",
        ),
        (
            math.isnan(force),
            f"cannot be simulated: its force has no finite value {where}; see the term {term}. "
            "Write one that is finite wherever the axis can be and at rest: "
            "b*v/(v**2 + v0**2) in place of b/v, a root or logarithm of what is positive.",
        ),
        (
            abs(force) * _EPSILON > 1,
            f"cannot be simulated: its force is {force:.3g} {q.force_unit} {where}, beside "
            f"which no drive counts; see the term {term}. Correct its factor, its units, or the "
            "parameters in it.",
        ),
        (
            True,
            f"has no positive inertia with {given}, so it cannot be simulated. Give its inertial "
            "parameters a positive nominal value, or check the signs of force and position in the "
            "record.",
        ),
    )
    return EstimationError(f"axis {axis.axis.name!r} {why}", code="simulation")


@lru_cache(maxsize=64)
def _rest(
    axis: GeneratedAxis, parameters: bytes, position: float, recorded: tuple[float, ...]
) -> tuple[bool, bool, float]:
    """Whether one parameter set has an inertia, whether the friction holds, and the rate there.

    A loop is often simulated again with other noise or reference.
    """
    lane = np.frombuffer(parameters)[None, :], np.array([position])
    has_mass, friction_holds, rates = at_rest(axis, *lane, np.array(recorded))
    return bool(has_mass[0]), bool(friction_holds[0]), float(rates[0])


def place_at(signals: Mapping[str, Array], sample: int, recorded: Sequence[Array]) -> Place:
    """Motion and recorded signals at a sample."""
    motion = (float(signals["position"][sample]), float(signals["velocity"][sample]))
    return motion, tuple(float(values[sample]) for values in recorded)


def too_stiff(
    axis: GeneratedAxis, parameters: Array, at: Place, period: float, samples: int, left: int
) -> EstimationError:
    """The error of a parameter set that `most_substeps` in a sample do not resolve."""
    most = most_substeps(samples, left)
    alone = most == most_substeps(samples)
    whose = "so many samples may take" if alone else "other simulations of its search leave to it"
    return EstimationError(
        f"axis {axis.axis.name!r} is too stiff to simulate with {axis.describe(parameters)}: "
        f"{_why(axis, parameters, at, period)} asks for more than {most} steps in a sample, the "
        f"most that {whose}. Check the nominal values and units, or leave so fast a motion out of "
        "the model.",
        code="simulation",
    )


def _why(axis: GeneratedAxis, parameters: Array, at: Place, period: float) -> str:
    """What asks for short steps: a term, and where; else whatever does."""
    term, rate = stiffest_term(axis.axis, parameters.tolist(), *at)
    if rate * period > 1:
        q, (position, velocity) = axis.axis.coordinate, at[0]
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
    """What happened, where, with which parameters, and what to do."""
    where = f"at sample {sample} ({sample * period:g} s) with {axis.describe(parameters)}"
    what = f"the simulated closed loop of axis {axis.axis.name!r}"
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
