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

    The known parameters remain parameters. If a record alone does not distinguish the physical
    parameters, the unknown parameters follow from the known ones, with their uncertainty. If a
    record distinguishes them, estimate and known value are combined according to their standard
    deviations.

    Parameters
    ----------
    axis : Axis
    **values : float or (float, float)
        Known values by name, SI: an exact value, or a value with its standard deviation, as in
        ``m=(2.0, 0.02)``.

    Raises
    ------
    UsageError
        The axis has no such parameter, or a value is a sequence of another length than 2.
    ModelError
        A value is outside its parameter's bounds, or a standard deviation is negative.
    """
    _check_declared(axis, values, "fix")
    refuse(
        UsageError,
        *(
            (
                isinstance(value, (tuple, list)) and len(value) != 2,
                f"the fixed value of {name!r} is {value!r}. Give a number, or a pair of a number "
                "and its standard deviation",
            )
            for name, value in values.items()
        ),
        code="parameters",
    )
    pairs = {n: v if isinstance(v, (tuple, list)) else (v, 0.0) for n, v in values.items()}
    parameters = []
    for p in axis.parameters:
        if p.name in pairs:
            known, known_sd = pairs[p.name]
            parameters.append(replace(p, known=known, known_sd=known_sd))
        else:
            parameters.append(p)
    return replace(axis, parameters=tuple(parameters))


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
            raise UsageError(
                f"{match[1]!r} is fixed twice. Fix each parameter once.", code="parameters"
            )
        fixed[match[1]] = (float(match[2]), float(match[3] or 0.0))
    return fixed


def known_text(value: float | None, sd: float) -> str:
    """Return a known value with its standard deviation as text, ``2 +- 0.02``; ``2`` if exact."""
    return f"{value:g} +- {sd:g}" if sd else f"{value:g}"


def leave_out(axis: Axis, /, *names: str, **values: float) -> Axis:
    """Return the axis without parameters that a record does not show; the others are identified.

    A parameter that is left out is replaced by its known value (see `fix`), or else by 0, so that
    its term vanishes. A parameter that enters nonlinearly is replaced by its nominal value instead
    of 0. Parameters that then no longer occur are left out too. All parameters that are left out
    are in `Axis.left_out`, and in every result.

    Parameters
    ----------
    axis : Axis
    *names : str
        Names of declared parameters to leave out.
    **values : float
        Values by name, SI, by which further parameters are replaced.

    Raises
    ------
    UsageError
        The axis has no such parameter, no value can replace one, or no parameter remains to
        identify.
    ModelError
        The axis has no inertia without these parameters.
    """
    _check_declared(axis, (*names, *values), "leave out")
    replacements: dict[sympy.Symbol, float] = {}
    for p in axis.parameters:
        if p.name in values:
            replacements[p.symbol] = number(values[p.name], f"the value that replaces {p.name!r}")
        elif p.name in names:
            replacements[p.symbol] = _replacement(axis, p)
    # Replace the parameters by their values, and find the parameters that still occur.
    numbers = {s: sympy.Float(v) if v else sympy.S.Zero for s, v in replacements.items()}
    force, profile = replaced_in(axis.force, numbers), axis.drive.profile.xreplace(numbers)
    inside = (value.free_symbols for state in states_in(force) for value in state.values)
    used = profile.free_symbols.union(force.free_symbols, *inside)
    kept = tuple(p for p in axis.parameters if p.symbol in used)
    if not kept:
        without = ", ".join(map(str, replacements))
        raise UsageError(
            f"axis {axis.name!r} has no parameter to identify without {without}. Leave out fewer "
            "parameters.",
            code="parameters",
        )
    left_out = tuple(  # the bounds do not apply to the value that replaces a parameter
        replace(
            p,
            lower=-math.inf,
            upper=math.inf,
            known=replacements.get(p.symbol, p.nominal),
            known_sd=0.0,
        )
        for p in axis.parameters
        if p not in kept
    )
    experiment, kept_names = axis.experiment, {p.name for p in kept}
    if experiment is not None:
        truth = {name: value for name, value in experiment.truth.items() if name in kept_names}
        experiment = replace(experiment, truth=truth)
    return replace(
        axis,
        parameters=kept,
        force=force,
        drive=replace(axis.drive, profile=profile),
        experiment=experiment,
        left_out=(*axis.left_out, *left_out),
    )


def left_out_text(axis: Axis) -> str:
    """Return the parameters that are left out as text, with values and units; empty if none."""
    return ", ".join(
        f"{p.name} = {known_text(p.known, p.known_sd)} {p.unit}" for p in axis.left_out
    )


def _check_declared(axis: Axis, names: Iterable[str], what: str) -> None:
    """Refuse an object that is not an axis, and names that are not parameters of the axis.

    Parameters
    ----------
    axis : Axis
    names : iterable of str
    what : str
        Verb for the message: ``fix`` or ``leave out``.
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


def _replacement(axis: Axis, parameter: Parameter) -> float:
    """Return the value, SI, that replaces a parameter that is left out.

    It is the known value, if there is one. Otherwise it is 0 for a parameter that enters linearly,
    and the nominal value for a parameter that enters nonlinearly or in the equation of an internal
    state.

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
    is_in_state = symbol in frozenset[sympy.Symbol]().union(*inside)
    if not is_in_state and not any(symbol in e.diff(symbol).free_symbols for e in expressions):
        return 0.0  # the parameter enters linearly
    if parameter.nominal:
        return parameter.nominal
    raise UsageError(
        f"the model is nonlinear in {parameter.name}, which has no nominal value at which it could "
        f"be fixed. Declare a nominal value, or fix it with "
        f"{setting('fix', {parameter.name: 'VALUE'})}.",
        code="parameters",
    )
