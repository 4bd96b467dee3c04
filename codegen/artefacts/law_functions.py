"""CasADi functions of a control law by itself, its gains as arguments."""

from collections.abc import Mapping
from typing import Any

import sympy

from axisid.codegen.lowering import law_by_gains
from axisid.codegen.printers import print_function
from axisid.codegen.runtime import execute
from axisid.modeling.declaration import ControlLaw


def law_functions(law: ControlLaw, signals: tuple[sympy.Symbol, ...]) -> Mapping[str, Any]:
    """``law_step`` and ``law_start``; see `law_by_gains`.

    Parameters
    ----------
    law : ControlLaw
    signals : tuple of sympy.Symbol
        Recorded signals, in their order.

    Returns
    -------
    mapping of str to casadi.Function
    """
    programs = law_by_gains(law, signals)
    names = "".join(f'    "{program.name}": {program.name},\n' for program in programs)
    texts = "\n\n".join(map(print_function, programs))
    return execute(f"import casadi\n\n\n{texts}\n\nFUNCTIONS = {{\n{names}}}\n", "law")
