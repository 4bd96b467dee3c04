"""Elements of friction and load in an expression, by name: ``stribeck(Fs, x, velocity=0.01)``.

They are those of Python with the same arguments. A plain number takes the unit of its place there,
which a number of an expression does not have.
"""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, TypeAlias

import sympy

from axisid.modeling.declaration import ELEMENTS
from axisid.modeling.quantities import Coordinate
from axisid.support.errors import ModelError

#: Friction and loads that text may call, by name.
Elements: TypeAlias = Mapping[str, Callable[..., sympy.Expr]]

_COORDINATE = "coordinate"


def elements_along(coordinate: Coordinate) -> Elements:
    """The elements of an axis, made of what text gives them; text names the coordinate."""
    return {name: partial(_made, name, coordinate) for name in ELEMENTS}


def _made(
    element: str, along: Coordinate, /, *arguments: sympy.Expr, **named: sympy.Expr
) -> sympy.Expr:
    """The element of a name.

    Raises
    ------
    ModelError
        It takes other arguments, or other values.
    """
    signature = inspect.signature(ELEMENTS[element])
    try:
        bound = signature.bind(*arguments, **named)
    except TypeError as error:
        raise ModelError(
            f"{element}(...) cannot be used so; write {_written(element, along)}."
        ) from error
    for key, value in bound.arguments.items():
        bound.arguments[key] = _taken(element, along, key, value)
    return ELEMENTS[element](*bound.args, **bound.kwargs)


def _taken(element: str, along: Coordinate, key: str, value: sympy.Expr) -> Any:
    if key == _COORDINATE:
        if value != along.symbol:
            raise ModelError(
                f"the coordinate of {element}(...) is {value}; give {along.name}.",
                code="formula",
            )
        return along
    if isinstance(value, sympy.Integer):
        return int(value)
    return float(value) if value.is_Number else value


def _written(element: str, along: Coordinate) -> str:
    """A call with all that it may be given, such as ``spring(stiffness, x, rest)``."""
    parts = []
    for key, parameter in inspect.signature(ELEMENTS[element]).parameters.items():
        shown = along.name if key == _COORDINATE else key
        default = "" if parameter.default is parameter.empty else str(parameter.default)
        by_name = parameter.kind is parameter.KEYWORD_ONLY
        parts.append(f"{key}={default or '...'}" if by_name else shown)
    return f"{element}({', '.join(parts)})"
