"""Closed-loop simulation: the reference in, everything else simulated.

The control law is evaluated once a sample and held. In between, the plant moves in one friction
mode; where the velocity changes sign the crossing is located and the mode chosen anew. At rest the
model itself decides: with the accelerations a(+) and a(-) for both friction directions, the axis
sticks if and only if ``a(+) <= 0 <= a(-)`` (Filippov). While it sticks under a held force nothing
changes until the next sample.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import ModelError

from .arrays import Array
from .errors import EstimationError
from .signals import Signals

_MOST_CROSSINGS = 20  # per sample; more is chatter (Zeno)
_JUST_LEFT = 1e-6  # of the time left in the sample
_RUNAWAY = 100.0  # of the reference's span


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """A simulated closed loop, at the reference's samples.

    Force, acceleration and friction direction jump when the control is updated. `after` holds
    them just after the update at each sample, `before` just before it; both satisfy the model row
    by row.

    Attributes
    ----------
    after, before : Signals
        (N,) each, SI.
    measured_position : (N,) array
        Position with the noise that was given.
    control : (N,) array
        In the drive's unit.
    """

    after: Signals
    before: Signals
    measured_position: Array
    control: Array


def simulate(
    axis: GeneratedAxis,
    parameters: Array,
    reference: Array,
    period: float,
    *,
    start: float | None = None,
    position_noise: Array | None = None,
) -> Simulation:
    """Simulate the axis under its control law, starting at rest.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    parameters : (p,) array
        Physical parameters, SI.
    reference : (N,) array
        Commanded position.
    period : float
        Sampling period, s.
    start : float, optional
        First position; the first reference by default.
    position_noise : (N,) array, optional
        Added to the position that the law measures.

    Raises
    ------
    ModelError
        The axis has no control law.
    EstimationError
        The inertia is not positive, or the loop diverges or chatters; the sample is named.
    """
    if axis.axis.control is None:
        raise no_control_law(axis.axis.name)
    loop = _Loop(axis, parameters, period)
    noise = np.zeros(len(reference)) if position_noise is None else position_noise
    return loop.run(reference, noise, reference[0] if start is None else start)


def no_control_law(name: str) -> ModelError:
    """The error of an axis whose loop cannot be closed."""
    return ModelError(
        f"axis {name!r} has no control law, so its closed loop cannot be simulated. Declare one "
        "with control=..., or use idm-ls or ddm-ls."
    )


class _Buffered:
    """A CasADi function on fixed memory: arguments and results without conversion."""

    def __init__(self, function: Any) -> None:
        names = function.name_in()
        results = [np.zeros(function.size1_out(i)) for i in range(function.n_out())]
        arguments = [np.zeros(function.size1_in(i)) for i in range(function.n_in())]
        self.arguments = dict(zip(names, arguments, strict=True))
        self.results = dict(zip(function.name_out(), results, strict=True))
        self._positions = arguments
        self._first, self._second = results[0], results[min(1, len(results) - 1)]
        self._buffer, self._run = function.buffer()
        for i, array in enumerate(arguments):
            self._buffer.set_arg(i, memoryview(array.data))
        for i, array in enumerate(results):
            self._buffer.set_res(i, memoryview(array.data))

    def __call__(self, *scalars: float) -> tuple[float, float]:
        """Set the leading scalar arguments, evaluate, and return the first two results."""
        for array, value in zip(self._positions, scalars, strict=False):
            array[0] = value
        self._run()
        return float(self._first[0]), float(self._second[0])


class _Loop:
    """One closed loop with one parameter set."""

    def __init__(self, axis: GeneratedAxis, parameters: Array, period: float) -> None:
        self._axis, self._values, self._period = axis, parameters, period
        self._step = _Buffered(axis.functions["closed_loop_step"])
        self._plant = _Buffered(axis.functions["plant_step"])
        self._dynamics = _Buffered(axis.functions["direct_dynamics"])
        for function in (self._step, self._plant, self._dynamics):
            function.arguments["parameters"][:] = parameters
        self._step.arguments["step"][0] = period

    @property
    def _said(self) -> str:
        return self._axis.describe(self._values)

    def run(self, reference: Array, noise: Array, start: float) -> Simulation:
        """Simulate every sample."""
        samples = len(reference)
        position, velocity, force, control = np.zeros((4, samples))
        after, before = np.zeros((2, samples))
        allowed = self._allowed(reference, start)
        self._check_inertia(start)
        start_law = self._axis.functions["control_start"]
        self._step.arguments["state"][:] = start_law(start + noise[0]).full().ravel()
        q, dq = start, 0.0
        for k in range(samples):
            if not abs(q - reference[k]) <= allowed:
                raise self._diverged(k, q)
            position[k], velocity[k] = q, dq
            after[k], (q, dq, end) = self._sample(q, dq, reference[k], noise[k])
            force[k] = self._step.results["tau"][0]
            control[k] = self._step.results["control"][0]
            if k + 1 < samples:
                before[k + 1] = end
        before[0] = after[0]
        held = np.concatenate([force[:1], force[:-1]])
        return Simulation(
            after=self._signals(position, velocity, force, after),
            before=self._signals(position, velocity, held, before),
            measured_position=position + noise,
            control=control,
        )

    def _sample(
        self, q: float, dq: float, reference: float, noise: float
    ) -> tuple[float, tuple[float, float, float]]:
        """Control, then move for one period: direction at the start, and the state at the end."""
        direction = float(np.sign(dq))
        step = self._step
        step.arguments["reference"][0] = reference
        step.arguments["position_noise"][0] = noise
        step.arguments["direction"][0] = direction
        q_next, dq_next = step(q, dq)
        step.arguments["state"][:] = step.results["next_state"]
        force = float(step.results["tau"][0])
        if direction and dq_next * direction >= 0:
            return direction, (q_next, dq_next, direction)
        if not direction:
            direction = self._at_rest(q, force)
        return direction, self._advance(q, dq, force, direction)

    def _advance(
        self, q: float, dq: float, force: float, direction: float
    ) -> tuple[float, float, float]:
        """Move under a held force through every change of the friction direction."""
        left = self._period
        for _ in range(_MOST_CROSSINGS):
            if abs(direction) < 1:
                return q, 0.0, direction

            end, speed = self._move(q, dq, force, direction, left)
            if speed * direction >= 0:
                return end, speed, direction
            span = self._crossing(q, dq, force, direction, left)
            q, dq = self._move(q, dq, force, direction, span)[0], 0.0
            left -= span
            direction = self._at_rest(q, force)
        raise EstimationError(
            f"the simulated axis {self._axis.axis.name!r} changes direction more than "
            f"{_MOST_CROSSINGS} times within one sample at position {q:g} with {self._said}; check "
            "the friction in the equation of motion and the parameters."
        )

    def _crossing(self, q: float, dq: float, force: float, direction: float, left: float) -> float:
        """Time at which the velocity reaches zero, s; it has changed sign after `left`."""
        from scipy.optimize import brentq

        def along(span: float) -> float:
            return direction * self._move(q, dq, force, direction, span)[1]

        # An axis that has just left rest crosses zero again only after a while.
        first = 0.0 if dq else left * _JUST_LEFT
        if along(first) <= 0:
            return first
        return float(brentq(along, first, left, xtol=1e-18, rtol=1e-15))

    def _move(
        self, q: float, dq: float, force: float, direction: float, span: float
    ) -> tuple[float, float]:
        self._plant.arguments["step"][0] = span
        return self._plant(q, dq, force, direction)

    def _at_rest(self, q: float, force: float) -> float:
        """Friction direction at zero velocity; strictly between -1 and 1 if the axis sticks."""
        forward = self._dynamics(q, 0.0, force, 1.0)[0]
        backward = self._dynamics(q, 0.0, force, -1.0)[0]
        if forward > 0:
            return 1.0
        if backward < 0:
            return -1.0
        spread = backward - forward
        return (backward + forward) / spread if spread > 0 else 0.0

    def _signals(self, position: Array, velocity: Array, force: Array, direction: Array) -> Signals:
        (acceleration,) = self._axis.rows(
            "direct_dynamics", position, velocity, force, direction, self._values
        )
        return Signals(
            position=position,
            velocity=velocity,
            acceleration=acceleration[:, 0],
            force=force,
            direction=direction,
        )

    def _allowed(self, reference: Array, start: float) -> float:
        """Distance from the reference beyond which the loop has run away."""
        return _RUNAWAY * max(float(np.ptp(reference)), abs(start - reference[0])) or math.inf

    def _check_inertia(self, position: float) -> None:
        push = (
            self._dynamics(position, 0.0, 1.0, 0.0)[0] - self._dynamics(position, 0.0, 0.0, 0.0)[0]
        )
        if not push > 0 or not math.isfinite(push):
            raise EstimationError(
                f"axis {self._axis.axis.name!r} has no positive inertia with {self._said}, so it "
                "cannot be simulated. Give its inertial parameters a positive nominal value, or "
                "check the signs of force and position in the record."
            )

    def _diverged(self, sample: int, position: float) -> EstimationError:
        return EstimationError(
            f"the simulated closed loop of axis {self._axis.axis.name!r} diverges: position "
            f"{position:g} at sample {sample} ({sample * self._period:g} s) with {self._said}. "
            "Check the control law's gains and period, the drive gain and the nominal values."
        )
