"""Elements of friction and load in an expression, by name: ``stribeck(Fs, x, velocity=0.01)``.

They are those of Python with the same arguments. A plain number takes the unit of its place there,
which a number of an expression does not have.
"""

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from axisid.modeling.declaration import ELEMENTS
from axisid.modeling.quantities import Coordinate
from axisid.support.errors import ModelError

_COORDINATE = "coordinate"


class ElementCalls:
    """Elements of an axis, made of what text gives them.

    Parameters
    ----------
    coordinate : Coordinate
        Of the axis, which text names by its symbol.
    """

    def __init__(self, coordinate: Coordinate) -> None:
        self._coordinate = coordinate

    @property
    def names(self) -> tuple[str, ...]:
        """Of all of them."""
        return tuple(ELEMENTS)

    def made(
        self, name: str, arguments: Sequence[sympy.Expr], named: Mapping[str, sympy.Expr]
    ) -> sympy.Expr:
        """The element of a name.

        Raises
        ------
        ModelError
            It takes other arguments, or other values.
        """
        signature = inspect.signature(ELEMENTS[name])
        try:
            bound = signature.bind(*arguments, **named)
        except TypeError as error:
            raise ModelError(
                f"{name}(...) cannot be used so; write {self._written(name)}."
            ) from error
        for key, value in bound.arguments.items():
            bound.arguments[key] = self._taken(name, key, value)
        return ELEMENTS[name](*bound.args, **bound.kwargs)

    def _taken(self, name: str, key: str, value: sympy.Expr) -> Any:
        """An argument as an element takes it."""
        if key == _COORDINATE:
            if value != self._coordinate.symbol:
                raise ModelError(
                    f"the coordinate of {name}(...) is {value}; give {self._coordinate.name}.",
                    code="element-coordinate",
                )
            return self._coordinate
        if isinstance(value, sympy.Integer):
            return int(value)
        return float(value) if value.is_Number else value

    def _written(self, name: str) -> str:
        """A call with all that it may be given, such as ``spring(stiffness, x, rest)``."""
        parts = []
        for key, parameter in inspect.signature(ELEMENTS[name]).parameters.items():
            shown = self._coordinate.name if key == _COORDINATE else key
            default = "" if parameter.default is parameter.empty else str(parameter.default)
            by_name = parameter.kind is parameter.KEYWORD_ONLY
            parts.append(f"{key}={default or '...'}" if by_name else shown)
        return f"{name}({', '.join(parts)})"
