"""What the text of an equation of motion or a control law may say.

Every function here is one that code is generated for.
"""

import math

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from .grammar import Function, Grammar

_FUNCTIONS = {
    "sin": Function(sympy.sin, math.sin),
    "cos": Function(sympy.cos, math.cos),
    "tan": Function(sympy.tan, math.tan),
    "asin": Function(sympy.asin, math.asin),
    "acos": Function(sympy.acos, math.acos),
    "atan": Function(sympy.atan, math.atan),
    "atan2": Function(sympy.atan2, math.atan2, 2),
    "sinh": Function(sympy.sinh, math.sinh),
    "cosh": Function(sympy.cosh, math.cosh),
    "tanh": Function(sympy.tanh, math.tanh),
    "exp": Function(sympy.exp, math.exp),
    "log": Function(sympy.log, math.log),
    "sqrt": Function(sympy.sqrt, math.sqrt),
    "abs": Function(sympy.Abs, abs),
    "sign": Function(sympy.sign, lambda x: float((x > 0) - (x < 0))),
    "min": Function(Min, min, 2),
    "max": Function(Max, max, 2),
}

#: Of every expression in a TOML declaration.
DYNAMICS = Grammar(
    what="an expression",
    names="name",
    functions=_FUNCTIONS,
    nodes=frozenset({sympy.Add, sympy.Mul, sympy.Pow, *(f.symbolic for f in _FUNCTIONS.values())}),
    longest=2000,
)
