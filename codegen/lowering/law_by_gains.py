"""A control law by itself, its gains as arguments: for what is asked of a record's control.

Whether the output was beyond the drive's limit is an argument too, as the record shows it: a law
with other gains, whose integral runs away from the recorded motion, is else at the limit all along.
"""

from collections.abc import Sequence

import sympy

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.quantities import (
    BALANCED,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    with_numbers,
)

from .lower import Arguments, Lowering
from .program import Program


def law_by_gains(law: ControlLaw, signals: Sequence[sympy.Symbol]) -> tuple[Program, Program]:
    """A law's step, and what it remembers at rest.

    Parameters
    ----------
    law : ControlLaw
    signals : sequence of sympy.Symbol
        Recorded signals that it may read, in their order.

    Returns
    -------
    tuple of Program
        ``law_step``: from what the law reads, whether it was at the limit (1, else 0) and that
        limit, its gains and its memory to the next memory and the output as it is, without its
        delay. ``law_start``: from reference and position at rest to the memory; what balances is 0.
    """
    return _step(law, signals), _start(law)


def _step(law: ControlLaw, signals: Sequence[sympy.Symbol]) -> Program:
    read = (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, *signals)
    arguments = Arguments().scalars(*read)
    builder = arguments.builder
    at_limit, limit = builder.scalar("at_limit"), builder.scalar("limit")
    arguments = arguments.vector("gains", [gain(name) for name in law.gains])
    arguments = arguments.vector("state", [memory.symbol for memory in law.memory])
    values = {**arguments.values, PERIOD: builder.constant(law.period)}
    output = Lowering(builder, values)(with_numbers(law.output))
    limited = builder.apply("select", at_limit, limit, output)
    following = Lowering(builder, {**values, LIMITED_OUTPUT: limited})
    builder.output(
        "next_state", [[following(with_numbers(memory.following))] for memory in law.memory]
    )
    builder.output("output", [[output]])
    return builder.program("law_step", "The law at a sample, by its gains.")


def _start(law: ControlLaw) -> Program:
    arguments = Arguments().scalars(REFERENCE, MEASURED_POSITION)
    builder = arguments.builder
    lower = Lowering(builder, {**arguments.values, BALANCED: builder.constant(0.0)})
    builder.output("state", [[lower(with_numbers(memory.start))] for memory in law.memory])
    return builder.program("law_start", "What the law remembers at rest.")
