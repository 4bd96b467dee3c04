"""The functions of an axis, as programs that are built from its model.

All arguments are SI. ``parameters`` are the physical parameters in the axis's order; ``direction``
is the friction direction (the sign of the velocity while sliding). Recorded signals, if the axis
declares any, come after the other scalars.
"""

from collections.abc import Sequence

import sympy

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import (
    BALANCED,
    DIRECTION,
    FORCE,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    UNLIMITED_OUTPUT,
    with_numbers,
)
from axisid.support.missing import Missing

from .drive import acting_control, drive_control, drive_force, within
from .expressions import Arguments, Lowering
from .plant import GAINS, closed_loop_step, plant_programs
from .program import Builder, Program

#: A test signal that is added to the law's output.
_INJECTED = sympy.Symbol("injected", real=True)


def axis_programs(model: AxisModel, *, by_gains: bool = False) -> tuple[Program, ...]:
    """Return the programs of all functions of an axis.

    Functions that the model does not permit are missing: without a direct regressor the
    ``ddm_regressor`` and the parameter maps, without a control law the closed loop, with internal
    states the ``idm_regressor``.

    Parameters
    ----------
    model : AxisModel
    by_gains : bool
        True if the gains of a sampled law are arguments instead of numbers. In the step of the loop
        they follow the parameters; in other functions of the law they are the last argument, a
        vector.
    """
    about, name = "Acceleration that the force causes", model.axis.coordinate.acceleration.name
    acceleration = _dynamics(model, "direct_dynamics", about, name, model.acceleration, force=True)
    programs = [inverse_dynamics(model)]
    # With internal states there is no regressor of measured signals.
    programs += [acceleration] if model.states else [_idm_regressor(model), acceleration]
    programs += [*_direct_regressor(model), drive_force(model.axis), drive_control(model)]
    law = model.axis.control
    gains = tuple(map(gain, law.gains)) if law is not None and by_gains else ()
    driven = None if law is None else _control_law(model, law, gains, injected=True)
    plant = plant_programs(model, driven, acceleration)
    programs += plant
    if law is not None and driven is not None:
        programs += [
            _control_start(model, law, gains),
            _control_law(model, law, gains),
            _control_terms(model, law, gains),
            closed_loop_step(model, driven, plant[1]),
        ]
    return tuple(programs)


def _motion(model: AxisModel, *, force: bool) -> Arguments:
    """Return the arguments of a dynamic model: motion, direction and recorded signals.

    The third argument is the force if `force` is true, otherwise the acceleration.
    """
    q = model.axis.coordinate
    third = FORCE if force else q.acceleration
    return Arguments().scalars(q.symbol, q.velocity, third, DIRECTION, *model.axis.signal_symbols)


def inverse_dynamics(model: AxisModel) -> Program:
    """Return the program of the force that a motion needs."""
    about = "Force that the motion needs"
    return _dynamics(model, "inverse_dynamics", about, "tau", model.force, force=False)


def _dynamics(
    model: AxisModel, name: str, about: str, result: str, value: sympy.Expr, *, force: bool
) -> Program:
    """Return the program of an expression of the motion and the parameters.

    Parameters
    ----------
    model : AxisModel
    name, about, result : str
        Name of the program, description, and name of its result.
    value : sympy.Expr
    force : bool
        True if the force is an argument; otherwise the acceleration is.
    """
    arguments = _motion(model, force=force).vector_of(
        "parameters", [p.symbol for p in model.axis.parameters]
    )
    end = ", the states where they start." if model.states else "."
    return arguments.lower(**{result: [[model.at_start(value)]]}).program(name, f"{about}{end}")


def _idm_regressor(model: AxisModel) -> Program:
    """Return the program of the inverse model's regressor and known part."""
    arguments, about = _motion(model, force=False), "tau = row . parameters + known."
    if model.idm.nonlinear:
        arguments = arguments.vector_of("parameters", [p.symbol for p in model.axis.parameters])
        about = "tau = row . parameters + known, linearised about the parameters."
    return arguments.lower(row=[model.idm.columns], known=[[model.idm.intercept]]).program(
        "idm_regressor", about
    )


def _direct_regressor(model: AxisModel) -> list[Program]:
    """Return the programs of the direct regressor and the parameter maps; none if it is missing."""
    if isinstance(model.ddm, Missing) or isinstance(model.parameter_map, Missing):
        return []
    row, mapping = model.ddm, model.parameter_map
    builder = _motion(model, force=True).lower(row=[row.columns], known=[[row.intercept]])
    forward = Arguments().vector_of("parameters", mapping.parameters)
    backward = Arguments().vector_of("ddm_parameters", mapping.symbols)
    return [
        builder.program("ddm_regressor", "ddq = row . ddm_parameters + known."),
        forward.lower(
            ddm_parameters=mapping.forward.tolist(), jacobian=mapping.forward_jacobian.tolist()
        ).program("ddm_from_physical", "Parameters of the direct model, and the Jacobian."),
        backward.lower(
            parameters=mapping.inverse.tolist(), jacobian=mapping.inverse_jacobian.tolist()
        ).program("physical_from_ddm", "Physical parameters, and the Jacobian."),
    ]


def _control_start(model: AxisModel, law: ControlLaw, gains: tuple[sympy.Symbol, ...]) -> Program:
    """Return the program of the state of law and drive for an axis at rest.

    The entries of the state are, in this order:

    1. the memory of the law,
    2. the controls in the delay line of the law, all equal to the control at rest,
    3. the state of the drive, if it has one (see `Response.remembered`):

       - the control that the rate limit stores, if the rate is limited,
       - the forces that wait for the delay, all equal to the force at rest; a drive that holds the
         control while the force follows the motion stores the waiting commands instead,
       - the force that acts now, if the drive stores it.
    """
    builder = (
        Arguments()
        .scalars(REFERENCE, MEASURED_POSITION, *model.axis.signal_symbols)
        .vector_if_any(GAINS, gains)
    )
    # A memory that balances a load is 0 here; it is computed where the load is known.
    lowering = Lowering(builder, {**builder.values, BALANCED: builder.constant(0.0)})
    memory = [lowering(with_numbers(memory.start)) for memory in law.memory]
    values = {m.symbol: index for m, index in zip(law.memory, memory, strict=True)}
    rest = {MEASURED_VELOCITY: builder.constant(0.0)}
    control = _output(model, law, builder, {**builder.values, **values, **rest})
    delay_line = [control] * law.delay
    drive_state: list[int] = []
    response = model.axis.response
    if response is not None:
        # The control that acts, the control that the rate limit stores, and the force at rest.
        position, still = builder.values[MEASURED_POSITION], rest[MEASURED_VELOCITY]
        signals = [(builder.values[s],) for s in model.axis.signal_symbols]
        acting, rate_limited = acting_control(builder, model, control, control)
        (steady_force,) = builder.inline(
            drive_force(model.axis), (acting,), (position,), (still,), *signals
        )["tau"]
        waiting_commands: list[int] = []
        if response.holds_control:
            waiting_commands = [acting] * (len(response.forces) - 1)
        forces = [steady_force] * (len(response.forces) - len(waiting_commands))
        drive_state = [*rate_limited, *waiting_commands, *forces]
    state = [*memory, *delay_line, *drive_state]
    builder.output("state", [[index] for index in state])
    return builder.program("control_start", "Memory of law and drive for an axis at rest.")


def _output(
    model: AxisModel,
    law: ControlLaw,
    builder: Builder,
    values: dict[sympy.Symbol, int],
    injected: int | None = None,
) -> int:
    """Return the operation of the law's output plus a test signal, clipped at the drive's limit.

    `injected` is the operation of the test signal; None without a test signal.
    """
    control = _law_lowering(law, builder, values)(with_numbers(law.output))
    if injected is not None:
        control = builder.apply("add", control, injected)
    return within(model.axis.drive.limit, builder, control)


def _law_lowering(law: ControlLaw, builder: Builder, values: dict[sympy.Symbol, int]) -> Lowering:
    """Return the converter of a law's expressions to operations.

    Gains without an entry in `values` are not arguments of the program; they become numbers.
    """
    numbers = {gain(name): value for name, value in law.gains.items() if gain(name) not in values}
    gains = {symbol: builder.constant(value) for symbol, value in numbers.items()}
    return Lowering(builder, {**values, **gains, PERIOD: builder.constant(law.period)})


def _control_law(
    model: AxisModel,
    law: ControlLaw,
    gains: tuple[sympy.Symbol, ...],
    *,
    injected: bool = False,
) -> Program:
    """Return the program of the law: its control and its next state.

    Parameters
    ----------
    model : AxisModel
    law : ControlLaw
    gains : tuple of sympy.Symbol
        Gains that are arguments.
    injected : bool
        Whether a test signal is added to the output, as in the loop.
    """
    builder, line = _measured(model, law, gains, injected=injected)
    values = builder.values
    control = _output(model, law, builder, values, values.get(_INJECTED))
    # Without a test signal, on which no integral of the law depends.
    if any(each.following.has(UNLIMITED_OUTPUT) for each in law.memory):
        values[UNLIMITED_OUTPUT] = _law_lowering(law, builder, values)(with_numbers(law.output))
    if any(each.following.has(LIMITED_OUTPUT) for each in law.memory):
        values[LIMITED_OUTPUT] = _output(model, law, builder, values)
    following = _law_lowering(law, builder, values)
    # The control that acts is the oldest of those that wait for the delay.
    queue = (control, *line)
    builder.output("control", [[queue[-1]]])
    builder.output(
        "next_state",
        [[following(with_numbers(m.following))] for m in law.memory]
        + [[index] for index in queue[:-1]],
    )
    return builder.program("control_law", "Control that the drive applies, within its limit.")


def _measured(
    model: AxisModel, law: ControlLaw, gains: tuple[sympy.Symbol, ...], *, injected: bool = False
) -> tuple[Arguments, tuple[int, ...]]:
    """Return the arguments of a law's program, and the operations of its delay line.

    The arguments are the signals that the law reads, its state at a sample, and the gains.
    """
    motion = (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, *model.axis.signal_symbols)
    arguments = Arguments().scalars(*motion, *(_INJECTED,) * injected)
    # The state of the law: its memory, and the controls that wait for its delay.
    remembered = (*(memory.name for memory in law.memory), *law.delay_line)
    state = arguments.vector("state", remembered)
    arguments.vector_if_any(GAINS, gains)
    arguments.values.update((m.symbol, i) for m, i in zip(law.memory, state, strict=False))
    return arguments, state[len(law.memory) :]


def _control_terms(model: AxisModel, law: ControlLaw, gains: tuple[sympy.Symbol, ...]) -> Program:
    """Return the program of the law's terms, one for each product of gains."""
    arguments, _ = _measured(model, law, gains)
    lower = _law_lowering(law, arguments, arguments.values)
    terms = [lower(with_numbers(factor * signal)) for factor, signal in law.terms]
    arguments.output("row", [terms])
    return arguments.program("control_terms", "Summands of the law, one for each product of gains.")


def law_by_gains(law: ControlLaw, signals: Sequence[sympy.Symbol]) -> tuple[Program, Program]:
    """Return the programs of a law's step and of its memory at rest.

    Parameters
    ----------
    law : ControlLaw
    signals : sequence of sympy.Symbol
        Recorded signals that it may read, in their order.

    Returns
    -------
    tuple of Program
        ``law_step``: from the signals that the law reads, the limit of its output (infinite for
        none), its gains and its memory to the next memory and the output without its delay.
        ``law_start``: from reference and position at rest to the memory; balancing values are 0.
    """
    builder = Arguments().scalars(REFERENCE, MEASURED_POSITION)
    lower = Lowering(builder, {**builder.values, BALANCED: builder.constant(0.0)})
    builder.output("state", [[lower(with_numbers(memory.start))] for memory in law.memory])
    start = builder.program("law_start", "Memory of the law at rest.")
    builder = Arguments().scalars(REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, *signals)
    limit = builder.scalar("output_limit")
    builder.vector_of("gains", [gain(name) for name in law.gains])
    builder.vector_of("state", [memory.symbol for memory in law.memory])
    values = {**builder.values, PERIOD: builder.constant(law.period)}
    output = Lowering(builder, values)(with_numbers(law.output))
    limited = builder.apply("min", output, limit)
    limited = builder.apply("max", limited, builder.apply("neg", limit))
    following = Lowering(builder, {**values, UNLIMITED_OUTPUT: output, LIMITED_OUTPUT: limited})
    builder.output(
        "next_state", [[following(with_numbers(memory.following))] for memory in law.memory]
    )
    builder.output("control", [[output]])
    return builder.program("law_step", "The law at a sample, with its gains as arguments."), start
