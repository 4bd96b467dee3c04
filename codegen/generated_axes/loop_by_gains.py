"""The closed loop of an axis, and its law by itself, with the gains of the law as arguments.

Generated files have the gains as numbers, so that each can be read and taken elsewhere by itself.
What is compiled and run takes them as arguments: its text is the same whatever they are, so that
another gain needs no compiler, and many can be tried side by side.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
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
    return execute(functions_text("law", "", law_by_gains(law, signals)), "law")


def law_over_block(step: Any, evaluations: int) -> Any:
    """A law over so many evaluations in a row: memories and outputs, (m, M) and (1, M).

    From the memory at the first, what is read, (1, M) each, and the gains if any, which are there
    once.

    Parameters
    ----------
    step : casadi.Function
        ``law_step``, or ``control_law`` of an axis.
    evaluations : int
    """
    last, state = step.n_in() - 1, step.name_out().index("next_state")
    one = step.slice("law", [last, *range(last)], [state, 1 - state])
    taken = [
        casadi.SX.sym(name, one.size1_in(name), 1 if name in ("state", "gains") else evaluations)
        for name in one.name_in()
    ]
    return casadi.Function("law", taken, one.mapaccum(evaluations).call(taken))


_OF_THE_LAW = ("control_start", "control_law", "control_terms")
_STEP = "closed_loop_step"


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopByGains:
    """Functions that take the gains of a sampled law.

    Attributes
    ----------
    model : AxisModel
    law : ControlLaw
        The model's.
    enabled : bool
        Whether native code may be compiled and run.
    """

    model: AxisModel
    law: ControlLaw
    enabled: bool

    @classmethod
    def of(cls, model: AxisModel, *, enabled: bool) -> "LoopByGains | None":
        """The loop of a model; None without a law, with one that has no gains or is continuous.

        A continuous law is part of the plant's motion, whose functions have its gains as numbers.
        """
        law = model.axis.control
        if law is None or law.continuous or not law.gains:
            return None
        return cls(model=model, law=law, enabled=enabled)

    @cached_property
    def _texts(self) -> tuple[str, str]:
        return by_gains_artefacts(self.model)

    @property
    def functions(self) -> Mapping[str, Any]:
        """As of the axis, CasADi's.

        The loop's step takes the gains behind the parameters, the law's functions as their last
        argument.
        """
        return execute(self._texts[0], self.model.axis.name)

    @cached_property
    def native(self) -> Native:
        """The same, compiled."""
        return Native(self._texts[1], self.functions, enabled=self.enabled)

    def native_at(self, gains: Mapping[str, float]) -> Native:
        """The native code with gains filled in."""
        filled = np.array([*gains.values()])
        return Native(self._texts[1], self.functions, enabled=self.enabled, gains=filled)

    def functions_at(self, gains: Mapping[str, float]) -> dict[str, Any]:
        """The functions of the law and of the loop's step with gains as numbers."""
        numbers = np.array([*gains.values()])
        found = {name: _bound(self.functions[name], numbers) for name in _OF_THE_LAW}
        return found | {_STEP: _bound(self.functions[_STEP], numbers, "parameters")}

    def with_law(self, law: ControlLaw) -> "LoopByGains":
        """The same loop under a law that differs by its gains alone."""
        axis = replace(self.model.axis, control=law)
        changed = replace(self, model=replace(self.model, axis=axis), law=law)
        # Neither text knows the numbers.
        for name in ("_texts", "native"):
            if name in self.__dict__:
                changed.__dict__[name] = self.__dict__[name]
        return changed


def _bound(function: Any, gains: Array, behind: str = "") -> Any:
    """A function with gains as numbers, which are its last argument, or come behind another."""
    names = function.name_in() if behind else function.name_in()[:-1]
    symbols = {
        name: casadi.SX.sym(name, function.size1_in(name) - len(gains) * (name == behind))
        for name in names
    }
    given = [casadi.vertcat(x, gains) if name == behind else x for name, x in symbols.items()]
    results = function.call([*given, *([] if behind else [casadi.SX(gains)])])
    return casadi.Function(
        function.name(), [*symbols.values()], results, names, function.name_out()
    )
