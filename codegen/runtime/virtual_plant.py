"""The plant between samples in the CasADi virtual machine, mode by mode as in `printers/loop`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from axisid.codegen.lowering import STUCK
from axisid.support.arrays import Array

from .casadi_functions import held_values, is_continuous, recorded_values


@dataclass(frozen=True, slots=True)
class Mode:
    """A friction direction, and a side of each place where the acceleration has a kink or jumps.

    Attributes
    ----------
    direction : float
        Strictly between -1 and 1 if the axis sticks.
    sides : tuple of float
        -1 or 1; 0 if the axis rests in the place itself.
    states : tuple of float
        What friction remembers, where the motion is.
    """

    direction: float
    sides: tuple[float, ...] = ()
    states: tuple[float, ...] = ()

    @property
    def sticks(self) -> bool:
        """Whether the axis sticks."""
        return abs(self.direction) < 1

    def directed(self, direction: float) -> "Mode":
        """The mode in another direction."""
        return replace(self, direction=direction)

    def beside(self, index: int, side: float) -> "Mode":
        """The mode on another side of one place."""
        return replace(self, sides=(*self.sides[:index], side, *self.sides[index + 1 :]))

    def after(self, end: "StepResult") -> "Mode":
        """The mode of a motion after a step."""
        return replace(self, states=end.states) if self.states else self


@dataclass(frozen=True, slots=True)
class StepResult:
    """A motion after a step, and its acceleration at both ends."""

    q: float
    dq: float
    first: float
    last: float
    states: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Switches:
    """What decides the sides, and how it changes with the position and the velocity."""

    values: tuple[float, ...]
    by_position: tuple[float, ...]
    by_velocity: tuple[float, ...]
    by_time: tuple[float, ...] = ()  # where recorded signals move them

    def rate(self, index: int, dq: float, acceleration: float) -> float:
        """How one changes with time."""
        rate = self.by_position[index] * dq + self.by_velocity[index] * acceleration
        return rate + self.moved(index)

    def moved(self, index: int) -> float:
        """How recorded signals change one with time."""
        return self.by_time[index] if self.by_time else 0.0


class BufferedFunction:
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


class VirtualPlant:
    """The plant of one axis, with one parameter set, under what is held.

    Attributes
    ----------
    held : array
        What is held between samples.
    continuous : bool
        Whether that is a reference, which a continuous law follows.
    recorded : int
        Last of what is held: values and rates of recorded signals.
    sides : int
        How many there are.
    moving : bool
        Whether recorded signals move the places in which they change.
    lagged : bool
        Whether the force goes to another, which is held too.
    start_states : tuple of float
        Where internal states start.
    until : float
        Part of a sample after which the last command begins to act; 0 at the sample.
    """

    def __init__(self, functions: Mapping[str, Any], parameters: Array) -> None:
        self._q, self._dq = functions["plant_step"].name_in()[:2]
        names = ("plant_step", "held_acceleration", "switching", "plant_rate")
        self._functions = {
            name: BufferedFunction(functions[name]) for name in names if name in functions
        }
        for function in self._functions.values():
            function.arguments["parameters"][:] = parameters
        self.held = np.zeros(functions["held_acceleration"].size1_in("held"))
        self.continuous = is_continuous(functions)
        self.recorded = recorded_values(functions)
        switching = functions.get("switching")
        self.sides = 0 if switching is None else switching.size1_in("sides")
        self.moving = switching is not None and "held" in switching.name_in()
        begin = functions.get("state_start")
        self.start_states: tuple[float, ...] = ()
        self._limits = range(0)
        if begin is not None:
            start, first = begin(parameters)
            self.start_states = tuple(start.full().ravel().tolist())
            self._limits = range(int(first), self.sides)
        self._response = functions.get("drive_response")
        self.lagged = held_values(functions) == len(("tau", "target"))
        self.until = 0.0 if self._response is None else float(self._response(0.0, 0.0, 1.0)[1])

    @property
    def drifts(self) -> bool:
        """Whether what is held changes between samples, so that an axis may leave rest there."""
        return self.continuous or self.lagged or self.recorded > 0

    def hold(self, first: tuple[float, ...], recorded: Array) -> None:
        """Hold a force or what a continuous law follows, and recorded signals from there on."""
        until = len(self.held) - self.recorded
        self.held[:until] = first
        self.held[until:] = recorded

    def move(self, q: float, dq: float, mode: Mode, span: float) -> StepResult:
        """Take one step in a mode."""
        if self.moving and mode.sticks:
            return StepResult(q, 0.0, 0.0, 0.0)
        end = self._call("plant_step", q, dq, mode, step=span)
        states = tuple(end[4].tolist()) if mode.states else ()
        q_next, dq_next, first, last = (float(value[0]) for value in end[:4])
        return StepResult(q_next, dq_next, first, last, states)

    def accelerate(self, q: float, dq: float, mode: Mode) -> float:
        """Acceleration in a mode."""
        return float(self._call("held_acceleration", q, dq, mode)[0][0])

    def force(self, q: float, dq: float, mode: Mode) -> float:
        """Force in a mode."""
        return float(self._call("held_acceleration", q, dq, mode)[1][0])

    def rate(self, q: float, dq: float, mode: Mode) -> float:
        """How fast the motion may change in a mode, 1/s."""
        return float(self._call("plant_rate", q, dq, mode)[0][0])

    def switches(self, q: float, dq: float, mode: Mode, after: float = 0.0) -> Switches:
        """What decides the sides, with recorded signals as they are `after` seconds later."""
        if not self.sides:
            return Switches((), (), ())
        later = {"step": after} if self.moving else {}
        found = self._call("switching", q, dq, mode, **later)
        return Switches(*(tuple(out.tolist()) for out in found))

    def shifted(self, q: float, dq: float, mode: Mode, recorded: Array) -> Mode:
        """The sides at a sample from which recorded signals go on otherwise than before it."""
        before = self.switches(q, dq, mode)
        self.held[-self.recorded :] = recorded
        for i in range(self.sides):
            now = self.switches(q, dq, mode)
            value, moved = now.values[i], now.moved(i)
            if value != before.values[i] or moved:
                mode = mode.beside(i, float(np.sign(value)) or mode.sides[i] or np.sign(moved))
        return mode

    def leaving(self, q: float, mode: Mode) -> tuple[float, float]:
        """Accelerations with which an axis at rest would leave, forward and backward."""
        ahead, behind = (self.ahead(q, mode.directed(s)) for s in (1.0, -1.0))
        return self.accelerate(q, 0.0, ahead), self.accelerate(q, 0.0, behind)

    def at_rest(self, q: float, mode: Mode) -> Mode:
        """Direction at zero velocity; strictly between -1 and 1 if the axis sticks."""
        forward, backward = self.leaving(q, mode)
        if forward > 0:
            return mode.directed(1.0)
        if backward < 0:
            return mode.directed(-1.0)
        # Not a number if the force is not one.
        share = 0.0 if backward == forward else (backward + forward) / (backward - forward)
        return mode.directed(STUCK if share >= 1 else -STUCK if share <= -1 else share)

    def chosen_at_rest(self, q: float, mode: Mode) -> Mode:
        """The mode of an axis at rest that may leave."""
        mode = self.at_rest(q, mode)
        return self.slipping(q, self.ahead(q, mode) if abs(mode.direction) >= 1 else mode)

    def slipping(self, q: float, mode: Mode) -> Mode:
        """The sides of limits of states: one at its limit slips if the motion goes outwards."""
        if not self._limits:
            return mode
        found = self.switches(q, 0.0, mode)
        for i in self._limits:
            outwards = found.by_position[i] * mode.direction < 0
            mode = mode.beside(i, -1.0 if found.values[i] <= 0 and outwards else 1.0)
        return mode

    def ahead(self, q: float, mode: Mode) -> Mode:
        """The sides of an axis that leaves rest: where it rested in a place, the one ahead."""
        if all(mode.sides):
            return mode
        slopes = self.switches(q, 0.0, mode).by_position
        sides = tuple(
            side or (-1.0 if slope * mode.direction < 0 else 1.0)
            for side, slope in zip(mode.sides, slopes, strict=True)
        )
        return replace(mode, sides=sides)

    def beyond(self, q: float, dq: float, mode: Mode, first: int) -> Mode:
        """The sides at a state, from one on; one may depend on those before it."""
        for i in range(first, self.sides - len(self._limits)):
            found = self.switches(q, dq, mode)
            # One that begins in a place leaves it as it moves.
            side = found.values[i] or mode.sides[i] or found.by_position[i] * dq
            mode = mode.beside(i, float(np.sign(side)))
        return mode

    def pass_time(self, span: float) -> None:
        """What is held, `span` seconds later."""
        if self.continuous:
            self.held[0] += self.held[1] * span
        if self.lagged and self._response is not None:
            self.held[0] = self._response(self.held[0], self.held[1], span)[0]
        if self.recorded:
            lines = self.held[-self.recorded :]
            lines[::2] += lines[1::2] * span

    def sticks_after(self, q: float, mode: Mode, span: float) -> bool:
        """Whether an axis at rest sticks `span` seconds later."""
        held = self.held.copy()
        self.pass_time(span)
        sticks = self.at_rest(q, mode).sticks
        self.held[:] = held
        return sticks

    def _call(self, name: str, q: float, dq: float, mode: Mode, **others: float) -> list[Array]:
        function = self._functions[name]
        arguments = function.arguments
        if "held" in arguments:
            arguments["held"][:] = self.held
        if "direction" in arguments:
            arguments["direction"][0] = mode.direction
        if self.sides:
            arguments["sides"][:] = mode.sides
        if mode.states:
            arguments["states"][:] = mode.states
        return function(**{self._q: q, self._dq: dq}, **others)
