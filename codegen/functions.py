"""The set of functions every axis gets, as programs built from its model.

All arguments are SI. ``parameters`` are the physical ones in the axis's order; ``direction`` is the
friction direction (sign of the velocity while sliding).
"""

from collections.abc import Sequence

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


def axis_programs(model: AxisModel) -> tuple[Program, ...]:
    """Build every function the model allows.

    Without a direct regressor there are no ``ddm_regressor`` and no parameter map; without a
    control law there is no closed loop.
    """
    acceleration = _direct_dynamics(model)
    plant = _plant_step(model, acceleration)
    programs = [_inverse_dynamics(model), _idm_regressor(model), acceleration]
    programs += _direct_regressor(model)
    programs.append(plant)
    if model.axis.control is not None:
        law = _control_law(model, model.axis.control)
        programs += [
            _control_start(model.axis.control),
            law,
            _closed_loop_step(model, law, acceleration, plant),
        ]
    return tuple(programs)


class _Arguments:
    """A builder with arguments declared by SymPy symbol."""

    def __init__(self) -> None:
        self.builder = Builder()
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


def _inverse_dynamics(model: AxisModel) -> Program:
    arguments = _motion(model, force=False).vector("parameters", _parameters(model))
    return arguments.lower(tau=[[model.force]]).program(
        "inverse_dynamics", "Force that the motion needs."
    )


def _idm_regressor(model: AxisModel) -> Program:
    builder = _motion(model, force=False).lower(row=[model.idm.columns], known=[[model.idm.known]])
    return builder.program("idm_regressor", "tau = row . parameters + known.")


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


def _control_start(law: ControlLaw) -> Program:
    builder = _Arguments().scalars(MEASURED_POSITION)
    return builder.lower(state=[[memory.start] for memory in law.memory]).program(
        "control_start", "What the law remembers at the first sample, the axis at rest."
    )


def _control_law(model: AxisModel, law: ControlLaw) -> Program:
    arguments = _Arguments().scalars(REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY)
    arguments.vector("state", [memory.symbol for memory in law.memory])
    builder = arguments.builder
    known = {gain(name): builder.constant(value) for name, value in law.gains.items()}
    lowering = Lowering(
        builder, {**arguments.values, **known, PERIOD: builder.constant(law.period)}
    )
    control = lowering(law.output)
    limit = model.axis.drive.limit
    if limit != float("inf"):
        control = builder.apply("min", control, builder.constant(limit))
        control = builder.apply("max", control, builder.constant(-limit))
    builder.output("control", [[control]])
    builder.output("next_state", [[lowering(memory.following)] for memory in law.memory])
    return builder.program(
        "control_law", "Control held until the next sample, within the drive's limit."
    )


def _plant_step(model: AxisModel, acceleration: Program) -> Program:
    arguments = _motion(model, force=True).vector("parameters", _parameters(model))
    builder, values = arguments.builder, arguments.values
    step = builder.scalar("step")
    q, dq = model.axis.coordinate.symbol, model.axis.coordinate.velocity
    end = _runge_kutta(
        builder,
        acceleration,
        (values[q], values[dq], values[FORCE], values[DIRECTION]),
        tuple(values[p] for p in _parameters(model)),
        step,
    )
    builder.output(f"{q.name}_next", [[end[0]]])
    builder.output(f"{dq.name}_next", [[end[1]]])
    return builder.program(
        "plant_step", "Motion after `step` seconds of held force in one friction mode (RK4)."
    )


def _runge_kutta(
    builder: Builder,
    acceleration: Program,
    state: tuple[int, int, int, int],
    parameters: tuple[int, ...],
    step: int,
) -> tuple[int, int]:
    """Classical fourth-order Runge-Kutta step of position and velocity."""
    q, dq, tau, direction = state

    def slope(position: int, velocity: int) -> tuple[int, int]:
        arguments = ((position,), (velocity,), (tau,), (direction,), parameters)
        (value,) = next(iter(builder.inline(acceleration, *arguments).values()))
        return velocity, value

    def ahead(slopes: tuple[int, int], length: int) -> tuple[int, int]:
        moved = [
            builder.apply("add", start, builder.apply("mul", length, s))
            for start, s in zip((q, dq), slopes, strict=True)
        ]
        return moved[0], moved[1]

    half = builder.apply("div", step, builder.constant(2))
    k1 = slope(q, dq)
    k2 = slope(*ahead(k1, half))
    k3 = slope(*ahead(k2, half))
    k4 = slope(*ahead(k3, step))
    sixth, two = builder.apply("div", step, builder.constant(6)), builder.constant(2)
    total = [
        builder.apply(
            "add",
            builder.apply("add", a, d),
            builder.apply("mul", two, builder.apply("add", b, c)),
        )
        for a, b, c, d in zip(k1, k2, k3, k4, strict=True)
    ]
    return ahead((total[0], total[1]), sixth)


def _closed_loop_step(
    model: AxisModel, law: Program, acceleration: Program, plant: Program
) -> Program:
    coordinate, axis = model.axis.coordinate, model.axis
    q, dq, ddq = coordinate.symbol, coordinate.velocity, coordinate.acceleration
    arguments = _Arguments().scalars(q, dq)
    builder, values = arguments.builder, arguments.values
    state = builder.vector(
        "state", next(port for port in law.inputs if port.name == "state").elements
    )
    reference, noise, direction = map(builder.scalar, ("reference", "position_noise", "direction"))
    parameters = builder.vector("parameters", [p.name for p in axis.parameters])
    step = builder.scalar("step")
    measured = builder.apply("add", values[q], noise)
    control = builder.inline(law, (reference,), (measured,), (values[dq],), state)
    tau = builder.apply("mul", builder.constant(axis.drive.gain), control["control"][0])
    motion = ((values[q],), (values[dq],), (tau,), (direction,), parameters)
    end = builder.inline(plant, *motion, (step,))
    builder.output(f"{q.name}_next", [end[f"{q.name}_next"]])
    builder.output(f"{dq.name}_next", [end[f"{dq.name}_next"]])
    builder.output("next_state", [[index] for index in control["next_state"]])
    builder.output(ddq.name, [builder.inline(acceleration, *motion)[ddq.name]])
    builder.output("tau", [[tau]])
    builder.output("control", [control["control"]])
    return builder.program(
        "closed_loop_step",
        "One sample: measure, control, hold for `step` seconds in one friction mode.",
    )
