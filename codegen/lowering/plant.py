"""The plant between samples as programs: the motion in one mode, and its rate of change.

A mode is a friction direction and, if the acceleration has kinks or jumps over the position, the
side of each of them (see `switching`). Programs have the argument ``sides`` only in this case.
"""

from dataclasses import dataclass, replace

import sympy

from axisid.modeling.declaration import FORCE_TARGET
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import DIRECTION, FORCE, Signal, slope

from .drive import DriveInMode, acting_from_sample, drive_response, forces_in_step, later_force
from .expressions import Arguments, Lowering
from .friction_states import STATES, Remembering, state_dynamics, state_start, with_mode
from .loop_interface import (
    HELD_REFERENCE,
    PHASE_PER_STEP,
    PROBE,
    PROBED,
    RESOLVED,
    RESOLVED_STATES,
)
from .program import Program
from .switching import Switching, largest_wave, switching, wave_number

#: Name of the vector of the law's gains, if they are arguments.
GAINS = "law_gains"
_Lines = tuple[tuple[int, int], ...]  # operations of value and rate of each recorded signal


def plant_programs(
    model: AxisModel, law: Program | None, acceleration: Program
) -> tuple[Program, ...]:
    """Return the programs of the plant for the time loop.

    Parameters
    ----------
    model : AxisModel
    law : Program or None
        The control law, to which a test signal may be added; used only if it is continuous.
    acceleration : Program
        The direct dynamics, as declared. With sides or internal states the acceleration in one mode
        is used instead.

    Returns
    -------
    tuple of Program
        ``held_acceleration`` and ``plant_step``. In addition: ``switching`` if there are sides (of
        kinks or jumps over the position or a recorded signal, or of limits of internal states);
        ``plant_rate`` if there are sides or internal states; otherwise ``wave_number`` if the
        acceleration has wave numbers; ``drive_response`` for a drive whose force changes between
        samples; ``state_start`` if there are internal states.
    """
    found = switching(model)
    if found.sides or model.states:
        q = model.axis.coordinate
        motion = (q.symbol, q.velocity, FORCE, DIRECTION, *model.axis.signal_symbols)
        arguments = with_mode(Arguments().scalars(*motion), model, found)
        acceleration = arguments.lower(acceleration=[[found.acceleration]]).program(
            "acceleration_by_sides", "Acceleration in one mode."
        )
    # A builder collects the outputs of one program, so each program needs a plant in a new builder.
    held = _plant(model, law, acceleration, found)
    name = model.axis.coordinate.acceleration.name
    held.builder.output(name, [[held.accelerate(*held.motion, None)]])
    held.builder.output("tau", [[held.force(*held.motion, None)]])
    programs = [
        held.builder.program(
            "held_acceleration",
            "Acceleration and force under the values held since the last sample.",
        ),
        _plant_step(_plant(model, law, acceleration, found)),
    ]
    if found.sides:
        programs.append(_switching(model, found))
    if found.sides or model.states:
        programs.append(_plant_rate(_plant(model, law, acceleration, found), found))
    elif found.wave_numbers:
        programs.append(wave_number(model, found))
    response = model.axis.response
    if response is not None and not response.is_held:
        programs.append(drive_response(response))
    if model.states:
        programs.append(state_start(model, found))
    return tuple(programs)


def _switching(model: AxisModel, found: Switching) -> Program:
    """Return the program of the switching functions and their derivatives.

    If recorded signals occur in them, ``step`` is a further argument: the signals have the values
    that they reach after this time, s.
    """
    q = model.axis.coordinate
    # With the same reciprocals as in a step, a state at its limit is exactly equal to the limit.
    arguments = Arguments(reciprocals=bool(model.states)).scalars(q.symbol, q.velocity)
    lines: _Lines = ()
    if found.moved_by:
        _, lines = _held(arguments, model)
    with_mode(arguments, model, found)
    following = {state.symbol for state in model.states if state.limit is not None}
    slopes = {
        name: [[_slope(value, by, following) for value in found.functions]]
        for name, by in (("by_position", {q.symbol, *following}), ("by_velocity", {q.velocity}))
    }
    if found.moved_by:
        # Values of the signals on their straight lines after `step` seconds.
        step = arguments.scalar("step")
        rates: dict[Signal, sympy.Symbol] = {}
        for signal, (value, rate) in zip(model.axis.signals, lines, strict=True):
            later = arguments.apply("add", value, arguments.apply("mul", rate, step))
            rates[signal] = sympy.Symbol(signal.rate_name, real=True)
            arguments.values |= {signal.symbol: later, rates[signal]: rate}
        slopes["by_time"] = [
            [
                sum(
                    slope(each, s.symbol, "a switching function") * rates[s] for s in found.moved_by
                )
                for each in found.functions
            ]
        ]
    return arguments.lower(switches=[found.functions], **slopes).program(
        "switching", "Values whose signs are the sides, and their rates of change."
    )


def _slope(value: sympy.Expr, by: set[sympy.Symbol], following: set[sympy.Symbol]) -> sympy.Expr:
    """Return the sum of a switching function's derivatives with respect to the symbols `by`.

    The symbols `following` are internal states with a limit, which change like the position. They
    are left out if the function does not depend on any of them.
    """
    symbols = by if value.free_symbols & following else by - following
    return sum(slope(value, symbol, "a switching function") for symbol in symbols)


@dataclass(frozen=True, slots=True)
class _Plant:
    """The plant between two samples, with the values that are held, in a program being built.

    Under a sampled law the force is held. With a lag the force moves to a final value, which is
    held too. If the drive's force depends on the motion, the control is held as the second value
    instead. A continuous law is evaluated inside the plant's derivative; the held values are then
    the reference with its rate, the measurement error and the test signal that is added to the
    control. Each recorded signal follows a straight line.

    Attributes
    ----------
    model : AxisModel
    law : Program or None
        A continuous control law; None for a sampled one.
    acceleration : Program
        The direct dynamics in one mode.
    builder : Arguments
        Builder of the program. Each int below is the index of one of its operations.
    motion : (int, int)
        Position and velocity at the start.
    held : tuple of int
        Values held between samples, in the order of `_held_names`.
    recorded : tuple of (int, int)
        Value and rate of each recorded signal at the start.
    mode : tuple of tuple of int
        The friction direction, and the sides if there are any.
    parameters : tuple of int
    found : Switching
        The acceleration with sides instead of its kinks and jumps.
    states : tuple of int
        Internal states of friction at the start.
    """

    model: AxisModel
    law: Program | None
    acceleration: Program
    builder: Arguments
    motion: tuple[int, int]
    held: tuple[int, ...]
    recorded: _Lines
    mode: tuple[tuple[int, ...], ...]
    parameters: tuple[int, ...]
    found: Switching
    states: tuple[int, ...] = ()

    def force(self, q: int, dq: int, elapsed: int | None) -> int:
        """Return the force at a position and velocity, `elapsed` seconds after the start.

        None as `elapsed` means at the start.
        """
        if self.law is None:
            response = self.model.axis.response
            if response is not None and response.holds_control:
                return self._force_of(self.held[1], q, dq, elapsed)
            return self.held[0]
        reference, rate, error, injected = self.held
        reference = self._later(reference, rate, elapsed)
        measured = self.builder.apply("add", q, error)
        signals = self._signals(elapsed)
        law = self.builder.inline(
            self.law, (reference,), (measured,), (dq,), *signals, (injected,), ()
        )
        return self._force_of(law["control"][0], q, dq, elapsed)

    def _force_of(self, control: int, q: int, dq: int, elapsed: int | None) -> int:
        """Return the force that the drive produces for a control; other arguments as in `force`."""
        signals = self._signals(elapsed)
        return DriveInMode(self.builder, self.model, self.mode[0], signals).force(control, q, dq)

    def accelerate(self, q: int, dq: int, elapsed: int | None, tau: int | None = None) -> int:
        """Return the acceleration at a position and velocity, `elapsed` seconds after the start.

        None as `elapsed` means at the start; `tau` is the force, by default that of `force`.
        """
        tau = self.force(q, dq, elapsed) if tau is None else tau
        direction, *sides = self.mode
        motion = ((q,), (dq,), (tau,), direction, *self._signals(elapsed))
        states = (self.states,) if self.states else ()
        (indices,) = self.builder.inline(
            self.acceleration, *motion, *sides, *states, self.parameters
        ).values()
        return indices[0]

    def _signals(self, elapsed: int | None) -> list[tuple[int]]:
        """Return the value of each recorded signal `elapsed` seconds after the start."""
        return [(self._later(value, rate, elapsed),) for value, rate in self.recorded]

    def _later(self, value: int, rate: int, elapsed: int | None) -> int:
        """Return a value on a straight line `elapsed` seconds after the start (None: at it)."""
        if elapsed is None:
            return value
        return self.builder.apply("add", value, self.builder.apply("mul", rate, elapsed))


def _remembering(plant: _Plant) -> Remembering:
    """Return the integrator of motion and internal states under the held force."""
    limits, lower = plant.found.limits, Lowering(plant.builder, plant.builder.values)
    return Remembering(
        builder=plant.builder,
        dynamics=state_dynamics(plant.model, plant.found),
        force=plant.force(*plant.motion, None),
        mode=plant.mode,
        parameters=plant.parameters,
        limited=tuple(
            None if state.limit is None else (lower(limits[i]), lower(state.limit))
            for i, state in enumerate(plant.model.states)
        ),
    )


def _held_names(model: AxisModel) -> tuple[str, ...]:
    """Return the names of the values held between samples, without recorded signals.

    For a sampled law this is the force; with a lag also its final value, or the control if the
    control is held while the force depends on the motion. For a continuous law these are its
    inputs.
    """
    law, response = model.axis.control, model.axis.response
    if law is not None and law.continuous:
        return HELD_REFERENCE
    if response is None or not response.keeps_force:
        return ("tau",)
    return ("tau", FORCE_TARGET if response.lag else "held_control")


def _recorded_names(model: AxisModel) -> tuple[str, ...]:
    """Return the names of value and rate of each recorded signal, in turn."""
    return tuple(name for s in model.axis.signals for name in (s.name, s.rate_name))


def _held(arguments: Arguments, model: AxisModel) -> tuple[tuple[int, ...], _Lines]:
    """Declare the argument ``held``; return the held values, and value and rate of each signal."""
    names = _held_names(model)
    vector = arguments.vector("held", (*names, *_recorded_names(model)))
    lines = vector[len(names) :]
    return tuple(vector[: len(names)]), tuple(zip(lines[::2], lines[1::2], strict=True))


def _plant(
    model: AxisModel, law: Program | None, acceleration: Program, found: Switching
) -> _Plant:
    """Return the plant with its arguments declared in a new builder."""
    q = model.axis.coordinate
    arguments = Arguments(reciprocals=True).scalars(q.symbol, q.velocity)
    names, signals = _held_names(model), model.axis.signal_symbols
    held, recorded = _held(arguments, model)
    arguments.values.update((s, value) for s, (value, _) in zip(signals, recorded, strict=True))
    values = with_mode(arguments.scalars(DIRECTION), model, found).values
    sides = tuple(values[side] for side in found.sides)
    return _Plant(
        model=model,
        law=law if names == HELD_REFERENCE else None,
        acceleration=acceleration,
        builder=arguments,
        motion=(values[q.symbol], values[q.velocity]),
        held=held,
        recorded=recorded,
        mode=((values[DIRECTION],), sides) if sides else ((values[DIRECTION],),),
        parameters=tuple(values[p.symbol] for p in model.axis.parameters),
        found=found,
        states=tuple(values[state.symbol] for state in model.states),
    )


def _plant_step(plant: _Plant) -> Program:
    """Return the program of one step of the motion in one mode.

    Its results are position, velocity and internal states at the end of the step, and the
    acceleration at both ends.
    """
    names, builder = plant.model.axis.coordinate, plant.builder
    step, states = builder.scalar("step"), list[int]()
    # Rodas4 with internal states, otherwise the classical Runge-Kutta method.
    if plant.states:
        q, dq, *states = _remembering(plant).step((*plant.motion, *plant.states), step)
        first = plant.accelerate(*plant.motion, None)
        last = replace(plant, states=tuple(states)).accelerate(q, dq, None)
    else:
        q, dq, first, last = _runge_kutta(plant, step)
    builder.output(f"{names.name}_next", [[q]])
    builder.output(f"{names.velocity}_next", [[dq]])
    builder.output("first_slope", [[first]])
    builder.output("last_slope", [[last]])
    what, how = "Motion", "RK4"
    if states:
        builder.output(f"next_{STATES}", [[z] for z in states])
        what, how = "Motion and states", "Rodas4"
    about = f"{what} `step` seconds later in one friction mode ({how}), and its slopes."
    return builder.program("plant_step", about)


def _runge_kutta(plant: _Plant, step: int) -> tuple[int, int, int, int]:
    """Return position and velocity after a classical Runge-Kutta step, and two accelerations.

    The accelerations are those at the start and at the end of the step.
    """
    builder, build = plant.builder, plant.builder.apply
    q, dq = plant.motion

    def ahead(slopes: tuple[int, int], length: int) -> tuple[int, int]:
        """Return position and velocity at the start plus `length` times the rates `slopes`."""
        moved = [
            build("add", start, build("mul", length, slope))
            for start, slope in zip((q, dq), slopes, strict=True)
        ]
        return moved[0], moved[1]

    def slopes(
        state: tuple[int, int], elapsed: int | None, tau: int | None = None
    ) -> tuple[int, int]:
        """Return the rates of position and velocity: velocity and acceleration."""
        return state[1], plant.accelerate(*state, elapsed, tau)

    # With a lag, the forces of the four evaluations give the exact integrals over the step.
    half, two = build("mul", builder.constant(0.5), step), builder.constant(2)
    response = plant.model.axis.response
    lag = 0.0 if response is None else response.lag
    forces = forces_in_step(builder, lag, plant.held[:2], step) if lag else (None,) * 3
    k1 = slopes((q, dq), None)
    k2 = slopes(ahead(k1, half), half, forces[0])
    k3 = slopes(ahead(k2, half), half, forces[1])
    k4 = slopes(ahead(k3, step), step, forces[2])
    total = [
        build("add", build("add", a, d), build("mul", two, build("add", b, c)))
        for a, b, c, d in zip(k1, k2, k3, k4, strict=True)
    ]
    end = ahead((total[0], total[1]), build("mul", builder.constant(1 / 6), step))
    if lag:
        tau = later_force(builder, lag, plant.held[:2], step)
        return *end, k1[1], plant.accelerate(*end, step, tau)
    return *end, k1[1], k4[1]


def _plant_rate(plant: _Plant, found: Switching) -> Program:
    """Return the program of the largest rate of change of the motion in one mode, 1/s.

    It follows from the damping, the stiffness and the wave numbers of the acceleration. The rate
    times the step should be at most `RESOLVED`.
    """
    builder, build, (q, dq) = plant.builder, plant.builder.apply, plant.motion
    wave, resolved = builder.constant(0), builder.constant(RESOLVED / PHASE_PER_STEP)
    if found.wave_numbers:
        wave = largest_wave(plant.builder, found.wave_numbers)
    if plant.states:
        scale = builder.constant(RESOLVED / RESOLVED_STATES)
        rate = build("mul", scale, _remembering(plant).rate((q, dq, *plant.states)))
    else:
        rate = _probed_rate(plant, wave if found.wave_numbers else None)
        if found.by_velocity:
            # The force varies strongly with the velocity near rest, as at a Stribeck peak. A step
            # may change the velocity only by a part of the velocity plus the width of the peak.
            largest = largest_wave(plant.builder, found.by_velocity)  # 1 over the width
            speed, change = build("abs", dq), build("abs", plant.accelerate(q, dq, None))
            reach = build("add", builder.constant(1), build("mul", largest, speed))
            share = build("mul", change, build("div", largest, reach))
            rate = build("max", rate, build("mul", resolved, share))
    passing = build("mul", resolved, build("mul", build("abs", dq), wave))
    builder.output("plant_rate", [[build("max", rate, passing)]])
    return builder.program("plant_rate", "Largest rate of change of the motion in one mode, 1/s.")


def _probed_rate(plant: _Plant, wave: int | None) -> int:
    """Return the larger of the rates of damping and stiffness, 1/s, by finite differences.

    `wave` is the largest wave number, which shortens the difference of the position; None if there
    is no wave number.
    """
    builder, build, (q, dq) = plant.builder, plant.builder.apply, plant.motion
    probe = way = builder.constant(PROBE)
    if wave is not None:
        shorter = build("mul", builder.constant(PROBE / PROBED), wave)
        way = build("div", probe, build("add", builder.constant(1), shorter))
    here = plant.accelerate(q, dq, None)

    def changed(q: int, dq: int, by: int) -> int:
        """Return the absolute change of the acceleration over the change `by` of the motion."""
        difference = build("sub", plant.accelerate(q, dq, None), here)
        return build("abs", build("div", difference, by))

    damping = changed(q, build("add", dq, probe), probe)
    stiffness = changed(build("add", q, way), dq, way)
    return build("max", damping, build("sqrt", stiffness))


def closed_loop_step(model: AxisModel, law: Program, plant: Program) -> Program:
    """Return the program of one sample of the loop: control law, drive, a step of the plant.

    The law reads the position with its measurement error. The drive turns the control into a force.
    The plant moves for ``step`` seconds with the held values. The results are the motion and the
    state of law and drive at the next sample; force, control and acceleration at this sample; and
    the acceleration at the end of the step.

    Parameters
    ----------
    model : AxisModel
    law : Program
        Control law, to which a test signal may be added. Gains that it takes come after the
        parameters.
    plant : Program
        ``plant_step``.
    """
    # Arguments: motion, state of law and drive, inputs of the law, recorded signals.
    coordinate = model.axis.coordinate
    q, dq, ddq = coordinate.symbol, coordinate.velocity, coordinate.acceleration
    builder = Arguments(reciprocals=True).scalars(q, dq)
    values = builder.values
    ports = {port.name: port for port in law.inputs}
    state_port = ports["state"]
    response = model.axis.response
    drive = () if response is None else response.remembered
    remembered = builder.vector("state", (*state_port.elements, *drive))
    count = len(state_port.elements)
    state = remembered[:count]
    held = tuple(map(builder.scalar, HELD_REFERENCE))
    reference, _, error, injected = held
    names = _recorded_names(model)
    lines = builder.vector("signals", names) if names else ()  # value and rate of each signal
    signals = [(value,) for value in lines[::2]]
    names = ports[GAINS].elements if GAINS in ports else ()
    # The direction, the sides if there are any, the parameters with the gains, and the step.
    *mode, own, step = plant.inputs[3:]
    others = [builder.vector(port.name, port.elements) for port in mode]
    theta = builder.vector(own.name, (*own.elements, *names))
    others += [theta[: len(own.elements)], builder.vector(step.name, step.elements)]
    gains = (theta[len(own.elements) :],) if names else ()
    # Evaluate the law with the measured position, then the drive, then the plant.
    measured = builder.apply("add", values[q], error)
    control = builder.inline(
        law, (reference,), (measured,), (values[dq],), *signals, (injected,), state, *gains
    )

    def slope(tau: int) -> int:
        """Return the acceleration at the sample under the force `tau`."""
        under = builder.inline(plant, (values[q],), (values[dq],), (tau, tau, *lines), *others)
        return under["first_slope"][0]

    drive_here = DriveInMode(builder, model, others[0], signals)
    motion = (values[q], values[dq])
    tau, acting, following = acting_from_sample(
        drive_here, control["control"][0], motion, remembered[count:], slope
    )
    held = held if _held_names(model) == HELD_REFERENCE else acting
    end = builder.inline(plant, (values[q],), (values[dq],), (*held, *lines), *others)
    builder.output(f"{q.name}_next", [end[f"{q.name}_next"]])
    builder.output(f"{dq.name}_next", [end[f"{dq.name}_next"]])
    builder.output("next_state", [[index] for index in (*control["next_state"], *following)])
    builder.output(ddq.name, [end["first_slope"]])
    builder.output("tau", [[tau]])
    builder.output("control", [control["control"]])
    builder.output("last_slope", [end["last_slope"]])
    if model.states:
        builder.output(f"next_{STATES}", [[z] for z in end[f"next_{STATES}"]])
    return builder.program(
        "closed_loop_step",
        "One sample: measure, control, move for `step` seconds in one friction mode.",
    )
