"""The closed loop of an axis, and its law alone, with the gains of the law as arguments.

Generated files contain the gains as numbers, so that each file can be read and used alone. The code
that is compiled and run takes the gains as arguments. Its text does not depend on their values, so
that other gains need no compilation, and many gains can be tried in parallel.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np
import sympy

from axisid.codegen.lowering import law_by_gains
from axisid.codegen.runtime import Native, execute
from axisid.modeling.declaration import ControlLaw
from axisid.modeling.derivation import AxisModel
from axisid.support.arrays import Array

from .texts import by_gains_artefacts, functions_text


def law_functions(law: ControlLaw, signals: tuple[sympy.Symbol, ...]) -> Mapping[str, Any]:
    """Return the CasADi functions ``law_step`` and ``law_start`` by name; see `law_by_gains`.

    Parameters
    ----------
    law : ControlLaw
    signals : tuple of sympy.Symbol
        Recorded signals, in their order.

    Returns
    -------
    mapping of str to casadi.Function
    """
    return execute(functions_text("law", "", law_by_gains(law, signals)), "law")


def law_over_block(step: Any, evaluations: int) -> Any:
    """Return a CasADi function that evaluates a law M times in succession.

    It returns the memory after each evaluation, (m, M), and the outputs, (1, M). Its arguments are
    the memory at the first evaluation, (m, 1), the signals that the law reads, (1, M) each, and the
    gains, (g, 1), if they are arguments. All evaluations have the same gains: CasADi repeats an
    argument with a single column.

    Parameters
    ----------
    step : casadi.Function
        Function of one evaluation: ``law_step``, or ``control_law`` of an axis with the gains as
        numbers. Its last argument is the memory, ``state``; its results are ``next_state`` and the
        output, in any order.
    evaluations : int
        M.
    """
    # One evaluation, with the memory as its first argument and its first result, as an
    # accumulation over evaluations needs.
    memory, next_memory = step.n_in() - 1, step.name_out().index("next_state")
    one = step.slice("law", [memory, *range(memory)], [next_memory, 1 - next_memory])
    taken = [
        casadi.SX.sym(name, one.size1_in(name), 1 if name in ("state", "gains") else evaluations)
        for name in one.name_in()
    ]
    return casadi.Function("law", taken, one.mapaccum(evaluations).call(taken))


_OF_THE_LAW = ("control_start", "control_law", "control_terms")
_STEP = "closed_loop_step"


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopByGains:
    """The functions of a closed loop that take the gains of a sampled law as arguments.

    Attributes
    ----------
    model : AxisModel
    law : ControlLaw
        The control law of the model.
    functions : mapping of str to casadi.Function
        Functions like those of the axis. The step of the loop takes the gains as the last elements
        of the parameters; the functions of the law take the gains as their last argument.
    native : Native
        The same functions, compiled.
    """

    model: AxisModel
    law: ControlLaw
    functions: Mapping[str, Any]
    native: Native

    @classmethod
    def of(cls, model: AxisModel, *, enabled: bool) -> "LoopByGains | None":
        """Return the loop of a model with gains as arguments.

        None without a law or gains. None also for a continuous law, which is part of the plant's
        motion with its gains as numbers.

        Parameters
        ----------
        model : AxisModel
        enabled : bool
            True if native code may be compiled and run.
        """
        law = model.axis.control
        if law is None or law.continuous or not law.gains:
            return None
        functions_py, native_c = by_gains_artefacts(model)
        functions = execute(functions_py, model.axis.name)
        native = Native(native_c, functions, enabled=enabled)
        return cls(model=model, law=law, functions=functions, native=native)

    def native_at(self, gains: Mapping[str, float]) -> Native:
        """Return the native code with given gains, in the order of the law."""
        filled, enabled = np.array([*gains.values()]), self.native.enabled
        return Native(self.native.text, self.functions, enabled=enabled, gains=filled)

    def functions_at(self, gains: Mapping[str, float]) -> dict[str, Any]:
        """Return the functions of the law and the loop's step with the gains as numbers."""
        numbers = np.array([*gains.values()])
        found = {name: _bound(self.functions[name], numbers) for name in _OF_THE_LAW}
        return found | {_STEP: _bound(self.functions[_STEP], numbers, "parameters")}


def _bound(function: Any, gains: Array, inside: str = "") -> Any:
    """Return a function with numbers in place of its gains.

    Parameters
    ----------
    function : casadi.Function
    gains : (g,) array
        Values of the gains.
    inside : str
        Name of the argument whose last elements are the gains; empty if the gains are the last
        argument.
    """
    names = function.name_in()
    if not inside:
        names = names[:-1]
    symbols = {
        name: casadi.SX.sym(name, function.size1_in(name) - len(gains) * (name == inside))
        for name in names
    }
    given = [casadi.vertcat(x, gains) if name == inside else x for name, x in symbols.items()]
    if not inside:
        given.append(casadi.SX(gains))
    results = function.call(given)
    return casadi.Function(
        function.name(), [*symbols.values()], results, names, function.name_out()
    )
