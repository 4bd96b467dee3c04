"""The closed loop over time in the CasADi virtual machine: the C code of `printers/loop` in Python.

This loop is used if there is no compiler, and as an independent check of the native loop. Both
perform the same steps, so that their results agree to rounding.

A *side* is the sign, -1 or 1, of a switching function: the acceleration has a kink or a jump where
this function is 0. A *mode* is a friction direction together with all sides. The motion is smooth
in one mode. An *event* is a change of the mode: a velocity reversal, a change of a side, or leaving
rest.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

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

from .casadi_functions import held_count, is_continuous, recorded_count

_MOST_EVENTS = (20, 4096)  # in a step, without and with sides; more are chatter (Zeno behaviour)
_MOST_STEPS = 16384  # parts into which a step may be divided
_MOST_REFINEMENTS = 60  # iterations of a search for the time of an event
_JUST_LEFT = 1e-6  # of the time to be searched: shortest time after leaving rest
_AT_START = RESOLVED * (1 + 1e-6)  # so that rounding has no effect on round numbers
_CAUGHT = 1 / 1024  # of a step: time within which an axis that passes a kink would return to it
_DONE, _OUT_OF_RANGE, _NOT_FINITE, _CHATTER, _UNRESOLVED = range(len(STATUSES))


class _StoppedError(Exception):
    """A simulation cannot continue; the argument is the status, an index into `STATUSES`."""


class Motion(NamedTuple):
    """State of an axis: position, velocity, mode and internal states of friction.

    Attributes
    ----------
    q, dq : float
        Position and velocity.
    direction : float
        Friction direction: -1 or 1, or strictly between them if the axis sticks.
    sides : tuple of float
        Side of the axis at each kink or jump of the acceleration: -1 or 1, or 0 if the axis rests
        exactly at the kink or jump.
    states : tuple of float
        Internal states of friction.
    """

    q: float
    dq: float
    direction: float
    sides: tuple[float, ...] = ()
    states: tuple[float, ...] = ()

    @property
    def sticks(self) -> bool:
        """Return True if the axis sticks."""
        return abs(self.direction) < 1

    def beside(self, index: int, side: float) -> "Motion":
        """Return the same state with `side` as the side of kink or jump number `index`.

        `side` is -1 or 1, or 0 for rest exactly at the kink or jump.
        """
        return self._replace(sides=(*self.sides[:index], side, *self.sides[index + 1 :]))


class StepResult(NamedTuple):
    """The state after a step, and the acceleration at both ends of the step.

    Attributes
    ----------
    end : Motion
    first, last : float
        Acceleration at the start and at the end.
    """

    end: Motion
    first: float
    last: float


class Places(NamedTuple):
    """Values and derivatives of the switching functions, whose signs are the sides.

    Each attribute has one entry for each side.

    Attributes
    ----------
    values : tuple of float
        Values of the switching functions.
    by_position, by_velocity, by_time : tuple of float
        Partial derivatives with respect to position, velocity and time; the recorded signals depend
        on time.
    """

    values: tuple[float, ...]
    by_position: tuple[float, ...]
    by_velocity: tuple[float, ...]
    by_time: tuple[float, ...]


class BufferedFunction:
    """A CasADi function that reads its arguments from and writes its results into fixed arrays.

    Parameters
    ----------
    function : casadi.Function
    parameters : array
        Value of the argument ``parameters``, the same at every call; further values are ignored.

    Attributes
    ----------
    arguments : dict of str to array
        Arrays of the arguments, by name; they keep their values from call to call.
    results : list of array
        Arrays of the results, which the next call overwrites.
    """

    def __init__(self, function: Any, parameters: Array) -> None:
        arguments = [np.zeros(function.size1_in(i)) for i in range(function.n_in())]
        self.arguments = dict(zip(function.name_in(), arguments, strict=True))
        self.results = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        self._buffer, self._run = function.buffer()
        for i, array in enumerate(arguments):
            self._buffer.set_arg(i, memoryview(array.data))
        for i, array in enumerate(self.results):
            self._buffer.set_res(i, memoryview(array.data))
        taken = self.arguments["parameters"]
        taken[:] = parameters[: len(taken)]

    def __call__(self, values: Mapping[str, Any]) -> list[Array]:
        """Set the given arguments by name, evaluate the function, and return its result arrays."""
        for name, array in self.arguments.items():
            if name in values:
                array[:] = values[name]
        self._run()
        return self.results


class VirtualLoop:
    """The closed loop of one axis for one parameter set, in the virtual machine.

    Parameters
    ----------
    functions : mapping of str to casadi.Function
        Functions of the axis.
    parameters : (p,) array
        Parameters, followed by the gains of the law if its functions take them.
    settings : LoopSettings
    """

    def __init__(
        self,
        functions: Mapping[str, Any],
        parameters: Array,
        settings: LoopSettings,
    ) -> None:
        names = ("closed_loop_step", "plant_step", "held_acceleration", "switching", "plant_rate")
        self._functions = {
            name: BufferedFunction(functions[name], parameters)
            for name in names
            if name in functions
        }
        self._q, self._dq = functions["plant_step"].name_in()[:2]
        self._settings, self._left = settings, 0
        own = functions["plant_step"].size1_in("parameters")
        self._gains = () if own == len(parameters) else (parameters[own:],)
        self._law_start = functions["control_start"]
        #: Values that are held between samples; last are value and rate of each recorded signal.
        self._held = np.zeros(functions["held_acceleration"].size1_in("held"))
        self._recorded = recorded_count(functions)
        self._continuous = is_continuous(functions)
        arguments = self._functions["switching"].arguments if "switching" in functions else {}
        self._sides = len(arguments.get("sides", ()))
        # True if recorded signals change the positions of kinks and jumps.
        self._moving = "held" in arguments
        self._start_states: tuple[float, ...] = ()
        self._limits = range(0)  # the sides that belong to states' limits
        if "state_start" in functions:
            start, first = functions["state_start"](parameters[:own])
            self._start_states = tuple(start.full().ravel().tolist())
            self._limits = range(int(first), self._sides)
        self._response = functions.get("drive_response")
        # True if the force moves to a final value (or follows a control), which is held too.
        self._lagged = held_count(functions) == len(("tau", "target"))
        # True if held values change between samples, so that an axis may leave rest there.
        self._drifts = self._continuous or self._lagged or self._recorded > 0
        # Part of a sample after which the last command begins to act; 0 if at the sample.
        self._until = 0.0 if self._response is None else float(self._response(0.0, 0.0, 1.0)[1])
        step = self._functions["closed_loop_step"].arguments["step"]
        step[0] = settings.period * (self._until or 1.0)

    @np.errstate(all="ignore")  # a loop that overflows ends as not finite
    def run(
        self,
        reference: Array,
        noise: Array | None,
        injected: Array | None,
        start: LoopStart,
        recorded: Array | None = None,
    ) -> tuple[int, int, dict[str, Array]]:
        """Return status, last sample and signals of one simulation, as `NativeLibrary.simulate`.

        At each sample the distance from the reference is checked, the law is evaluated with the
        measured position, and the motion is advanced to the next sample.
        """
        samples, settings = len(reference), self._settings
        self._left = max(STEPS_IN_ALL, STEPS_OF_EACH * samples)
        rows = np.zeros((len(SIGNALS), samples))
        signals = dict(zip(SIGNALS, rows, strict=True))
        noise = np.zeros(samples) if noise is None else noise
        injected = np.zeros(samples) if injected is None else injected
        recorded = np.zeros((samples, 0)) if recorded is None else recorded
        at, end = self._first(float(start.position), float(start.velocity), recorded[0]), 0.0
        memory = start.memory
        if memory is None:
            measured = at.q + self._encoder(at.q, noise[0])
            read = (*recorded[0, ::2], *self._gains)
            memory = self._law_start(reference[0], measured, *read).full().ravel()
        self._functions["closed_loop_step"].arguments["state"][:] = memory
        for k in range(samples):
            if not abs(at.q - reference[k]) <= settings.allowed:
                return (_OUT_OF_RANGE if np.isfinite(at.q) else _NOT_FINITE), k, signals
            rows[:2, k] = at.q, at.dq
            if self._moving and k:
                at = self._shifted(at, recorded[k])
            rate = 0.0
            if self._continuous and k + 1 < samples:
                rate = (reference[k + 1] - reference[k]) / settings.period
            given = (reference[k], rate, self._encoder(at.q, noise[k]), injected[k])
            try:
                at, row = self._sample(at, given, recorded[k])
            except _StoppedError as stop:
                return stop.args[0], k, signals
            # Nothing was held before the first sample.
            rows[2:, k] = (*row, end if k else row[-1])
            end = at.direction
        return _DONE, samples - 1, signals

    @np.errstate(all="ignore")
    def later(
        self, motion: tuple[Array, Array], held: Array, span: Array, step: float
    ) -> tuple[Array, Array, Array]:
        """Return positions, velocities and directions some time after a law was evaluated.

        Arguments and results are those of `NativeLibrary.later`.
        """
        rows = zip(*motion, held, span, strict=True)
        found = np.array([self._later(*each, step) for each in rows]).reshape(-1, 3)
        return found[:, 0], found[:, 1], found[:, 2]

    def _later(
        self, q: float, dq: float, held: Array, span: float, step: float
    ) -> tuple[float, float, float]:
        """Return position, velocity and direction `span` seconds later; NaN if this fails.

        `held` has the force, and value and rate of each recorded signal. No step is longer than
        `step`.
        """
        at = self._first(q, dq, held[1:])
        self._hold((held[0],), held[1:])
        self._left = STEPS_IN_ALL
        steps = math.ceil(span / step)
        try:
            for _ in range(steps):
                at = self._advance(self._chosen_at_rest(at) if at.dq == 0 else at, span / steps)
        except _StoppedError:
            return math.nan, math.nan, math.nan
        return at.q, at.dq, at.direction

    def _first(self, q: float, dq: float, recorded: Array) -> Motion:
        """Return the state at the start of a simulation.

        `recorded` has value and rate of each recorded signal at the start. The sides follow from
        the switching functions.
        """
        at = Motion(q, dq, float(np.sign(dq)), (0.0,) * self._sides, self._start_states)
        if self._moving:
            self._hold((0.0,), np.zeros(len(recorded)))
            at = self._shifted(at, recorded)
        return self._slipping(self._beyond(at, 0))

    def _encoder(self, q: float, noise: float) -> float:
        """Return the measurement error: noise, and rounding to the encoder's counts."""
        resolution = self._settings.resolution
        if resolution <= 0:
            return noise
        return float(np.floor((q + noise) / resolution + 0.5) * resolution - q)

    def _sample(
        self, at: Motion, given: tuple[float, float, float, float], recorded: Array
    ) -> tuple[Motion, tuple[float, float, float, float]]:
        """Return the state at the next sample, and the loop's signals at this one.

        If the velocity keeps its sign, one compiled step is enough. Otherwise the held values are
        stored, and the motion is advanced from event to event.

        Parameters
        ----------
        at : Motion
            State at the sample.
        given : tuple of float
            Reference, its rate, the measurement error, and the test signal added to the control.
        recorded : array
            Value and rate of each recorded signal.

        Returns
        -------
        Motion
            State at the next sample.
        tuple of float
            Acceleration, force, control and friction direction at this sample.
        """
        direction, substeps = float(np.sign(at.dq)), self._settings.substeps
        at = at._replace(direction=direction)
        memory = self._functions["closed_loop_step"].arguments["state"]
        # Try the compiled step: it evaluates the law and moves the axis in one mode.
        names = ("reference", "reference_rate", "measurement_error", "injected")
        values = dict(zip(names, given, strict=True))
        before = memory.copy()
        q, dq, memory[:], ddq, tau, command, last, *states = self._call(
            "closed_loop_step", at, signals=recorded, **values
        )
        moved = _moved(at, q, dq, ddq, last, *states)
        force, control = float(tau[0]), float(command[0])
        # Accept the step if the velocity cannot have changed its sign within it.
        bends = moved.first * direction < 0 < moved.last * direction
        several = substeps > 1 or self._until or self._sides
        if direction and moved.end.dq * direction >= 0 and not (bends or several):
            return moved.end, (moved.first, force, control, direction)
        # Otherwise store the values that are held until the next sample. `oldest` is the index of
        # the oldest command in the drive's memory.
        oldest = -1 - self._lagged
        if self._continuous:
            self._hold(given, recorded)
        elif self._lagged:
            self._hold((force, (before if self._until else memory)[oldest]), recorded)
        else:
            self._hold((force,), recorded)
        if not at.dq:
            at = self._chosen_at_rest(at)
        ddq, tau = self._call("held_acceleration", at)
        row = (
            0.0 if at.sticks else float(ddq[0]),
            float(tau[0]) if self._lagged else force,
            control,
            at.direction,
        )
        # A command that begins to act within a sample divides it in two.
        period, until = self._settings.period, self._until * self._settings.period
        parts = (until, period - until) if until else (period,)
        for i, step in enumerate(part / substeps for part in parts for _ in range(substeps)):
            if i == substeps:  # from here the next command acts, or the force moves to its force
                self._held[int(self._lagged)] = memory[oldest]
            at = self._advance(self._chosen_at_rest(at) if i and at.dq == 0 else at, step)
        return at, row

    def _advance(self, at: Motion, whole: float) -> Motion:
        """Return the state after `whole` seconds, advanced from event to event.

        A sliding axis takes the longest step that its rates permit; a sticking axis waits until it
        breaks away. The step is shortened to the first event in it, and the new mode is chosen
        there.
        """
        left, event = whole, 0
        while event < _MOST_EVENTS[self._sides > 0]:
            if at.sticks:
                span, step = self._breakaway(at, left), StepResult(at, 0.0, 0.0)
            else:
                span, step = self._attempt(at, left, whole)
            # End the step at the first event in it.
            changed, span, step = self._changed(at, span, step)
            self._pass_time(span)
            left -= span
            event += at.sticks or changed is not None
            # Choose the mode in which the motion continues.
            end = at if at.sticks else step.end
            if at.sticks:
                if changed:
                    end = self._beyond(at.beside(changed - 1, -at.sides[changed - 1]), changed)
                elif left <= 0:
                    return self._at_rest(at) if self._drifts else at
                end = self._chosen_at_rest(end)
            elif changed:
                end = self._passed(changed - 1, end, whole)
            elif changed == 0:
                end = self._chosen_at_rest(end)
                if at.dq == 0 and at.q == end.q and at.direction == end.direction:
                    # The velocity reversed before the position changed: this is rounding error.
                    self._pass_time(left)
                    return end._replace(direction=STUCK * end.direction)
            if left <= 0 and not at.sticks:
                return end
            at = end
        raise _StoppedError(_CHATTER)

    def _attempt(self, at: Motion, span: float, whole: float) -> tuple[float, StepResult]:
        """Return the length of a step, at most `span` s, and the step.

        The step is shortened until its length times the rate of the motion is small at both ends.
        Without sides the full step is taken.

        Parameters
        ----------
        at : Motion
        span : float
            Longest step, s.
        whole : float
            Total time to be advanced, s. It limits how short the steps may become.
        """
        if not self._sides:
            return span, self._move(at, span)
        rate = self._rate(at)
        if rate * whole > _AT_START * _MOST_STEPS:
            raise _StoppedError(_UNRESOLVED)
        if span * rate > _AT_START:
            span /= math.ceil(span * rate / _AT_START)
        while True:
            step = self._move(at, span)
            if self._rate(step.end) * span <= 2 * RESOLVED:
                self._left -= 1
                if self._left < 0:
                    raise _StoppedError(_UNRESOLVED)
                return span, step
            if 2 * _MOST_STEPS * span < whole:
                finite = math.isfinite(step.end.q) and math.isfinite(step.end.dq)
                raise _StoppedError(_UNRESOLVED if finite else _NOT_FINITE)
            span *= 0.5

    def _margins(
        self, at: Motion, acceleration: float, after: float = 0.0
    ) -> tuple[list[float], list[float]]:
        """Return the distance of velocity and switching functions from an event, and its rates.

        The first entry of each list is for the velocity, the others are for the sides. The distance
        is a value times its present sign; a negative distance means that the event has happened.

        Parameters
        ----------
        at : Motion
        acceleration : float
        after : float
            Time since the held values were stored, s.
        """
        margins, rates = [at.dq * at.direction], [acceleration * at.direction]
        for side, value, *by in zip(at.sides, *self._places(at, after), strict=True):
            margins.append(value * side)
            rates.append((by[0] * at.dq + by[1] * acceleration + by[2]) * side)
        return margins, rates

    def _changed(
        self, at: Motion, span: float, step: StepResult
    ) -> tuple[int | None, float, StepResult]:
        """Return the first event in a step, the time until the event, and the step up to it.

        The event is 0 for a velocity reversal, i + 1 for side number i, and None without an event;
        the step is then unchanged. An event is in the step if its distance (`_margins`) is negative
        at the end of the step, or at an estimate of its minimum within the step. The step is then
        shortened to the event, and the remaining events are searched in the shorter step.
        """
        if not (math.isfinite(step.end.q) and math.isfinite(step.end.dq)):
            raise _StoppedError(_NOT_FINITE)
        changed = None
        _, firsts = self._margins(at, step.first)
        margins, lasts = self._margins(step.end, step.last, span)
        for i, first in enumerate(firsts):
            high = span
            if margins[i] >= 0:  # the distance may have been negative within the step
                # An axis leaves rest in its direction, even if rounding changes the first slope.
                if not first < 0 < lasts[i] or not (i or at.dq):
                    continue
                high = span * (first / (first - lasts[i]))
                lowest = self._move(at, high)
                if self._margins(lowest.end, lowest.last, high)[0][i] >= 0:
                    continue
            changed, span = i, self._root(i, at, high)
            step = self._move(at, span)
            if not i:
                step = step._replace(end=step.end._replace(dq=0.0))
            margins, lasts = self._margins(step.end, step.last, span)
        return changed, span, step

    def _root(self, index: int, at: Motion, high: float) -> float:
        """Return the time of an event, s, by Newton's method with bisection.

        Parameters
        ----------
        index : int
            0 for a velocity reversal, i + 1 for side number i.
        at : Motion
            State at the start of the step.
        high : float
            A time at which the event has happened, s.
        """
        low = 0.0
        if not (index or at.dq):  # the axis just left rest; the velocity 0 at the start is no event
            low = high * _JUST_LEFT
            if self._move(at, low).end.dq * at.direction <= 0:
                return low
        t = 0.5 * (low + high)
        for _ in range(_MOST_REFINEMENTS):
            step = self._move(at, t)
            margin, rate = (x[index] for x in self._margins(step.end, step.last, t))
            if margin == 0:
                break
            low, high = (t, high) if margin > 0 else (low, t)
            following = t - margin / rate if rate else low
            following = following if low < following < high else 0.5 * (low + high)
            if following == t:
                break
            t = following
        return t

    def _passed(self, index: int, at: Motion, whole: float) -> Motion:
        """Return the state after side number `index` has changed.

        The side is reversed. If the acceleration points back to the kink or jump on both sides, and
        the axis is slow, the axis comes to rest exactly there.
        """
        at = self._beyond(at.beside(index, -at.sides[index]), index + 1)
        # If the acceleration points to the kink or jump on both sides, the axis would return and
        # pass again, each time sooner. If friction would also hold the axis on each side, the axis
        # comes to rest without this rule. At a kink or jump that moves, the axis cannot rest.
        if not self._places(at).by_time[index]:
            forward, backward = self._leaving(at.beside(index, 0.0))
            if 2 * abs(at.dq) < _CAUGHT * whole * min(backward, -forward) and any(
                abs(self._at_rest(at.beside(index, side)).direction) >= 1 for side in (1.0, -1.0)
            ):
                at = at.beside(index, 0.0)._replace(dq=0.0)
        return self._chosen_at_rest(at) if at.dq == 0 else at

    def _breakaway(self, at: Motion, left: float) -> float:
        """Return the time after which a sticking axis leaves rest, at most `left` s."""
        if not self._drifts or self._sticks_after(at, left):
            return left
        low, high = 0.0, left
        for _ in range(_MOST_REFINEMENTS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._sticks_after(at, middle) else (low, middle)
        return high

    def _sticks_after(self, at: Motion, span: float) -> bool:
        """Return True if an axis at rest still sticks `span` seconds later."""
        held = self._held.copy()
        self._pass_time(span)
        sticks = self._at_rest(at).sticks
        self._held[:] = held
        return sticks

    def _hold(self, first: tuple[float, ...], recorded: Array) -> None:
        """Store the values that are held between samples.

        Parameters
        ----------
        first : tuple of float
            The force and its final value or control if there is one; for a continuous law its
            inputs.
        recorded : array
            Value and rate of each recorded signal.
        """
        until = len(self._held) - self._recorded
        self._held[:until] = first
        self._held[until:] = recorded

    def _pass_time(self, span: float) -> None:
        """Update the held values that change with time by `span` seconds.

        These are the reference of a continuous law, the force of a drive with a lag, and recorded
        signals.
        """
        if self._continuous:
            self._held[0] += self._held[1] * span
        if self._lagged and self._response is not None:
            self._held[0] = self._response(self._held[0], self._held[1], span)[0]
        if self._recorded:
            lines = self._held[-self._recorded :]
            lines[::2] += lines[1::2] * span

    def _move(self, at: Motion, span: float) -> StepResult:
        """Return a compiled step of `span` seconds in the present mode.

        If recorded signals move kinks, a sticking axis stays where it is.
        """
        if self._moving and at.sticks:
            return StepResult(at, 0.0, 0.0)
        return _moved(at, *self._call("plant_step", at, step=span))

    def _rate(self, at: Motion) -> float:
        """Return the largest rate of change of the motion in the present mode, 1/s."""
        return float(self._call("plant_rate", at)[0][0])

    def _places(self, at: Motion, after: float = 0.0) -> Places:
        """Return the switching functions at a state, with recorded signals `after` s later."""
        if not self._sides:
            return Places((), (), (), ())
        found = self._call("switching", at, step=after)
        values, by_position, by_velocity, *by_time = (tuple(out.tolist()) for out in found)
        return Places(values, by_position, by_velocity, (*by_time, (0.0,) * self._sides)[0])

    def _shifted(self, at: Motion, recorded: Array) -> Motion:
        """Return the state at a sample, after the recorded signals got new values and rates.

        A side changes if a signal has moved the kink or jump past the axis.
        """
        before = self._places(at)
        self._held[-self._recorded :] = recorded
        for i in range(self._sides):
            now = self._places(at)
            value, rate = now.values[i], now.by_time[i]
            if value != before.values[i] or rate:
                at = at.beside(i, float(np.sign(value)) or at.sides[i] or np.sign(rate))
        return at

    def _leaving(self, at: Motion) -> tuple[float, float]:
        """Return the accelerations of an axis at rest with forward and with backward friction."""
        forward, backward = (
            float(self._call("held_acceleration", self._ahead(at, direction))[0][0])
            for direction in (1.0, -1.0)
        )
        return forward, backward

    def _at_rest(self, at: Motion) -> Motion:
        """Return the state at rest with its friction direction.

        The direction is 1 or -1 if the axis leaves rest. If the axis sticks, the direction is the
        value between -1 and 1 with which the acceleration is 0.
        """
        forward, backward = self._leaving(at)
        if forward > 0:
            return at._replace(direction=1.0)
        if backward < 0:
            return at._replace(direction=-1.0)
        # NaN if the force is NaN.
        share = 0.0 if backward == forward else (backward + forward) / (backward - forward)
        return at._replace(direction=STUCK if share >= 1 else -STUCK if share <= -1 else share)

    def _chosen_at_rest(self, at: Motion) -> Motion:
        """Return the state of an axis at rest with the mode in which its motion continues."""
        at = self._at_rest(at)
        return self._slipping(at if at.sticks else self._ahead(at, at.direction))

    def _slipping(self, at: Motion) -> Motion:
        """Return the state with the sides of the limits of internal states.

        An internal state at its limit slips (side -1) if the motion drives the state outwards.
        """
        if self._limits:
            found = self._places(at._replace(dq=0.0))
            for i in self._limits:
                outwards = found.by_position[i] * at.direction < 0
                at = at.beside(i, -1.0 if found.values[i] <= 0 and outwards else 1.0)
        return at

    def _ahead(self, at: Motion, direction: float) -> Motion:
        """Return the state of an axis that leaves rest in a direction.

        If the axis rests exactly at a kink or jump, its side becomes the side that it moves to.
        """
        at = at._replace(dq=0.0, direction=direction)
        if all(at.sides):
            return at
        slopes = self._places(at).by_position
        sides = tuple(
            side or (-1.0 if slope * direction < 0 else 1.0)
            for side, slope in zip(at.sides, slopes, strict=True)
        )
        return at._replace(sides=sides)

    def _beyond(self, at: Motion, first: int) -> Motion:
        """Return the state with its sides from number `first` on set by the switching functions.

        A switching function may depend on the sides before it.
        """
        for i in range(first, self._sides - len(self._limits)):
            found = self._places(at)
            # At a kink or jump exactly at the start, the side follows from the motion.
            side = found.values[i] or at.sides[i] or found.by_position[i] * at.dq
            at = at.beside(i, float(np.sign(side)))
        return at

    def _call(self, name: str, at: Motion, **others: Any) -> list[Array]:
        """Return the results of a function at a state, with further arguments by name."""
        motion = {self._q: at.q, self._dq: at.dq, "held": self._held, "direction": at.direction}
        return self._functions[name]({**motion, "sides": at.sides, "states": at.states, **others})


def _moved(
    at: Motion, q: Array, dq: Array, first: Array, last: Array, *states: Array
) -> StepResult:
    """Return the results of a compiled step, as a state and the accelerations at both ends."""
    remembered = tuple(states[0].tolist()) if states else ()
    end = at._replace(q=float(q[0]), dq=float(dq[0]), states=remembered)
    return StepResult(end, float(first[0]), float(last[0]))
