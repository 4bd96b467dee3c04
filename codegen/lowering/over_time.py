"""What is declared as a function of time, as a program: the recorded signals of a twin."""

from collections.abc import Mapping

import sympy

from axisid.modeling.quantities import TIME, with_numbers

from .lower import Arguments
from .program import Program


def over_time(values: Mapping[str, sympy.Expr]) -> Program:
    """Build a program from the time, s, to a number for each name."""
    builder = (
        Arguments()
        .scalars(TIME)
        .lower(**{name: [[with_numbers(value)]] for name, value in values.items()})
    )
    return builder.program("over_time", "Signals by the time.")
