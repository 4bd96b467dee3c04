"""What is generated gives the declared force, in every target, also where its terms cancel."""

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
import sympy

from axisid import Axis, Constant, Parameter, build, derive
from axisid.codegen.printers.python import print_python
from axisid.codegen.printers.structured_text import print_st
from axisid.elements import Drive, coulomb, cubic_spring, stribeck, viscous
from axisid.modeling.quantities.constants import with_numbers
from tests.axes.bodies import rotor, turn as q
from tests.codegen.lowering.test_feed_forward import exported, in_python, in_st
from tests.codegen.oracle import Oracle

b = Parameter("b", "N m/(rad/s)", nominal=0.5)
F, k3 = Parameter("F", "N m", nominal=3.0), Parameter("k3", "N m", nominal=2.0)
mu = Parameter("mu", "1", nominal=0.5)
Q, DQ = q.symbol, q.velocity


def stage(*resistance: sympy.Expr, parameters: tuple[Parameter, ...], profile: float = 1) -> Axis:
    drive = Drive(gain=1.0, profile=profile)
    return rotor(viscous(b, q), *resistance, parameters=(b, *parameters), drive=drive)


#: Where terms cancel if a power or an exponential is multiplied out, and motions to see it.
AWKWARD = {
    "power of a difference": (stage(F * ((Q - 2) / 0.1) ** 12, parameters=(F,)), 2.05),
    "cubic spring at 1 m": (stage(cubic_spring(k3, q, rest=1), parameters=(k3,)), 1.001),
    "cubic spring at 10 m": (stage(cubic_spring(k3, q, rest=10), parameters=(k3,)), 10.0001),
    "root of a difference": (
        stage(F * sympy.sqrt((Q - 100) ** 2 + 1e-14), parameters=(F,)),
        100.0000003,
    ),
    "exponential over a profile": (
        stage(
            stribeck(F, q, velocity=0.01),
            parameters=(F,),
            profile=1 + 0.05 * sympy.cos(2 * sympy.pi * q / 0.03),
        ),
        0.015,
    ),
    "power with a direction": (
        stage(F * (Q - 2) ** 9 * (1 + sympy.sign(DQ)) ** 2, parameters=(F,)),
        2.01,
    ),
    "known power": (stage(coulomb(F, q), 3.1 * (Q - 5) ** 9, parameters=(F,)), 5.001),
    "product of parameters": (stage(F * mu * (Q - 3) ** 7, parameters=(F, mu)), 3.01),
    "one for each direction": (
        stage(
            sympy.Piecewise((F * (Q - 4) ** 9, DQ < 0), (k3 * (Q - 4) ** 9, True)),
            parameters=(F, k3),
        ),
        4.01,
    ),
}
#: Where a number that SymPy takes out of an exponent is 0 or infinite, and where to see it.
FAR = {
    "exponential far away": (
        stage(F * sympy.exp((Q - 10000.0) * 1.5), parameters=(F,)),
        10000.2,
    ),
    "exponential far away, by a constant": (
        stage(F * sympy.exp((Q - Constant(10000.0, "rad").symbol) * 1.5), parameters=(F,)),
        10000.2,
    ),
    "exponential of what falls": (
        stage(F * sympy.exp((3000.0 - Q) * 1.5) * sympy.sin(Q), parameters=(F,)),
        3000.2,
    ),
    "product with a power": (
        stage(F * ((Q - 3000.0) / 0.1) ** 3 * sympy.exp((Q - 3000.0) * 1.5), parameters=(F,)),
        3000.2,
    ),
    "exponential beside the largest number": (
        stage(F * sympy.exp((Q - 480.0) * 1.5), parameters=(F,)),
        490.0,
    ),
    "step of an exponential": (
        stage(F / (1 + sympy.exp((Q - 3000.0) / 0.1)) ** 2, parameters=(F,)),
        3000.05,
    ),
    "bend of an exponential": (
        stage(F * sympy.log(1 + sympy.exp((Q - 3000.0) * 1.5)), parameters=(F,)),
        3000.2,
    ),
    "power of a number far away": (
        stage(F * 4 * 2.0 ** ((Q - 3000.0) * 1.5), parameters=(F,)),
        3000.2,
    ),
    "hyperbolic far away": (
        stage(
            F * sympy.cosh((Q - 3000.0) * 1.5),
            k3 * sympy.tanh((Q - 3000.0) * 1.5) / sympy.cosh(Q - 3000.0),
            parameters=(F, k3),
        ),
        3000.2,
    ),
}
#: By position, velocity and acceleration.
Targets = dict[str, Callable[[float, float, float], float]]


def targets(axis: Axis, values: np.ndarray) -> Targets:
    """The inverse dynamics in every language, with declared parameters."""
    model = derive(axis)
    made = build(axis)
    made.native.library()
    own = np.array(model.base.at(list(values)))
    export = exported(model.axis, own)
    name = export.functions[0]
    machine = made.functions["inverse_dynamics"]
    row = made.functions["idm_regressor"]
    theta = (own,) if "parameters" in row.name_in() else ()

    def by_columns(x: float, v: float, a: float) -> float:
        columns, known = row(x, v, a, np.sign(v), *theta)
        return float(columns @ own + known)

    forward = made.functions["direct_dynamics"]

    def by_acceleration(x: float, v: float, a: float) -> float:
        known, one, force = (float(machine(x, v, each, np.sign(v), own)) for each in (0.0, 1.0, a))
        return known + float(forward(x, v, force, np.sign(v), own)) * (one - known)

    return {
        "direct dynamics": by_acceleration,
        "virtual machine": lambda x, v, a: float(machine(x, v, a, np.sign(v), own)),
        "columns": by_columns,
        "Python": in_python(print_python(export), *export.functions)[name],
        "Structured Text": in_st(print_st(export), *export.functions)[name],
        "C": lambda x, v, a: float(
            made.evaluate("inverse_dynamics", x, v, a, np.sign(v), own)[0][0, 0]
        ),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", [*AWKWARD, *FAR])
def test_every_target_has_the_declared_force_where_terms_cancel(name: str) -> None:
    axis, place = {**AWKWARD, **FAR}[name]
    c, values = axis.coordinate, np.array([p.nominal for p in axis.parameters])
    what = targets(axis, values)
    force = with_numbers(axis.force / axis.drive.profile)
    given = {p.symbol: x for p, x in zip(axis.parameters, values, strict=True)}
    for motion in product((place, place + 0.3, place - 0.4), (0.27, -0.4, 1e-3), (0.7,)):
        point = dict(zip((c.symbol, c.velocity, c.acceleration), motion, strict=True))
        declared = Oracle({**point, **given})(force)
        for target, function in what.items():
            off = abs(function(*motion) - float(declared.exact))
            assert off <= 1e3 * float(declared.error), (target, motion)
