"""Energies and forces with kinks have derivatives that code can be generated for."""

import numpy as np
import pytest
import sympy
from sympy import Abs, Heaviside, Max, Min, sign

from axisid import Axis, Coordinate, Parameter, build, derive, lagrange
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.elements import Drive
from axisid.modeling.quantities.derivative import slope
from tests.axes.bodies import energetic, turn
from tests.refusals import refused

x = Coordinate("x")
M, k, F = Parameter("M", "kg", nominal=1.0), Parameter("k", "N/m"), Parameter("F", "N")
v, j, c = Parameter("v", "N/(m/s)"), Parameter("j", "kg/m"), Parameter("c", "m")
Q, DQ = x.symbol, x.velocity
A = sympy.Rational(1, 10)


def axis(*extra: Parameter, kinetic: sympy.Expr | float = 0, **energies: sympy.Expr) -> Axis:
    return lagrange(
        "kinked",
        coordinate=x,
        parameters=(M, *extra),
        kinetic=M * DQ**2 / 2 + kinetic,
        drive=Drive(gain=1.0),
        **energies,
    )


@pytest.mark.parametrize(
    ("energy", "expected"),
    [
        (Max(0, Q) ** 2 / 2, Max(0, Q)),
        (Max(sympy.Float(0), Q) ** 2 / 2, Max(0, Q)),
        (Min(0, Q - A) ** 2 / 2, Min(0, Q - A)),
        (Max(0, Abs(Q) - A) ** 2 / 2, sign(Q) * Max(0, Abs(Q) - A)),
        (Max(0, Q), Heaviside(Q)),
        (Max(0, 2 * Q - 1) ** 3, 6 * Max(0, 2 * Q - 1) ** 2),
        (Q**2 * sign(Q) / 2, Q * sign(Q)),
        (Abs(sympy.sqrt(Q + 3) - 2), sign(sympy.sqrt(Q + 3) - 2) / sympy.sqrt(Q + 3) / 2),
        (Max(Q, Q**2), 2 * Q * Heaviside(Q**2 - Q) + Heaviside(Q - Q**2)),
    ],
    ids=str,
)
def test_slope_beside_a_kink_is_that_of_the_side(energy: sympy.Expr, expected: sympy.Expr) -> None:
    found = slope(energy, Q, "it")
    for value in (sympy.Rational(-7, 3), sympy.Rational(1, 20), sympy.Rational(5, 2)):
        assert float(found.subs(Q, value)) == float(expected.subs(Q, value))


@pytest.mark.parametrize("energy", [Max(0, Q), Max(Q, 2 * Q), Min(Q, 0), Abs(Q) + Q], ids=str)
def test_slope_at_a_kink_is_the_mean_of_both_sides(energy: sympy.Expr) -> None:
    right, left = (energy.subs(Q, side) * side for side in (1, -1))
    assert slope(energy, Q, "it").subs(Q, 0) == (right + left) / 2


def test_a_step_that_changes_nothing_is_left_out() -> None:
    assert slope(Max(0, Q - A) ** 2 / 2, Q, "it") == Max(0, Q - A)
    assert slope(Min(0, A - Q) ** 2 / 2, Q, "it") == -Min(0, A - Q)


@pytest.mark.parametrize(
    "declared",
    [
        axis(k, potential=k * Max(0, Q) ** 2 / 2),
        axis(k, potential=k * Max(0, Q - 2, -Q - 1) ** 2 / 2),
        axis(F, potential=F * Max(Q, A)),
        axis(F, potential=F * Abs(Q - A)),
        axis(k, potential=k * Min(Q**2, A)),
        axis(k, c, potential=k * Max(0, Q - c.symbol) ** 2 / 2),
        axis(k, c, potential=k * Abs(Q - c.symbol) ** 3 / 3 / A),
        axis(F, potential=F * A * Abs(sympy.sqrt(Q / A + 3) - 2)),
        axis(v, dissipation=v * Max(0, DQ - A) ** 2 / 2),
        axis(j, kinetic=j * Max(0, Q) * DQ**2 / 2),
    ],
    ids=lambda declared: str(declared.force),
)
def test_an_axis_with_kinks_is_derived_and_generated(declared: Axis) -> None:
    assert axis_artefacts(derive(declared))


def test_a_spring_of_unknown_exponent_is_finite_where_it_is_free() -> None:
    K = Parameter("K", "N m", nominal=2.0)
    p = Parameter("p", "1", nominal=1.5)
    contact = K * Max(0, turn.symbol) ** (p.symbol + 1) / (p.symbol + 1)
    declared = energetic(parameters=(K, p), potential=contact)
    rows, _ = build(declared, native=False).evaluate(
        "idm_regressor",
        *np.array([[-1.0, 0.0, 0.25], 3 * [0.0], 3 * [1.0], 3 * [0.0]]),
        [1, 2, 1.5],
    )
    assert rows[:, 0].tolist() == [1, 1, 1]
    assert rows[:, 1] == pytest.approx([0, 0, 0.125], rel=1e-12)
    assert rows[:, 2] == pytest.approx([0, 0, 2 * 0.125 * np.log(0.25)], rel=1e-12)


def test_friction_in_one_direction_follows_the_friction_direction() -> None:
    force = derive(axis(F, dissipation=F * Max(0, DQ))).force
    direction = sympy.Symbol("direction", real=True)
    assert force == M * x.acceleration + F * ((1 + direction) / 2)


test_an_energy_or_a_force_that_jumps_is_refused = refused(
    ("equation", says, lambda stored=stored: derive(axis(F, c, potential=stored)))
    for stored, says in [
        (F * sign(Q), "the potential energy jumps with x"),
        (F * sign(2 * Q - 1), "the potential energy jumps with x"),
        (F * sign(sympy.sin(Q)), "the potential energy jumps with x"),
        (F * Max(0, Q - c.symbol), "the force jumps with c"),
    ]
)
