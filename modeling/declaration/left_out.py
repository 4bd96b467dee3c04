"""Parameters that are left out of what is identified: a value stands for each."""

import math
from dataclasses import replace

import sympy

from axisid.modeling.quantities import Parameter, number
from axisid.support.errors import UsageError
from axisid.support.remedy import Remedy, Setting
from axisid.support.user_values import is_among, quoted

from .axis import Axis, check_axis
from .known_values import known_text


def leave_out(axis: Axis, /, *names: str, **values: float) -> Axis:
    """The axis without parameters that a record does not show; the others are identified.

    What is known of a parameter stands for it (see `fix`), else 0, so that its term is gone; one
    that enters nonlinearly is held at its nominal value. Parameters that then no longer appear are
    left out too. All are in `Axis.left_out`, and in every result.

    Parameters
    ----------
    axis : Axis
    *names : str
        Of declared parameters.
    **values : float
        By name, SI: parameters that are left out too, held at these.

    Raises
    ------
    UsageError
        The axis has no such parameter, no value can stand for one, or nothing is left to identify.
    ModelError
        Without them the axis has no inertia.
    """
    check_axis(axis)
    declared = {p.name: p for p in axis.parameters}
    for name in (*names, *values):
        if not is_among(name, declared):
            raise UsageError(
                f"there is no parameter {quoted(name)} to leave out; axis {axis.name!r} has "
                f"{', '.join(declared)}.",
                code="leave-out-unknown",
            )
    held = {
        p.symbol: number(values[name], f"the value that stands for {name!r}")
        if (name := p.name) in values
        else _held(axis, p)
        for p in axis.parameters
        if p.name in names or p.name in values
    }
    numbers = {s: sympy.Float(v) if v else sympy.S.Zero for s, v in held.items()}
    force, profile = axis.force.xreplace(numbers), axis.drive.profile.xreplace(numbers)
    used = force.free_symbols | profile.free_symbols
    kept = tuple(p for p in axis.parameters if p.symbol in used)
    if not kept:
        without = ", ".join(map(str, held))
        raise UsageError(
            f"axis {axis.name!r} has nothing left to identify without {without}; leave fewer "
            "parameters out.",
            code="nothing-left",
        )
    gone = [p for p in axis.parameters if p not in kept]
    experiment, stays = axis.experiment, {p.name for p in kept}
    return replace(
        axis,
        parameters=kept,
        force=force,
        drive=replace(axis.drive, profile=profile),
        experiment=experiment
        and replace(experiment, truth={n: v for n, v in experiment.truth.items() if n in stays}),
        left_out=(*axis.left_out, *(_standing(p, held.get(p.symbol, p.nominal)) for p in gone)),
    )


def left_out_text(axis: Axis) -> str:
    """What stands for the parameters that were left out, in words; empty for none."""
    return ", ".join(f"{p.name} = {known_text(p)} {p.unit}" for p in axis.left_out)


def _standing(parameter: Parameter, value: float) -> Parameter:
    """A parameter with the value that stands for it, which its bounds need not hold."""
    return replace(parameter, lower=-math.inf, upper=math.inf, known=value, known_sd=0.0)


def _held(axis: Axis, parameter: Parameter) -> float:
    """The value that stands for a parameter."""
    if parameter.known is not None:
        return parameter.known
    expressions = (axis.force, axis.drive.profile)
    if not any(_bends(e, parameter.symbol) for e in expressions):
        return 0.0
    if parameter.nominal:
        return parameter.nominal
    raise UsageError(
        f"{parameter.name} enters nonlinearly and has no nominal value to hold it at; ",
        Remedy.of("declare one, or fix it: ", Setting("fix", f"{parameter.name}=VALUE"), "."),
        code="no-nominal",
    )


def _bends(expression: sympy.Expr, symbol: sympy.Symbol) -> bool:
    """Whether an expression is more than linear in a symbol."""
    return symbol in expression.diff(symbol).free_symbols
