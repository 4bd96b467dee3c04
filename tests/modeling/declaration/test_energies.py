"""Energies depend on what they may, and inertias are positive."""

from collections.abc import Callable

import pytest
import sympy

from axisid import (
    Axis,
    Constant,
    Coordinate,
    Parameter,
    derive,
    lagrange,
    newton,
)
from axisid.elements import Drive
from tests.refusals import refused

x = Coordinate("x")
X, DX, DDX = x.symbol, x.velocity, x.acceleration
m = Parameter("m", "kg", nominal=6.2)
n = Parameter("n", "kg")
k, b = Parameter("k", "N/m"), Parameter("b", "N/(m/s)")
S = Constant(1.0, "s").symbol
L = Constant(1.0, "m").symbol
HALF = m * DX**2 / 2


def axis(parameters: tuple[Parameter, ...] = (m, b), **energies: sympy.Expr) -> Axis:
    return lagrange(
        "t",
        coordinate=x,
        parameters=parameters,
        **{"kinetic": HALF, "dissipation": b * DX**2 / 2, **energies},
        drive=Drive(gain=1.0),
    )


test_an_energy_of_something_else_is_refused_by_its_name = refused(
    ("equation", rf"^axis 't': .*{message}", lambda energies=energies: axis(**energies))
    for energies, message in [
        ({"potential": m * X * DDX}, r"potential energy .* depends on ddx. It may depend on"),
        ({"potential": b * X * DX}, r"potential energy .* depends on dx.*friction into the diss"),
        (
            {"potential": m * X * DDX + b * X * DX},
            r"depends on dx and ddx. It may depend on the position x only",
        ),
        ({"dissipation": b * DX**2 / 2 + m * DX * DDX}, r"dissipation function .* on ddx.*kinet"),
        ({"kinetic": HALF + m * X * DDX}, r"kinetic energy .* depends on ddx.*square of the vel"),
        (
            {"kinetic": m * DX**3 * S / L / 2},
            r"kinetic energy .* is not proportional to the square of the velocity",
        ),
        (
            {"kinetic": m * DX * sympy.Abs(DX) / 2},
            r"is not proportional to the square of the velocity dx. Write an",
        ),
        (
            {"kinetic": m * sympy.Max(0, DX) ** 2 / 2},
            r"is not proportional to the square of the velocity",
        ),
        ({"kinetic": HALF + b * X * DX / 2}, r"is not proportional to the square of the velocity"),
        (
            {"kinetic": HALF + b * X**2 / S / 2},
            r"at rest as a potential energy, with the opposite sign",
        ),
        (
            {"kinetic": -HALF},
            r"the inertia -m is negative with the nominal values.*the sign of the inertia",
        ),
    ]
)


def newtonian(inertia: sympy.Expr, *parameters: Parameter) -> Axis:
    return newton(
        "t", coordinate=x, parameters=parameters, inertia=inertia, resistance=(),
        drive=Drive(gain=1.0),
    )  # fmt: skip


def energetic(inertia: sympy.Expr, *parameters: Parameter) -> Axis:
    return lagrange(
        "t", coordinate=x, parameters=parameters, kinetic=inertia * DX**2 / 2,
        drive=Drive(gain=1.0),
    )  # fmt: skip


test_a_negative_inertia_is_refused = refused(
    ("equation", "is negative", lambda make=make, given=given: make(*given))
    for make in [newtonian, energetic]
    for given in [
        (-m.symbol, m),
        (-n.symbol, n),
        (-n - 3 * m, m, n),
        (m - 10 * n, m, Parameter("n", "kg", nominal=1.0)),
        (m - 10 * n, m, Parameter("n", "kg", known=1.0)),
        (n.symbol, Parameter("n", "kg", nominal=-2.0, upper=-1.0)),
    ]
)


@pytest.mark.parametrize("declare", [newtonian, energetic])
@pytest.mark.parametrize(
    ("inertia", "parameters"),
    [
        (m.symbol, (m,)),
        (n.symbol, (n,)),
        (m - n, (m, n)),
        (2 * n - 3 * m, (m, n)),
        (-n.symbol, (Parameter("n", "kg", upper=0.0),)),
        (-n.symbol, (Parameter("n", "kg", nominal=-1.0),)),
        (m * sympy.sqrt(n / m - 9), (m, n)),
    ],
)
def test_an_inertia_that_may_be_positive_is_not(
    declare: Callable[..., Axis], inertia: sympy.Expr, parameters: tuple[Parameter, ...]
) -> None:
    assert declare(inertia, *parameters).parameters == parameters


@pytest.mark.parametrize(
    "kinetic",
    [
        (m + n * sympy.cos(X / L)) * DX**2 / 2,
        m * (X.diff(X) * DX) ** 2 / 2 + n * sympy.Max(0, X / L) * DX**2 / 2,
        m * ((X + L) ** 2 - X**2 - 2 * X * L) / L**2 * DX**2 / 2 + n * DX**2 / 2,
        0.5 * m * (0.3 * DX) ** 2 + n * DX**2 / 2,
    ],
    ids=str,
)
def test_half_an_inertia_times_a_square_is_right_however_it_is_written(kinetic: sympy.Expr) -> None:
    assert derive(axis((m, n, b), kinetic=kinetic)).inertia != 0
