"""The closed loop over time in the CasADi virtual machine: `loop.c` in Python.

It serves where there is no compiler, and as the native loop's independent check. The two follow the
same steps, so that their results agree to rounding.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .arguments import Array
from .loop_settings import SIGNALS, STATUSES, LoopSettings

_MOST_EVENTS = 20  # in a sample; more is chatter (Zeno)
_MOST_REFINEMENTS = 60
_JUST_LEFT = 1e-6  # of the time left in a sample
_DONE, _OUT_OF_RANGE, _NOT_FINITE, _CHATTER = range(len(STATUSES))


class _StoppedError(Exception):
    """A simulation that cannot go on, with its status."""

    def __init__(self, status: int) -> None:
        super().__init__(STATUSES[status])
        self.status = status


class _Buffered:
    """A CasADi function on fixed memory: arguments and results without conversion."""

    def __init__(self, function: Any) -> None:
        arguments = [np.zeros(function.size1_in(i)) for i in range(function.n_in())]
        results = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        self.arguments = dict(zip(function.name_in(), arguments, strict=True))
        self.results = results
        self._buffer, self._run = function.buffer()
        for i, array in enumerate(arguments):
            self._buffer.set_arg(i, memoryview(array.data))
        for i, array in enumerate(results):
            self._buffer.set_res(i, memoryview(array.data))

    def __call__(self, **scalars: float) -> list[Array]:
        """Set scalar arguments, evaluate, and return the results' memory."""
        for name, value in scalars.items():
            self.arguments[name][0] = value
        self._run()
        return self.results


class VirtualLoop:
    """The closed loop of one axis, by its functions, with one parameter set."""

    def __init__(
        self, functions: Mapping[str, Any], parameters: Array, settings: LoopSettings
    ) -> None:
        self._q, self._dq = functions["closed_loop_step"].name_in()[:2]
        self._settings = settings
        self._law_start = functions["control_start"]
        self._loop_step = _Buffered(functions["closed_loop_step"])
        self._plant_step = _Buffered(functions["plant_step"])
        self._acceleration = _Buffered(functions["held_acceleration"])
        for function in (self._loop_step, self._plant_step, self._acceleration):
            function.arguments["parameters"][:] = parameters
        self._loop_step.arguments["step"][0] = settings.period
        self._held = np.zeros(functions["held_acceleration"].size1_in("held"))
        self._continuous = len(self._held) > 1

    @np.errstate(all="ignore")  # what overflows ends as not finite
    def run(
        self, reference: Array, noise: Array | None, start: float
    ) -> tuple[int, int, dict[str, Array]]:
        """Run one simulation; as `NativeLibrary.simulate`."""
        samples, settings = len(reference), self._settings
        signals = {name: np.zeros(samples) for name in SIGNALS}
        noise = np.zeros(samples) if noise is None else noise
        q, dq, end = start, 0.0, 0.0
        measured = start + self._encoder(start, noise[0])
        state = self._law_start(reference[0], measured).full().ravel()
        self._loop_step.arguments["state"][:] = state
        for k in range(samples):
            if not abs(q - reference[k]) <= settings.allowed:
                return (_OUT_OF_RANGE if np.isfinite(q) else _NOT_FINITE), k, signals
            signals["position"][k], signals["velocity"][k], signals["before"][k] = q, dq, end
            rate = 0.0
            if self._continuous and k + 1 < samples:
                rate = (reference[k + 1] - reference[k]) / settings.period
            try:
                moved, row = self._sample(q, dq, reference[k], rate, self._encoder(q, noise[k]))
            except _StoppedError as stop:
                return stop.status, k, signals
            q, dq, end = moved
            for name, value in zip(SIGNALS[2:6], row, strict=True):
                signals[name][k] = value
            if k == 0:  # nothing was held before
                signals["before"][0] = signals["direction"][0]
        return _DONE, samples - 1, signals

    def _encoder(self, q: float, noise: float) -> float:
        """Error of the measurement: noise, and rounding to the encoder's counts."""
        resolution = self._settings.resolution
        if resolution <= 0:
            return noise
        return float(np.floor((q + noise) / resolution + 0.5) * resolution - q)

    def _sample(
        self, q: float, dq: float, reference: float, rate: float, error: float
    ) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
        """State and direction at the next sample; acceleration, force, control, direction now."""
        direction = float(np.sign(dq))
        step = self._loop_step
        out = step(
            **{self._q: q, self._dq: dq},
            reference=reference,
            reference_rate=rate,
            measurement_error=error,
            direction=direction,
        )
        q_next, dq_next, ddq, force, control, last = (float(out[i][0]) for i in (0, 1, 3, 4, 5, 6))
        step.arguments["state"][:] = out[2]
        bends = ddq * direction < 0 < last * direction
        if direction and dq_next * direction >= 0 and not bends and self._settings.substeps == 1:
            return (q_next, dq_next, direction), (ddq, force, control, direction)
        self._held[:] = (reference, rate, error) if self._continuous else force
        direction = direction or self._at_rest(q)
        ddq = 0.0 if abs(direction) < 1 else self._accelerate(q, dq, direction)
        end = direction
        span = self._settings.period / self._settings.substeps
        for i in range(self._settings.substeps):
            if i and dq == 0:
                end = self._at_rest(q)
            q, dq, end = self._advance(q, dq, end, span)
        return (q, dq, end), (ddq, force, control, direction)

    def _advance(
        self, q: float, dq: float, direction: float, left: float
    ) -> tuple[float, float, float]:
        """Move for `left` seconds through every change of the friction direction."""
        for _ in range(_MOST_EVENTS):
            if abs(direction) < 1:
                span = self._breakaway(q, left)
                self._pass(span)
                left -= span
                if left <= 0:
                    return q, dq, self._at_rest(q) if self._continuous else direction
                direction = self._at_rest(q)
                continue
            end, speed, first, last = self._move(q, dq, direction, left)
            if not (np.isfinite(end) and np.isfinite(speed)):
                raise _StoppedError(_NOT_FINITE)
            span = left
            if speed * direction >= 0:
                span = self._lowest(q, dq, direction, first, last, left)
                if span == left:
                    self._pass(left)
                    return end, speed, direction
            span = self._crossing(q, dq, direction, span)
            q, dq = self._move(q, dq, direction, span)[0], 0.0
            self._pass(span)
            left -= span
            direction = self._at_rest(q)
            if left <= 0:
                return q, dq, direction
        raise _StoppedError(_CHATTER)

    def _lowest(
        self, q: float, dq: float, direction: float, first: float, last: float, left: float
    ) -> float:
        """Time at which a velocity that ends in its direction dips below zero; `left` if never."""
        # From rest it leaves in its direction, whatever rounding says of the first slope.
        if dq and first * direction < 0 < last * direction:
            span = left * first / (first - last)
            if self._move(q, dq, direction, span)[1] * direction < 0:
                return span
        return left

    def _crossing(self, q: float, dq: float, direction: float, high: float) -> float:
        """Time at which the velocity reaches zero; by `high` it has changed its sign."""
        low, t = 0.0, high * _JUST_LEFT
        if dq == 0:  # just left rest: it crosses zero again only after a while
            if self._move(q, dq, direction, t)[1] * direction <= 0:
                return t
            low = t
        t = 0.5 * (low + high)
        for _ in range(_MOST_REFINEMENTS):
            _, speed, _, slope = self._move(q, dq, direction, t)
            if speed == 0:
                break
            low, high = (t, high) if speed * direction > 0 else (low, t)
            following = t - speed / slope if slope else low
            if not low < following < high:
                following = 0.5 * (low + high)
            if following == t:
                break
            t = following
        return t

    def _breakaway(self, q: float, left: float) -> float:
        """Time at which a stuck axis leaves rest, at most `left`."""
        if not self._continuous or self._sticks_after(q, left):
            return left
        low, high = 0.0, left
        for _ in range(_MOST_REFINEMENTS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._sticks_after(q, middle) else (low, middle)
        return high

    def _sticks_after(self, q: float, span: float) -> bool:
        held = self._held.copy()
        self._pass(span)
        direction = self._at_rest(q)
        self._held[:] = held
        return abs(direction) < 1

    def _pass(self, span: float) -> None:
        """What is held, `span` seconds later."""
        if self._continuous:
            self._held[0] += self._held[1] * span

    def _at_rest(self, q: float) -> float:
        """Friction direction at zero velocity; strictly between -1 and 1 if the axis sticks."""
        forward, backward = self._accelerate(q, 0.0, 1.0), self._accelerate(q, 0.0, -1.0)
        if forward > 0:
            return 1.0
        if backward < 0:
            return -1.0
        # Not a number if the force is not one.
        return 0.0 if backward == forward else (backward + forward) / (backward - forward)

    def _accelerate(self, q: float, dq: float, direction: float) -> float:
        self._acceleration.arguments["held"][:] = self._held
        motion = {self._q: q, self._dq: dq}
        return float(self._acceleration(**motion, direction=direction)[0][0])

    def _move(
        self, q: float, dq: float, direction: float, span: float
    ) -> tuple[float, float, float, float]:
        """Position, velocity, and acceleration at both ends of a step."""
        self._plant_step.arguments["held"][:] = self._held
        motion = {self._q: q, self._dq: dq}
        end = self._plant_step(**motion, direction=direction, step=span)
        return float(end[0][0]), float(end[1][0]), float(end[2][0]), float(end[3][0])
