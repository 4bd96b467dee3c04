"""Axes with a term that their own motion hardly shows."""

from dataclasses import replace

import sympy

from axisid import Axis, Constant, Parameter, load_axis
from axisid.elements import stribeck

FS = Parameter("Fs", "N", nominal=10.0)


def with_term(
    parameter: Parameter,
    term: sympy.Expr,
    truth: float,
    others: dict[Parameter, float] | None = None,
) -> Axis:
    """The paper's axis with one more term, and what other parameters it has."""
    axis, more = load_axis("emps2015"), {parameter: truth, **(others or {})}
    told = {**axis.experiment.truth, **{p.name: value for p, value in more.items()}}
    return replace(
        axis,
        name="unseen",
        parameters=(*axis.parameters, *more),
        force=axis.force + term,
        experiment=replace(axis.experiment, truth=told),
    )


def with_stribeck(speed: float) -> Axis:
    """With 12 N of Stribeck friction, at speeds that no row has if `speed` is small."""
    return with_term(FS, stribeck(FS, load_axis("emps2015").coordinate, velocity=speed), 12.0)


def with_bump(place: float, nominal: float = 10.0) -> Axis:
    """With a force of 12 N about a place in m, 10 mm wide; the motion ends at 45 mm."""
    Fb = Parameter("Fb", "N", nominal=nominal)
    q = load_axis("emps2015").coordinate.symbol
    return with_term(Fb, Fb * sympy.exp(-(((q - place) / 0.01) ** 2)), 12.0)


def with_bump_somewhere(place: float) -> Axis:
    """With -12 N about a place that is a parameter, 5 mm wide; nothing says where it is."""
    Fb, at = Parameter("Fb", "N", nominal=10.0), Parameter("at", "m")
    q, wide = load_axis("emps2015").coordinate.symbol, Constant(0.005, "m")
    return with_term(Fb, Fb * sympy.exp(-(((q - at) / wide) ** 2)), -12.0, {at: place})
