"""Axes derived from an axis: with parameters fixed as known, or left out of the identification."""

import math
import re
from collections.abc import Iterable
from dataclasses import replace

import sympy

from axisid.modeling.quantities import Parameter, number, replaced_in, states_in
from axisid.support.checks import is_among, refuse
from axisid.support.errors import UsageError
from axisid.support.settings import setting
from axisid.support.wording import quoted

from .axis import Axis, check_axis

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FIXED = re.compile(rf"\s*(\w+)\s*=\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")


def fix(axis: Axis, /, **values: float | tuple[float, float]) -> Axis:
    """Return the axis with parameters declared as known.

    They remain parameters. If a record alone does not distinguish the physical parameters, the
    others follow from the known ones, with their uncertainty; if it does, estimate and known value
    are combined by their weights.

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
        A value is outside its parameter's bounds, or a standard deviation is negative.
    """
    _check_declared(axis, values, "fix")
    refuse(
        UsageError,
        *(
            (
                isinstance(value, (tuple, list)) and len(value) != 2,
                f"the fixed value of {name!r} is {value!r}. Give a number, or a number and its "
                "standard deviation",
            )
            for name, value in values.items()
        ),
        code="parameters",
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
    """Return fixed values and their standard deviations by name, from texts like ``m=2.0+-0.02``.

    Without ``+-`` the standard deviation is 0.

    Raises
    ------
    UsageError
        A text has another form, or a parameter is fixed twice.
    """
    fixed: dict[str, tuple[float, float]] = {}
    for text in texts:
        match = _FIXED.fullmatch(text)
        if match is None:
            raise UsageError(
                f"{text!r} does not fix a parameter. Write NAME=VALUE or NAME=VALUE+-SD in SI "
                "units, as in m=2.0+-0.02.",
                code="parameters",
            )
        if match[1] in fixed:
            raise UsageError(f"{match[1]!r} is fixed twice. Fix it once.", code="parameters")
        fixed[match[1]] = (float(match[2]), float(match[3] or 0.0))
    return fixed


def known_text(value: float | None, sd: float) -> str:
    """Return a known value with its standard deviation as text, ``2 +- 0.02``; ``2`` if exact."""
    return f"{value:g} +- {sd:g}" if sd else f"{value:g}"


def leave_out(axis: Axis, /, *names: str, **values: float) -> Axis:
    """Return the axis without parameters that a record does not show; the others are identified.

    The known value of a parameter replaces it (see `fix`), otherwise 0, so that its term vanishes;
    a parameter that enters nonlinearly is fixed at its nominal value. Parameters that then no
    longer appear are left out too. All are in `Axis.left_out`, and in every result.

    Parameters
    ----------
    axis : Axis
    *names : str
        Names of declared parameters.
    **values : float
        Values by name, SI, at which further parameters are fixed and left out.

    Raises
    ------
    UsageError
        The axis has no such parameter, no value can replace one, or no parameter remains to
        identify.
    ModelError
        Without them the axis has no inertia.
    """
    _check_declared(axis, (*names, *values), "leave out")
    held = {
        p.symbol: number(values[name], f"the value that stands for {name!r}")
        if (name := p.name) in values
        else _held(axis, p)
        for p in axis.parameters
        if p.name in names or p.name in values
    }
    # Replace the parameters by their values, and find the parameters that still occur.
    numbers = {s: sympy.Float(v) if v else sympy.S.Zero for s, v in held.items()}
    force, profile = replaced_in(axis.force, numbers), axis.drive.profile.xreplace(numbers)
    inside = (value.free_symbols for state in states_in(force) for value in state.values)
    used = profile.free_symbols.union(force.free_symbols, *inside)
    kept = tuple(p for p in axis.parameters if p.symbol in used)
    if not kept:
        without = ", ".join(map(str, held))
        raise UsageError(
            f"axis {axis.name!r} has no parameter to identify without {without}. Leave out fewer "
            "parameters.",
            code="parameters",
        )
    left = tuple(  # the bounds do not apply to the value that replaces each parameter
        replace(
            p,
            lower=-math.inf,
            upper=math.inf,
            known=held.get(p.symbol, p.nominal),
            known_sd=0.0,
        )
        for p in axis.parameters
        if p not in kept
    )
    experiment, stays = axis.experiment, {p.name for p in kept}
    return replace(
        axis,
        parameters=kept,
        force=force,
        drive=replace(axis.drive, profile=profile),
        experiment=experiment
        and replace(experiment, truth={n: v for n, v in experiment.truth.items() if n in stays}),
        left_out=(*axis.left_out, *left),
    )


def left_out_text(axis: Axis) -> str:
    """Return left-out parameters with their values and units as text; empty without any."""
    return ", ".join(
        f"{p.name} = {known_text(p.known, p.known_sd)} {p.unit}" for p in axis.left_out
    )


def _check_declared(axis: Axis, names: Iterable[str], what: str) -> None:
    """Refuse an object that is not an axis, and names that are not parameters of the axis.

    Parameters
    ----------
    what : str
        What the caller does to the parameters, for the message: ``fix`` or ``leave out``.
    """
    check_axis(axis)
    declared = [p.name for p in axis.parameters]
    for name in names:
        if not is_among(name, declared):
            raise UsageError(
                f"there is no parameter {quoted(name)} to {what}. Axis {axis.name!r} has "
                f"{', '.join(declared)}.",
                code="parameters",
            )


def _held(axis: Axis, parameter: Parameter) -> float:
    """Return the value, SI, at which a left-out parameter is held.

    It is the known value, if there is one; otherwise 0 for a parameter that enters linearly, and
    the nominal value for one that enters nonlinearly or in the equation of an internal state.

    Raises
    ------
    UsageError
        The parameter enters nonlinearly and has neither a known nor a nominal value.
    """
    if parameter.known is not None:
        return parameter.known
    expressions = (axis.force, axis.drive.profile)
    inside = (value.free_symbols for state in axis.states for value in state.values)
    symbol = parameter.symbol
    remembered = symbol in frozenset[sympy.Symbol]().union(*inside)
    if not remembered and not any(symbol in e.diff(symbol).free_symbols for e in expressions):
        return 0.0  # it enters linearly
    if parameter.nominal:
        return parameter.nominal
    raise UsageError(
        f"the model is nonlinear in {parameter.name}, which has no nominal value at which it could "
        f"be fixed. Declare a nominal value, or fix it with "
        f"{setting('fix', {parameter.name: 'VALUE'})}.",
        code="parameters",
    )
