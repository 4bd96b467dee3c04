"""Axes with a term that their own motion hardly shows."""

from dataclasses import replace

import sympy

from axisid import Axis, Parameter, load_axis
from axisid.elements import stribeck

FS = Parameter("Fs", "N", nominal=10.0)


def with_term(parameter: Parameter, term: sympy.Expr, truth: float) -> Axis:
    """The paper's axis with one more term."""
    axis = load_axis("emps2015")
    assert axis.experiment is not None
    return replace(
        axis,
        name="unseen",
        parameters=(*axis.parameters, parameter),
        force=axis.force + term,
        experiment=replace(axis.experiment, truth={**axis.experiment.truth, parameter.name: truth}),
    )


def with_stribeck(speed: float) -> Axis:
    """With 12 N of Stribeck friction, at speeds that no row has if `speed` is small."""
    return with_term(FS, stribeck(FS, load_axis("emps2015").coordinate, velocity=speed), 12.0)


def with_bump(place: float, nominal: float = 10.0) -> Axis:
    """With a force of 12 N about a place in m, 10 mm wide; the motion ends at 45 mm."""
    Fb = Parameter("Fb", "N", nominal=nominal)
    q = load_axis("emps2015").coordinate.symbol
    return with_term(Fb, Fb * sympy.exp(-(((q - place) / 0.01) ** 2)), 12.0)
