"""The set of functions every axis gets, as programs built from its model.

All arguments are SI. ``parameters`` are the physical ones in the axis's order; ``direction`` is the
friction direction (sign of the velocity while sliding).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from axisid.modeling import (
    DIRECTION,
    FORCE,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    AxisModel,
    ControlLaw,
    gain,
)

from .lower import Lowering
from .program import Builder, Program

# What is held between samples, under a sampled law and under a continuous one.
HELD_FORCE = ("tau",)
HELD_REFERENCE = ("reference", "reference_rate", "measurement_error")


def axis_programs(model: AxisModel) -> tuple[Program, ...]:
    """Build every function the model allows.

    Without a direct regressor there are no ``ddm_regressor`` and no parameter map; without a
    control law there is no closed loop.
    """
    acceleration = _direct_dynamics(model)
    programs = [inverse_dynamics(model), _idm_regressor(model), acceleration]
    programs += _direct_regressor(model)
    law = None if model.axis.control is None else _control_law(model, model.axis.control)
    plant = _plant_step(model, law, acceleration)
    programs += [_held_acceleration(model, law, acceleration), plant]
    if law is not None and model.axis.control is not None:
        start = _control_start(model, model.axis.control)
        programs += [
            start,
            law,
            _control_terms(model.axis.control),
            _closed_loop_step(model, law, plant),
        ]
    return tuple(programs)


class _Arguments:
    """A builder with arguments declared by SymPy symbol."""

    def __init__(self, *, reciprocals: bool = False) -> None:
        self.builder = Builder(reciprocals=reciprocals)
        self.values: dict[sympy.Symbol, int] = {}

    def scalars(self, *symbols: sympy.Symbol) -> "_Arguments":
        for symbol in symbols:
            self.values[symbol] = self.builder.scalar(symbol.name)
        return self

    def vector(self, name: str, symbols: Sequence[sympy.Symbol]) -> "_Arguments":
        indices = self.builder.vector(name, [symbol.name for symbol in symbols])
        self.values.update(zip(symbols, indices, strict=True))
        return self

    def lower(self, **outputs: Sequence[Sequence[sympy.Expr]]) -> Builder:
        lowering = Lowering(self.builder, self.values)
        for name, rows in outputs.items():
            self.builder.output(name, [[lowering(e) for e in row] for row in rows])
        return self.builder


def _motion(model: AxisModel, *, force: bool) -> _Arguments:
    q = model.axis.coordinate
    third = FORCE if force else q.acceleration
    return _Arguments().scalars(q.symbol, q.velocity, third, DIRECTION)


def _parameters(model: AxisModel) -> list[sympy.Symbol]:
    return [p.symbol for p in model.axis.parameters]


def inverse_dynamics(model: AxisModel) -> Program:
    """The force that a motion needs, by friction direction and parameters."""
    arguments = _motion(model, force=False).vector("parameters", _parameters(model))
    return arguments.lower(tau=[[model.force]]).program(
        "inverse_dynamics", "Force that the motion needs."
    )


def _idm_regressor(model: AxisModel) -> Program:
    arguments, about = _motion(model, force=False), "tau = row . parameters + known."
    if model.idm.nonlinear:
        arguments = arguments.vector("parameters", _parameters(model))
        about = "tau = row . parameters + known, linearised about the parameters."
    builder = arguments.lower(row=[model.idm.columns], known=[[model.idm.known]])
    return builder.program("idm_regressor", about)


def _direct_dynamics(model: AxisModel) -> Program:
    arguments = _motion(model, force=True).vector("parameters", _parameters(model))
    name = model.axis.coordinate.acceleration.name
    return arguments.lower(**{name: [[model.acceleration]]}).program(
        "direct_dynamics", "Acceleration that the force causes."
    )


def _direct_regressor(model: AxisModel) -> list[Program]:
    if model.ddm is None or model.parameter_map is None:
        return []
    row, mapping = model.ddm.regressor, model.parameter_map
    builder = _motion(model, force=True).lower(row=[row.columns], known=[[row.known]])
    forward = _Arguments().vector("parameters", mapping.parameters)
    programs = [
        builder.program("ddm_regressor", "ddq = row . ddm_parameters + known."),
        forward.lower(
            ddm_parameters=mapping.forward.tolist(), jacobian=mapping.forward_jacobian.tolist()
        ).program("ddm_from_physical", "Parameters of the direct model, and the Jacobian."),
    ]
    if mapping.inverse is not None and mapping.inverse_jacobian is not None:
        backward = _Arguments().vector("ddm_parameters", mapping.symbols)
        programs.append(
            backward.lower(
                parameters=mapping.inverse.tolist(), jacobian=mapping.inverse_jacobian.tolist()
            ).program("physical_from_ddm", "Physical parameters, and the Jacobian.")
        )
    return programs


def _state(law: ControlLaw) -> tuple[str, ...]:
    """Names of what the drive remembers between samples: the law's memory, then the delay line."""
    return (*(memory.name for memory in law.memory), *law.delay_line)


def _control_start(model: AxisModel, law: ControlLaw) -> Program:
    arguments = _Arguments().scalars(REFERENCE, MEASURED_POSITION)
    builder = arguments.builder
    lowering = Lowering(builder, arguments.values)
    memory = [lowering(memory.start) for memory in law.memory]
    values = {m.symbol: index for m, index in zip(law.memory, memory, strict=True)}
    rest = {MEASURED_VELOCITY: builder.constant(0.0)}
    first = _output(model, law, builder, {**arguments.values, **values, **rest})
    builder.output("state", [[index] for index in (*memory, *[first] * law.delay)])
    return builder.program("control_start", "What the drive remembers of an axis at rest.")


def _output(
    model: AxisModel, law: ControlLaw, builder: Builder, values: dict[sympy.Symbol, int]
) -> int:
    """The law's output within the drive's limit."""
    control = _law_lowering(law, builder, values)(law.output)
    return within(model.axis.drive.limit, builder, control)


def within(limit: float, builder: Builder, value: int) -> int:
    """A value clipped at plus and minus a limit; infinite for none."""
    if limit == float("inf"):
        return value
    # Selected, not min and max: those would turn a control that is not a number into the limit.
    upper, lower = builder.constant(limit), builder.constant(-limit)
    value = builder.apply("select", builder.apply("lt", upper, value), upper, value)
    return builder.apply("select", builder.apply("lt", value, lower), lower, value)


def _law_lowering(law: ControlLaw, builder: Builder, values: dict[sympy.Symbol, int]) -> Lowering:
    known = {gain(name): builder.constant(value) for name, value in law.gains.items()}
    return Lowering(builder, {**values, **known, PERIOD: builder.constant(law.period)})


def _control_law(model: AxisModel, law: ControlLaw) -> Program:
    arguments = _Arguments().scalars(REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY)
    builder, values = arguments.builder, arguments.values
    state = builder.vector("state", _state(law))
    memory = {m.symbol: index for m, index in zip(law.memory, state, strict=False)}
    line = state[len(law.memory) :]
    following = _law_lowering(law, builder, {**values, **memory})
    control = _output(model, law, builder, {**values, **memory})
    queue = (control, *line)
    builder.output("control", [[queue[-1]]])
    builder.output(
        "next_state",
        [[following(m.following)] for m in law.memory] + [[index] for index in queue[:-1]],
    )
    return builder.program("control_law", "Control that the drive applies, within its limit.")


def _control_terms(law: ControlLaw) -> Program:
    arguments = _Arguments().scalars(REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY)
    builder, values = arguments.builder, arguments.values
    state = builder.vector("state", _state(law))
    memory = {m.symbol: index for m, index in zip(law.memory, state, strict=False)}
    lower = _law_lowering(law, builder, {**values, **memory})
    builder.output("row", [[lower(factor * signal) for factor, signal in law.terms]])
    return builder.program(
        "control_terms", "What the law adds up, one number for each product of gains."
    )


@dataclass(frozen=True, slots=True)
class _Plant:
    """The plant under what is held between samples, as operations of one builder.

    A sampled law holds its force. A continuous law is evaluated inside the plant's derivative; held
    are the line that the reference follows and the error of the measurement.
    """

    model: AxisModel
    law: Program | None
    acceleration: Program
    builder: Builder
    held: tuple[int, ...]
    direction: int
    parameters: tuple[int, ...]

    def force(self, q: int, dq: int, elapsed: int | None) -> int:
        """Force at a state, some time into the period."""
        if self.law is None:
            return self.held[0]
        build = self.builder.apply
        reference, rate, error = self.held
        if elapsed is not None:
            reference = build("add", reference, build("mul", rate, elapsed))
        measured = build("add", q, error)
        law = self.builder.inline(self.law, (reference,), (measured,), (dq,), ())
        return build("mul", self.builder.constant(self.model.axis.drive.gain), *law["control"])

    def accelerate(self, q: int, dq: int, elapsed: int | None) -> int:
        """Acceleration at a state, some time into the period."""
        tau = self.force(q, dq, elapsed)
        arguments = ((q,), (dq,), (tau,), (self.direction,), self.parameters)
        (indices,) = self.builder.inline(self.acceleration, *arguments).values()
        return indices[0]


def _held_names(model: AxisModel) -> tuple[str, ...]:
    law = model.axis.control
    return HELD_REFERENCE if law is not None and law.continuous else HELD_FORCE


def _plant_arguments(
    model: AxisModel, law: Program | None, acceleration: Program
) -> tuple[_Plant, int, int]:
    q = model.axis.coordinate
    arguments = _Arguments(reciprocals=True).scalars(q.symbol, q.velocity)
    builder, values = arguments.builder, arguments.values
    held = builder.vector("held", _held_names(model))
    direction = builder.scalar("direction")
    parameters = builder.vector("parameters", [p.name for p in model.axis.parameters])
    continuous = law if len(held) > 1 else None
    plant = _Plant(model, continuous, acceleration, builder, held, direction, parameters)
    return plant, values[q.symbol], values[q.velocity]


def _held_acceleration(model: AxisModel, law: Program | None, acceleration: Program) -> Program:
    plant, q, dq = _plant_arguments(model, law, acceleration)
    plant.builder.output(model.axis.coordinate.acceleration.name, [[plant.accelerate(q, dq, None)]])
    plant.builder.output("tau", [[plant.force(q, dq, None)]])
    return plant.builder.program(
        "held_acceleration", "Acceleration and force under what is held since the last sample."
    )


def _plant_step(model: AxisModel, law: Program | None, acceleration: Program) -> Program:
    plant, q, dq = _plant_arguments(model, law, acceleration)
    names = model.axis.coordinate
    end_q, end_dq, first, last = _runge_kutta(plant, q, dq, plant.builder.scalar("step"))
    plant.builder.output(f"{names.name}_next", [[end_q]])
    plant.builder.output(f"{names.velocity}_next", [[end_dq]])
    plant.builder.output("first_slope", [[first]])
    plant.builder.output("last_slope", [[last]])
    return plant.builder.program(
        "plant_step", "Motion `step` seconds later in one friction mode (RK4), and its slopes."
    )


def _runge_kutta(plant: _Plant, q: int, dq: int, step: int) -> tuple[int, int, int, int]:
    """Classical fourth-order step: position, velocity, and acceleration at both ends."""
    builder, build = plant.builder, plant.builder.apply

    def ahead(slopes: tuple[int, int], length: int) -> tuple[int, int]:
        moved = [
            build("add", start, build("mul", length, slope))
            for start, slope in zip((q, dq), slopes, strict=True)
        ]
        return moved[0], moved[1]

    def slopes(state: tuple[int, int], elapsed: int | None) -> tuple[int, int]:
        return state[1], plant.accelerate(*state, elapsed)

    half, two = build("mul", builder.constant(0.5), step), builder.constant(2)
    k1 = slopes((q, dq), None)
    k2 = slopes(ahead(k1, half), half)
    k3 = slopes(ahead(k2, half), half)
    k4 = slopes(ahead(k3, step), step)
    total = [
        build("add", build("add", a, d), build("mul", two, build("add", b, c)))
        for a, b, c, d in zip(k1, k2, k3, k4, strict=True)
    ]
    end = ahead((total[0], total[1]), build("mul", builder.constant(1 / 6), step))
    return *end, k1[1], k4[1]


def _closed_loop_step(model: AxisModel, law: Program, plant: Program) -> Program:
    coordinate, axis = model.axis.coordinate, model.axis
    q, dq, ddq = coordinate.symbol, coordinate.velocity, coordinate.acceleration
    arguments = _Arguments(reciprocals=True).scalars(q, dq)
    builder, values = arguments.builder, arguments.values
    state_port = next(port for port in law.inputs if port.name == "state")
    state = builder.vector("state", state_port.elements)
    reference, rate, error = map(builder.scalar, HELD_REFERENCE)
    direction = builder.scalar("direction")
    parameters = builder.vector("parameters", [p.name for p in axis.parameters])
    step = builder.scalar("step")
    measured = builder.apply("add", values[q], error)
    control = builder.inline(law, (reference,), (measured,), (values[dq],), state)
    tau = builder.apply("mul", builder.constant(axis.drive.gain), control["control"][0])
    held = (tau,) if _held_names(model) == HELD_FORCE else (reference, rate, error)
    end = builder.inline(
        plant, (values[q],), (values[dq],), held, (direction,), parameters, (step,)
    )
    builder.output(f"{q.name}_next", [end[f"{q.name}_next"]])
    builder.output(f"{dq.name}_next", [end[f"{dq.name}_next"]])
    builder.output("next_state", [[index] for index in control["next_state"]])
    builder.output(ddq.name, [end["first_slope"]])
    builder.output("tau", [[tau]])
    builder.output("control", [control["control"]])
    builder.output("last_slope", [end["last_slope"]])
    return builder.program(
        "closed_loop_step",
        "One sample: measure, control, move for `step` seconds in one friction mode.",
    )
