"""Numerical settings of simulated loops: steps per sample, and allowed distance to the reference.

The number of Runge-Kutta steps follows from damping, stiffness and wavelengths over the position.
The allowed distance is a multiple of the commanded travel: that of the reference, and that from the
start to the reference. If this is almost zero, the axis is moved by noise and encoder steps, and by
the load at the start, to which the loop yields until its control holds it.
"""

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
    STEPS_IN_ALL,
    STEPS_OF_EACH,
    STEPS_OF_SEARCH,
    LoopSettings,
)
from axisid.estimation.thresholds import MAX_STIFFNESS_RATIO, MAX_WAVE_RATIO
from axisid.support.arrays import Array

from .loop_inputs import LoopInputs, law_of

#: Recorded signals at one sample, each one value for all lanes or a value for each lane.
Recorded = Sequence[Array] | Array

_SLACK = 1e-6  # relative tolerance for rounding of a number of steps
_HALVED = 0.5 ** np.arange(1.0, 13.0)[:, None]  # fractions of a velocity, down to rest
_UNIFORM = 2.0  # factor of longer steps if the rates are equal everywhere
#: Largest number of integration steps per sample.
MOST_SUBSTEPS = 1024


def visited_signals(axis: GeneratedAxis) -> tuple[str, ...]:
    """Return the names of the simulated signals from which `substeps_along` chooses the steps."""
    names = ("position", "velocity", "force", "direction")
    if axis.states:
        return (*names, "acceleration")
    return names


def has_constant_substeps(axis: GeneratedAxis) -> bool:
    """Return True if no motion needs more steps than the start.

    There are two such cases: the rates are equal everywhere; or the axis has kinks or jumps over
    the position, and the integrator itself chooses the steps along the motion.
    """
    return axis.uniform or axis.has_sides


def rates_at_start(
    axis: GeneratedAxis, parameters: Array, start: Array, recorded: Recorded
) -> Array:
    """Return the rates of the motion at rest, 1/s, (B, 2): backward, then forward.

    A rate states how fast the motion changes by itself, and so how short the integration steps must
    be. There is one rate for the friction of each direction: the larger of the rate by damping and
    the rate by stiffness of the motion linearised at rest, see `_probed`. For friction with
    internal state there is one rate for both directions, (B, 1), see `_rates_with_states`.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    start : (B,) array
        Positions of the lanes.
    recorded : sequence of array
        Recorded signals, one value or (B,) each.
    """
    lanes = len(start)
    if axis.states:
        still = dict.fromkeys(visited_signals(axis), np.zeros(lanes)) | {"position": start}
        return _rates_with_states(axis, parameters, still)[:, None]
    # All lanes with backward friction, then all lanes with forward friction.
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
    """Return the steps per sample that resolve a simulated motion, and the sample that decides.

    The steps resolve the rates of damping and stiffness, and the waves of the acceleration over the
    position at the speed with which they are passed.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    visited : dict of str to (n,) array
        Simulated signals by the names of `visited_signals`. If the velocity changes its sign
        between two samples, the rates at rest are included, in both directions.
    period : float
        Sampling period, s.
    recorded : sequence of (N,) array
        The recorded signals, with at least n samples.

    Returns
    -------
    int
        Steps per sample.
    int
        The sample that needs the shortest steps.
    """
    q, dq, force = visited["position"], visited["velocity"], visited["force"]
    if not len(q):
        return 1, 0
    looked_at, signals = np.arange(len(q)), [values[: len(q)] for values in recorded]
    if axis.states:
        rates, passing = _rates_with_states(axis, parameters, visited), np.zeros(len(q))
    else:
        # Probe all samples, rest in both directions at reversals, and velocities between samples.
        turns = np.flatnonzero(dq[:-1] * dq[1:] <= 0)
        if axis.evenly_damped:
            rows, speeds = turns[:0], dq[:0]  # no velocity in between has another rate
        else:
            rows, speeds = _velocities_between(dq)
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


def _velocities_between(dq: Array) -> tuple[NDArray[np.intp], Array]:
    """Return samples after which a velocity is passed, and the velocities, (n,) each.

    Between two samples, the velocities are a half, a quarter, and so on, of the velocity of each
    sample, down to the smaller of the two. So a friction peak at low velocity that is passed
    between samples is included.
    """
    here, there = np.abs(dq[:-1]), np.abs(dq[1:])
    least = np.where(dq[:-1] * dq[1:] > 0, np.minimum(here, there), 0.0)  # 0 at a reversal
    rows = np.flatnonzero(np.maximum(here, there) > 2 * least)
    ladder = np.stack([dq[rows], dq[rows + 1]])[:, None] * _HALVED
    passed = np.abs(ladder) > least[rows]
    return np.broadcast_to(rows, ladder.shape)[passed], ladder[passed]


def _wave_numbers(
    axis: GeneratedAxis, q: Array, parameters: Array, signals: Sequence[Array]
) -> Array:
    """Return the largest wave number of the acceleration over the position, at each position, (n,).

    It is 0 for a polynomial in the position.
    """
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
    """Return the rate of damping and stiffness at each of n states, 1/s, (n,).

    It is ``max(|da/dv|, sqrt(|da/dq|))`` of the acceleration a: the rate by damping, and that by
    stiffness. The derivatives are differences: the acceleration is evaluated at each state, and
    again with a slightly larger velocity and a slightly larger position. The rate is 0 if it is not
    finite.

    Parameters
    ----------
    axis : GeneratedAxis
    q, dq, s : (n,) array
        Position, velocity and friction direction.
    parameters : (p,) or (n, p) array
    force : (n,) array or None
        Force of the drive; None for the inputs that the plant holds at rest, see `_held_inputs`.
    signals : sequence of (n,) array
        Recorded signals.
    """
    # Each state, then the state with a larger velocity, then that with a larger position.
    waves = _wave_numbers(axis, q, parameters, signals)
    way = PROBE / (1 + PROBE / PROBED * waves)
    positions = np.concatenate([q, q, q + way])
    speeds = np.concatenate([dq, dq + PROBE, dq])
    directions = np.tile(s, 3)
    sets = parameters if parameters.ndim == 1 else np.tile(parameters, (3, 1))
    with np.errstate(all="ignore"):
        if force is not None and not (law_of(axis).continuous or axis.drives_by_motion):
            tiled = (np.tile(values, 3) for values in signals)
            arguments = (positions, speeds, np.tile(force, 3), directions, *tiled, sets)
            accelerations = axis.evaluate("direct_dynamics", *arguments)[0]
        else:
            # Constant while the position is varied.
            held = np.tile(_held_inputs(axis, q, signals), (3, 1))
            arguments = (positions, speeds, held, directions, sets)
            accelerations = axis.evaluate("held_acceleration", *arguments)[0]
        here, faster, further = accelerations.reshape(3, -1)
        damping, stiffness = np.abs(faster - here) / PROBE, np.abs(further - here) / way
        rates = np.maximum(damping, np.sqrt(stiffness))
    return np.where(np.isfinite(rates), rates, 0.0)


def _rates_with_states(
    axis: GeneratedAxis, parameters: Array, visited: Mapping[str, Array]
) -> Array:
    """Return the largest rate of motion and internal states at each sample, 1/s, (n,).

    The internal states have their initial values, and the force is that which gives the
    acceleration of the motion.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) or (n, p) array
        Parameters of all samples, or of each sample.
    visited : dict of str to (n,) array
        Signals of the motion by the names of `visited_signals`.
    """
    names = ("position", "velocity", "acceleration", "direction")
    q, dq, ddq, direction = (visited[name] for name in names)
    begin = axis.functions["state_start"]
    states = np.array([begin(own)[0].full().ravel() for own in np.atleast_2d(parameters)])
    held = _held_inputs(axis, q, ())
    with np.errstate(all="ignore"):
        forces = axis.evaluate("inverse_dynamics", q, dq, ddq, direction, parameters)[0]
        held[:, 0] = forces[:, 0]
        sets = states if parameters.ndim == 2 else states[0]
        rates = axis.evaluate("plant_rate", q, dq, held, direction, sets, parameters)[0][:, 0]
    return np.where(np.isfinite(rates), rates, 0.0)


def _held_inputs(axis: GeneratedAxis, position: Array, signals: Sequence[Array]) -> Array:
    """Return the inputs that the plant holds between samples, for an axis on its reference, (n, h).

    The first input is a force of 0; under a continuous law it is the reference, which is equal to
    the position. The last inputs are value and rate of change of each recorded signal; the rate
    is 0.
    """
    size = _held_size(axis)
    held = np.zeros((len(position), size))
    held[:, size - 2 * len(signals) :: 2] = np.transpose(signals)
    law = axis.control
    if law is not None and law.continuous:
        held[:, 0] = position
    return held


@lru_cache(maxsize=64)
def _held_size(axis: GeneratedAxis) -> int:
    """Return the number of inputs that the plant holds; cached, as the query of CasADi is slow."""
    return int(axis.functions["held_acceleration"].size1_in("held"))


def _by_rate(axis: GeneratedAxis, rates: Array, period: float) -> Array:
    """Return the number of steps per sample that rates in 1/s need, as a fractional number."""
    return rates * period / (_UNIFORM * RESOLVED if axis.uniform else RESOLVED)


@dataclass(slots=True)
class StepBudget:
    """Remaining integration steps of the simulations of one search (`left`)."""

    left: int = STEPS_OF_SEARCH


def most_substeps(samples: int, left: int = STEPS_IN_ALL) -> int:
    """Return the largest allowed number of steps per sample, a power of 2.

    Parameters
    ----------
    samples : int
        Samples of the simulation.
    left : int
        Remaining steps of the search.
    """
    each = max(min(left, STEPS_IN_ALL) // samples, STEPS_OF_EACH)
    return int(min(2 ** (each.bit_length() - 1), MOST_SUBSTEPS))


def steps_by_rate(
    axis: GeneratedAxis, rates: Array, period: float, passing: Array | float = 0.0
) -> NDArray[np.int64]:
    """Return the steps per sample, powers of 2, for rates in 1/s and passing waves in rad/s.

    A passing wave is the wave number of the force over the position, times the speed.

    Powers of 2 put many lanes into few groups. The result exceeds `MOST_SUBSTEPS` if even that
    number would be unstable or would not resolve the waves.
    """
    by_rate = _by_rate(axis, rates, period)
    by_wave = passing * period / PHASE_PER_STEP
    wanted = np.maximum(by_rate, by_wave)
    wanted = wanted * (1 - _SLACK)  # so that rounding does not raise exact powers of 2
    powers = np.ceil(np.log2(np.clip(wanted, 1, MOST_SUBSTEPS)))
    beyond = (by_rate > MAX_STIFFNESS_RATIO.value * MOST_SUBSTEPS) | (
        by_wave > MAX_WAVE_RATIO.value * MOST_SUBSTEPS
    )
    return np.where(beyond, 2 * MOST_SUBSTEPS, 2**powers).astype(np.int64)


_RUNAWAY_RATIO = 100.0  # allowed distance from the reference, relative to the commanded travel
_OFF = 1e-6  # offset of the reference from the position for the stiffness of the loop


def loop_settings(inputs: LoopInputs, substeps: int) -> LoopSettings:
    """Return the numerical settings of loops with a number of steps per sample.

    A loop has diverged beyond 100 times the commanded travel.
    """
    away = np.abs(inputs.start.position - inputs.reference[0])
    most = _RUNAWAY_RATIO * np.maximum(np.ptp(inputs.reference, axis=0), away)
    return LoopSettings(
        period=inputs.period,
        resolution=inputs.resolution,
        allowed=np.where(most > 0, most, np.inf),
        substeps=substeps,
    )


def widened_distance(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> float:
    """Return the allowed distance from the reference of a loop that hardly moves by its reference.

    Such a loop is moved by load, noise or test signals. The distance is 100 times the largest of
    the noise, the encoder step, and the travel by which the loop yields: the sum of load over loop
    stiffness and added control over control stiffness.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs
        Inputs of one loop.
    """
    # Position and signals at the start, noise, and controls at rest on and behind the reference.
    place, signals = float(inputs.start.position), [*map(float, inputs.first_signals)]
    noise = 0.0 if inputs.noise is None else float(np.ptp(inputs.noise))
    drive, controls = axis.drive, _controls(axis, place, *signals)
    # Added control: by dead band and rounding of the drive, and the injected signal.
    added = drive.deadband + drive.quantisation / 2
    if inputs.injected is not None:
        added += float(np.abs(inputs.injected).max())
    # Accelerations under the load, without force and under a force of 1.
    force, dynamics = axis.functions["drive_force"], axis.functions["direct_dynamics"]
    still, behind = (float(force(control, place, 0.0, *signals)) for control in controls)
    loaded, free, pushed = (
        float(dynamics(place, 0.0, tau, 0.0, *signals, parameters)) for tau in (still, 0.0, 1.0)
    )
    # At rest on its reference the loop yields to the load, and to added control, until its control
    # balances them: not at all without either, and without limit if it has no stiffness.
    disturbances = np.array([abs(loaded), added])
    reactions = np.abs([(pushed - free) * (behind - still), controls[1] - controls[0]])
    with np.errstate(all="ignore"):
        ways = np.where(disturbances > 0, disturbances * _OFF / reactions, 0.0)
    return _RUNAWAY_RATIO * max(float(ways.sum()), noise, inputs.resolution)


def _controls(axis: GeneratedAxis, position: float, *recorded: float) -> tuple[float, float]:
    """Return the control at rest on the reference, and the control slightly behind the reference.

    Both are of the evaluation at which they differ most, as a delayed law responds late.
    """
    size = axis.functions["control_law"].size1_in("state")
    begin = axis.functions["control_start"](position, position, *recorded).full().ravel()
    read = position + np.array([[0.0, _OFF], [0.0, 0.0]])
    signals = np.repeat([[0.0], *([value] for value in recorded)], 2, axis=1)  # velocity first
    memory, answers = np.tile(begin[:size], (2, 1)), list[Array]()
    for _ in range(size + 2):  # a delayed law responds late
        control, memory = axis.evaluate("control_law", *read, *signals, memory)
        answers.append(control[:, 0])
    still, behind = max(answers, key=lambda pair: float(abs(pair[1] - pair[0])))
    return float(still), float(behind)
