"""Parameters that are known apart from a record: weighed, measured, from CAD."""

import re
from collections.abc import Iterable
from dataclasses import replace

from axisid.modeling.quantities import Parameter
from axisid.support.errors import UsageError

from .axis import Axis, check_axis

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FIXED = re.compile(rf"\s*(\w+)\s*=\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")


def fix(axis: Axis, /, **values: float | tuple[float, float]) -> Axis:
    """The axis with parameters declared as known.

    They stay parameters. Where a record alone does not tell the physical parameters apart, what is
    known lets the others follow, with its uncertainty; where it does, the two are weighed.

    Parameters
    ----------
    axis : Axis
    **values : float or (float, float)
        By name: the value, SI, exact; or with its standard deviation, as in ``m=(2.0, 0.02)``.

    Raises
    ------
    UsageError
        The axis has no such parameter, or a value is no number or pair.
    ModelError
        A value is outside its parameter's bounds, or a deviation is negative.
    """
    check_axis(axis)
    declared = [p.name for p in axis.parameters]
    for name, value in values.items():
        if name not in declared:
            raise UsageError(
                f"there is no parameter {name!r} to fix; axis {axis.name!r} has "
                f"{', '.join(declared)}.",
                code="fix-unknown",
            )
        if isinstance(value, (tuple, list)) and len(value) != 2:
            raise UsageError(
                f"the fixed value of {name!r} is {value!r}; give a number, or a number and its "
                "standard deviation.",
                code="fix-type",
            )
    pairs = {n: v if isinstance(v, (tuple, list)) else (v, 0.0) for n, v in values.items()}
    return replace(
        axis,
        parameters=tuple(
            replace(p, known=pairs[p.name][0], known_sd=pairs[p.name][1]) if p.name in pairs else p
            for p in axis.parameters
        ),
    )


def read_fixed(texts: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Fixed values from texts such as ``m=2.0`` and ``m=2.0+-0.02``.

    Raises
    ------
    UsageError
        A text is something else, or a parameter is fixed twice.
    """
    fixed: dict[str, tuple[float, float]] = {}
    for text in texts:
        match = _FIXED.fullmatch(text)
        if match is None:
            raise UsageError(
                f"{text!r} fixes nothing; write NAME=VALUE or NAME=VALUE+-DEVIATION, SI, as in "
                "m=2.0+-0.02.",
                code="fix-nothing",
            )
        if match[1] in fixed:
            raise UsageError(f"{match[1]!r} is fixed twice; fix it once.", code="fix-twice")
        fixed[match[1]] = (float(match[2]), float(match[3] or 0.0))
    return fixed


def known_text(parameter: Parameter) -> str:
    """A known value in words: ``2 +- 0.02``."""
    spread = f" +- {parameter.known_sd:g}" if parameter.known_sd else ""
    return f"{parameter.known:g}{spread}"
