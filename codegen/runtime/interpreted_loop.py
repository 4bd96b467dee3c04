"""The closed loop over time in the CasADi virtual machine: `printers/loop` in Python.

It serves where there is no compiler, and as the native loop's independent check. The two follow the
same steps, so that their results agree to rounding.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from axisid.codegen.lowering import (
    RESOLVED,
    SIGNALS,
    STATUSES,
    STEPS_IN_ALL,
    STEPS_OF_EACH,
    STUCK,
    LoopSettings,
    LoopStart,
)
from axisid.support.arrays import Array

from .virtual_plant import BufferedFunction, Mode, StepResult, VirtualPlant

_MOST_EVENTS = (20, 4096)  # in a step, without sides and with; more is chatter (Zeno)
_MOST_STEPS = 16384  # that a step may be divided into
_MOST_REFINEMENTS = 60
_JUST_LEFT = 1e-6  # of the time left in a sample
_AT_START = RESOLVED * (1 + 1e-6)  # so that rounding does not decide for round numbers
_CAUGHT = 1 / 1024  # of a step
_DONE, _OUT_OF_RANGE, _NOT_FINITE, _CHATTER, _UNRESOLVED = range(len(STATUSES))


class _StoppedError(Exception):
    """A simulation that cannot go on, with its status."""

    def __init__(self, status: int) -> None:
        super().__init__(STATUSES[status])
        self.status = status


class VirtualLoop:
    """The closed loop of one axis, by its functions, with one parameter set.

    Parameters
    ----------
    functions : mapping of str to casadi.Function
    parameters : (p,) array
        Behind them the gains of the law where its functions take them.
    settings : LoopSettings
    """

    def __init__(
        self,
        functions: Mapping[str, Any],
        parameters: Array,
        settings: LoopSettings,
    ) -> None:
        self._q, self._dq = functions["closed_loop_step"].name_in()[:2]
        self._settings = settings
        own = functions["plant_step"].size1_in("parameters")
        self._plant = VirtualPlant(functions, parameters[:own])
        self._gains = () if own == len(parameters) else (parameters[own:],)
        self._most_events = _MOST_EVENTS[self._plant.sides > 0]
        self._left = 0
        self._law_start = functions["control_start"]
        self._loop_step = BufferedFunction(functions["closed_loop_step"])
        self._loop_step.arguments["parameters"][:] = parameters
        self._cut = self._plant.until > 0
        # The place of the oldest command's force in the state, where it is needed.
        late = self._cut or self._plant.lagged
        self._oldest = -1 - self._plant.lagged if late else None
        self._loop_step.arguments["step"][0] = settings.period * (self._plant.until or 1.0)

    @np.errstate(all="ignore")  # what overflows ends as not finite
    def run(
        self,
        reference: Array,
        noise: Array | None,
        injected: Array | None,
        start: LoopStart,
        recorded: Array | None = None,
    ) -> tuple[int, int, dict[str, Array]]:
        """Run one simulation; as `NativeLibrary.simulate`."""
        samples, settings = len(reference), self._settings
        self._left = max(STEPS_IN_ALL, STEPS_OF_EACH * samples)
        signals = {name: np.zeros(samples) for name in SIGNALS}
        noise = np.zeros(samples) if noise is None else noise
        injected = np.zeros(samples) if injected is None else injected
        recorded = np.zeros((samples, 0)) if recorded is None else recorded
        q, dq, end = float(start.position), float(start.velocity), 0.0
        mode = self._first_mode(q, dq, recorded[0])
        state = start.memory
        if state is None:
            measured = q + self._encoder(q, noise[0])
            read = (*recorded[0, ::2], *self._gains)
            state = self._law_start(reference[0], measured, *read).full().ravel()
        self._loop_step.arguments["state"][:] = state
        for k in range(samples):
            if not abs(q - reference[k]) <= settings.allowed:
                return (_OUT_OF_RANGE if np.isfinite(q) else _NOT_FINITE), k, signals
            signals["position"][k], signals["velocity"][k] = q, dq
            signals["direction_before"][k] = end
            if self._plant.moving and k:
                mode = self._plant.shifted(q, dq, mode, recorded[k])
            rate = 0.0
            if self._plant.continuous and k + 1 < samples:
                rate = (reference[k + 1] - reference[k]) / settings.period
            error = self._encoder(q, noise[k])
            try:
                q, dq, mode, row = self._sample(
                    q, dq, mode, (reference[k], rate, error, injected[k]), recorded[k]
                )
            except _StoppedError as stop:
                return stop.status, k, signals
            end = mode.direction
            for name, value in zip(SIGNALS[2:6], row, strict=True):
                signals[name][k] = value
            if k == 0:  # nothing was held before
                signals["direction_before"][0] = signals["direction"][0]
        return _DONE, samples - 1, signals

    @np.errstate(all="ignore")
    def later(
        self, motion: tuple[Array, Array], held: Array, span: Array, step: float
    ) -> tuple[Array, Array, Array]:
        """Motions some time after a law was evaluated; as `NativeLibrary.later`."""
        rows = zip(*motion, held, span, strict=True)
        found = np.array([self._later(*each, step) for each in rows]).reshape(-1, 3)
        return found[:, 0], found[:, 1], found[:, 2]

    def _later(
        self, q: float, dq: float, held: Array, span: float, step: float
    ) -> tuple[float, float, float]:
        mode = self._first_mode(q, dq, held[1:])
        self._plant.hold((held[0],), held[1:])
        self._left = STEPS_IN_ALL
        steps = math.ceil(span / step)
        try:
            for _ in range(steps):
                if dq == 0:
                    mode = self._plant.chosen_at_rest(q, mode)
                q, dq, mode = self._advance(q, dq, mode, span / steps)
        except _StoppedError:
            return math.nan, math.nan, math.nan
        return q, dq, mode.direction

    def _first_mode(self, q: float, dq: float, recorded: Array) -> Mode:
        """The mode of a motion that begins, beside value and rate of each signal."""
        mode = Mode(float(np.sign(dq)), (0.0,) * self._plant.sides, self._plant.start_states)
        if self._plant.moving:
            self._plant.hold((0.0,), np.zeros(len(recorded)))
            mode = self._plant.shifted(q, dq, mode, recorded)
        return self._plant.slipping(q, self._plant.beyond(q, dq, mode, 0))

    def _encoder(self, q: float, noise: float) -> float:
        """Error of the measurement: noise, and rounding to the encoder's counts."""
        resolution = self._settings.resolution
        if resolution <= 0:
            return noise
        return float(np.floor((q + noise) / resolution + 0.5) * resolution - q)

    def _sample(
        self,
        q: float,
        dq: float,
        mode: Mode,
        held: tuple[float, float, float, float],
        recorded: Array,
    ) -> tuple[float, float, Mode, tuple[float, float, float, float]]:
        """Motion and mode at the next sample; acceleration, force, control, direction now.

        `held` is the reference, its rate, the error of the measurement, and what is added to the
        control; `recorded` has value and rate of each signal.
        """
        mode = mode.directed(float(np.sign(dq)))
        moved, (force, control), targets = self._law(q, dq, mode, held, recorded)
        plant, substeps = self._plant, self._settings.substeps
        direction = mode.direction
        bends = moved.first * direction < 0 < moved.last * direction
        several = substeps > 1 or self._cut
        if direction and moved.dq * direction >= 0 and not (bends or plant.sides or several):
            return moved.q, moved.dq, mode.after(moved), (moved.first, force, control, direction)
        of_law = (force, targets[0]) if plant.lagged else (force,)
        plant.hold(held if plant.continuous else of_law, recorded)
        if not dq:
            mode = plant.chosen_at_rest(q, mode)
        ddq = 0.0 if mode.sticks else plant.accelerate(q, dq, mode)
        force = plant.force(q, dq, mode) if plant.lagged else force
        row = (ddq, force, control, mode.direction)
        # A command that begins to act within a sample cuts it in two.
        period, until = self._settings.period, plant.until * self._settings.period
        parts = (until, period - until) if until else (period,)
        for i, step in enumerate(part / substeps for part in parts for _ in range(substeps)):
            if i == substeps:  # the force of another command acts, or what is there goes to it
                plant.held[int(plant.lagged)] = targets[-1]
            if i and dq == 0:
                mode = plant.chosen_at_rest(q, mode)
            q, dq, mode = self._advance(q, dq, mode, step)
        return q, dq, mode, row

    def _law(
        self,
        q: float,
        dq: float,
        mode: Mode,
        held: tuple[float, float, float, float],
        recorded: Array,
    ) -> tuple[StepResult, tuple[float, float], tuple[float, ...]]:
        """A step of the sample's first part, force and control, and what the force goes to."""
        step = self._loop_step
        if len(recorded):
            step.arguments["signals"][:] = recorded
        if mode.sides:
            step.arguments["sides"][:] = mode.sides
        if mode.states:
            step.arguments["states"][:] = mode.states
        out = step(
            **{self._q: q, self._dq: dq},
            reference=held[0],
            reference_rate=held[1],
            measurement_error=held[2],
            injected=held[3],
            direction=mode.direction,
        )
        targets: tuple[float, ...] = ()
        if self._oldest is not None:
            last_target = float(out[2][self._oldest])
            first = float(step.arguments["state"][self._oldest]) if self._cut else last_target
            targets = (first, last_target)
        step.arguments["state"][:] = out[2]
        q_next, dq_next, ddq, force, control, last = (float(out[i][0]) for i in (0, 1, 3, 4, 5, 6))
        states = tuple(out[7].tolist()) if mode.states else ()
        return StepResult(q_next, dq_next, ddq, last, states), (force, control), targets

    def _advance(self, q: float, dq: float, mode: Mode, whole: float) -> tuple[float, float, Mode]:
        """Move for `whole` seconds through every change of the mode."""
        plant, left, event = self._plant, whole, 0
        while event < self._most_events:
            if mode.sticks:
                span = self._breakaway(q, mode, left)
                still = StepResult(q, 0.0, 0.0, 0.0, mode.states)
                met, span, _ = self._passing(q, 0.0, mode, span, still)
                plant.pass_time(span)
                left -= span
                if met is not None:
                    mode = plant.beyond(q, 0.0, mode.beside(met, -mode.sides[met]), met + 1)
                elif left <= 0:
                    return q, dq, plant.at_rest(q, mode) if plant.drifts else mode
                mode = plant.chosen_at_rest(q, mode)
                event += 1
                continue
            span, end = self._attempt(q, dq, mode, left, whole)
            if not (math.isfinite(end.q) and math.isfinite(end.dq)):
                raise _StoppedError(_NOT_FINITE)
            before, from_rest, direction = q, dq == 0, mode.direction
            reversed_, span, end = self._reversal(q, dq, mode, span, end)
            passed, span, end = self._passing(q, dq, mode, span, end)
            q, dq, mode = end.q, end.dq, mode.after(end)
            plant.pass_time(span)
            left -= span
            if passed is not None:
                dq, mode = self._beyond(passed, q, dq, mode, whole)
            elif reversed_:
                mode = plant.chosen_at_rest(q, mode)
                if from_rest and q == before and mode.direction == direction:
                    # It turned back before its position changed: what moves it is rounding.
                    plant.pass_time(left)
                    return q, dq, mode.directed(STUCK * direction)
            event += reversed_ or passed is not None
            if left <= 0:
                return q, dq, mode
        raise _StoppedError(_CHATTER)

    def _attempt(
        self, q: float, dq: float, mode: Mode, span: float, whole: float
    ) -> tuple[float, StepResult]:
        """A step as long as the rates at its ends allow, at most `span`."""
        plant = self._plant
        if not plant.sides:
            return span, plant.move(q, dq, mode, span)
        rate = plant.rate(q, dq, mode)
        if rate * whole > _AT_START * _MOST_STEPS:
            raise _StoppedError(_UNRESOLVED)
        if span * rate > _AT_START:
            span /= math.ceil(span * rate / _AT_START)
        while True:
            end = plant.move(q, dq, mode, span)
            if plant.rate(end.q, end.dq, mode.after(end)) * span <= 2 * RESOLVED:
                self._left -= 1
                if self._left < 0:
                    raise _StoppedError(_UNRESOLVED)
                return span, end
            if 2 * _MOST_STEPS * span < whole:
                finite = math.isfinite(end.q) and math.isfinite(end.dq)
                raise _StoppedError(_UNRESOLVED if finite else _NOT_FINITE)
            span *= 0.5

    def _reversal(
        self, q: float, dq: float, mode: Mode, span: float, end: StepResult
    ) -> tuple[bool, float, StepResult]:
        """Whether the velocity reaches zero in a step, which then ends there."""
        direction = mode.direction
        if end.dq * direction >= 0:  # it may have dipped below zero in between
            # From rest it leaves in its direction, whatever rounding says of the first slope.
            if not (dq and end.first * direction < 0 < end.last * direction):
                return False, span, end
            lowest = span * end.first / (end.first - end.last)
            if not self._plant.move(q, dq, mode, lowest).dq * direction < 0:
                return False, span, end
            span = lowest
        span = self._crossing(q, dq, mode, span)
        end = self._plant.move(q, dq, mode, span)
        return True, span, StepResult(end.q, 0.0, end.first, end.last, end.states)

    def _crossing(self, q: float, dq: float, mode: Mode, high: float) -> float:
        """Time at which the velocity reaches zero; by `high` it has changed its sign."""
        low, t = 0.0, high * _JUST_LEFT
        if dq == 0:  # just left rest: it crosses zero again only after a while
            if self._plant.move(q, dq, mode, t).dq * mode.direction <= 0:
                return t
            low = t

        def velocity(t: float) -> tuple[float, float]:
            end = self._plant.move(q, dq, mode, t)
            return end.dq * mode.direction, end.last * mode.direction

        return _root(velocity, low, high)

    def _passing(
        self, q: float, dq: float, mode: Mode, span: float, end: StepResult
    ) -> tuple[int | None, float, StepResult]:
        """The first side that changes in a step, which then ends there."""
        plant, passed = self._plant, None
        start = plant.switches(q, dq, mode)
        at_end = plant.switches(end.q, end.dq, mode.after(end), span)
        for i, side in enumerate(mode.sides):
            high = span
            if at_end.values[i] * side >= 0:  # it may have been beyond in between
                first = start.rate(i, dq, end.first) * side
                last = at_end.rate(i, end.dq, end.last) * side
                if not first < 0 < last:
                    continue
                high = span * (first / (first - last))
                lowest = plant.move(q, dq, mode, high)
                after = mode.after(lowest)
                if plant.switches(lowest.q, lowest.dq, after, high).values[i] * side >= 0:
                    continue
            passed, span = i, self._change(i, q, dq, mode, high)
            end = plant.move(q, dq, mode, span)
            at_end = plant.switches(end.q, end.dq, mode.after(end), span)
        return passed, span, end

    def _change(self, index: int, q: float, dq: float, mode: Mode, high: float) -> float:
        """Time at which a side changes; by `high` it has changed."""

        def decides(t: float) -> tuple[float, float]:
            end = self._plant.move(q, dq, mode, t)
            switches = self._plant.switches(end.q, end.dq, mode.after(end), t)
            side = mode.sides[index]
            return switches.values[index] * side, switches.rate(index, end.dq, end.last) * side

        return _root(decides, 0.0, high)

    def _beyond(
        self, index: int, q: float, dq: float, mode: Mode, whole: float
    ) -> tuple[float, Mode]:
        """Velocity and mode of an axis in a place where a side changes."""
        plant = self._plant
        mode = mode.beside(index, -mode.sides[index])
        mode = plant.beyond(q, dq, mode, index + 1)
        # An axis is held in a place that it passes where its acceleration points to it on both
        # sides, so that it would come back, and pass again, ever sooner. If friction would hold it
        # on each side too, it comes to rest by itself; and nothing rests in a place that moves.
        if not plant.switches(q, dq, mode).moved(index):
            forward, backward = plant.leaving(q, mode.beside(index, 0.0))
            if 2 * abs(dq) < _CAUGHT * whole * min(backward, -forward) and any(
                abs(plant.at_rest(q, mode.beside(index, side)).direction) >= 1
                for side in (1.0, -1.0)
            ):
                dq, mode = 0.0, mode.beside(index, 0.0)
        return dq, plant.chosen_at_rest(q, mode) if dq == 0 else mode

    def _breakaway(self, q: float, mode: Mode, left: float) -> float:
        """Time at which a stuck axis leaves rest, at most `left`."""
        plant = self._plant
        if not plant.drifts or plant.sticks_after(q, mode, left):
            return left
        low, high = 0.0, left
        for _ in range(_MOST_REFINEMENTS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if plant.sticks_after(q, mode, middle) else (low, middle)
        return high


def _root(at: Callable[[float], tuple[float, float]], low: float, high: float) -> float:
    """Time at which what is positive before is not any more: by Newton's method, or halves."""
    t = 0.5 * (low + high)
    for _ in range(_MOST_REFINEMENTS):
        value, rate = at(t)
        if value == 0:
            break
        low, high = (t, high) if value > 0 else (low, t)
        following = t - value / rate if rate else low
        following = following if low < following < high else 0.5 * (low + high)
        if following == t:
            break
        t = following
    return t
