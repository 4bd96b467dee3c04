"""What jumps where the velocity changes its sign goes by the friction direction, nothing else."""

import re

import pytest
import sympy
from sympy import Abs, And, Heaviside, Or, Piecewise, sign

from axisid import Parameter, build, derive
from axisid.modeling.derivation.inverse import with_direction
from axisid.modeling.quantities.symbols import DIRECTION
from tests.axes.bodies import rotor, turn
from tests.refusals import refused

Q, DQ, D = turn.symbol, turn.velocity, DIRECTION
b1, b2, b3 = (Parameter(f"b{i}", "N m/(rad/s)", nominal=float(i)) for i in (1, 2, 3))
F, G = Parameter("F", "N m", nominal=3.0), Parameter("Fg", "N m", nominal=5.0)
B1, B2, A, B = b1.symbol, b2.symbol, F.symbol, G.symbol


#: What is continuous at rest stays as it was declared.
CONTINUOUS = [
    Piecewise((B1 * DQ, Q < 0), (B2 * DQ, True)),
    Piecewise((B1 * DQ, DQ < 0), (B2 * DQ, True)),
    Piecewise((B1 * DQ, And(Q < 0, DQ < 0)), (B2 * DQ, True)),
    Piecewise((B1 * DQ, DQ * Q > 0), (B2 * DQ, True)),
    A * Piecewise((-1, DQ < -0.01), (100 * DQ, DQ < 0.01), (1, True)),
    A * Piecewise((DQ / 0.03, DQ / 0.03 < 1), (1, True)),
    A * Piecewise((DQ**2, DQ**2 < 0.25), (0.25, True)),
    B1 * (DQ - B) * Heaviside(DQ - B),
    B1 * (DQ - 1) * sign(DQ - 1),
    B1 * Piecewise((DQ - Q, DQ > Q), (0, True)),
    A * Abs(DQ) + B * sympy.Max(0, DQ - 1),
]


@pytest.mark.parametrize("force", CONTINUOUS, ids=str)
def test_what_is_continuous_at_rest_stays(force: sympy.Expr) -> None:
    assert with_direction(force, DQ) == force


#: Forces, and what they are for positive and for negative velocity.
DIRECTED = [
    (A * sign(DQ) ** 3 + B * sign(DQ) ** 2, A + B, -A + B),
    (A * Heaviside(DQ), A, 0),
    (A * Heaviside(DQ, 1), A, 0),
    (A * Heaviside(-DQ), 0, A),
    (A * Heaviside(2 * DQ) ** 2, A, 0),
    (A * sign(-3 * DQ**3), -A, A),
    (A * sign(DQ * Q), A * sign(Q), -A * sign(Q)),
    (Piecewise((A + B1 * DQ, DQ > 0), (-B + B2 * DQ, True)), A + B1 * DQ, -B + B2 * DQ),
    (Piecewise((A, DQ > 0), (-B, DQ < 0), (0, True)), A, -B),
    (Piecewise((0, sympy.Eq(DQ, 0)), (A, DQ > 0), (-B, True)), A, -B),
    (Piecewise((A, And(DQ >= 0, Q > 0)), (B, True)), Piecewise((A, Q > 0), (B, True)), B),
    (Piecewise((A, Or(DQ > 0, Q > 0)), (B, True)), A, Piecewise((A, Q > 0), (B, True))),
    (Piecewise((A, sign(DQ) > 0), (-B, True)), A, -B),
    (Piecewise((A, DQ * sign(DQ) > 0), (-B, True)), A, A),
    ((A + B * sign(DQ)) * (1 + sign(DQ)), 2 * (A + B), 0),
    ((Q - 2 + sign(DQ)) ** 4 * A, (Q - 1) ** 4 * A, (Q - 3) ** 4 * A),
    (A * Piecewise((sign(DQ), Q < 0), (2 * sign(DQ) ** 2, True)), None, None),
    (A * Piecewise((100 * DQ, Abs(DQ) < 0.01), (sign(DQ), True)), None, None),
]


@pytest.mark.parametrize(("force", "ahead", "back"), DIRECTED, ids=lambda value: str(value))
def test_what_jumps_with_the_direction_is_affine_in_it(
    force: sympy.Expr, ahead: sympy.Expr | None, back: sympy.Expr | None
) -> None:
    made = with_direction(force, DQ)
    assert made.has(DIRECTION) or ahead == back
    assert DIRECTION not in made.diff(DIRECTION).free_symbols
    for side, value in ((1, ahead), (-1, back)):
        there = made.xreplace({DIRECTION: sympy.Integer(side)})
        if value is not None:
            assert sympy.simplify(there - value) == 0
        for place in (sympy.Rational(7, 3), sympy.Rational(-5, 2)):
            point = {Q: place, DQ: sympy.Rational(3 * side, 4)}
            assert sympy.expand(there.xreplace(point) - force.xreplace(point)) == 0


test_what_jumps_elsewhere_is_refused_by_its_name = refused(
    (
        "equation",
        f"the term {re.escape(str(node))} jumps with the velocity",
        lambda jump=jump: with_direction(A * jump + B * DQ, DQ),
    )
    for jump in [
        sign(DQ - 1),
        sign(DQ - Q),
        Heaviside(DQ + B),
        Piecewise((1, DQ < 1), (2, True)),
        Piecewise((0, DQ < -0.01), (100 * DQ, DQ < 0.01), (1, True)),
        Piecewise((DQ, DQ**2 < B**2), (0, True)),
        Piecewise((DQ, sympy.exp(DQ) < 2), (0, True)),
        Piecewise((1, And(Q < 0, DQ < 1)), (2, True)),
        1e-9 * sign(DQ - 1e-3),
        sign(B * DQ - 1),
    ]
    for node in jump.atoms(sign, Heaviside, Piecewise)
)


NONLINEAR = [sympy.exp(sign(DQ)), sympy.sqrt(2 + sign(DQ)), 1 / (2 + sign(DQ))]


test_what_bends_with_the_direction_is_refused = refused(
    ("equation", "", lambda value=A * nonlinear: with_direction(value, DQ))
    for nonlinear in NONLINEAR
)


def test_friction_in_pieces_of_the_position_has_its_columns_and_its_force() -> None:
    declared = rotor(Piecewise((b1 * DQ, Q < 0), (b2 * DQ, True)), parameters=(b1, b2))
    model = derive(declared)
    assert not model.base.changed
    made = build(declared, native=False)
    assert not made.has_direction
    rows, known = made.evaluate("idm_regressor", [-1.0, 1.0], 0.5, 2.0, 1.0)
    assert rows.tolist() == [[2, 0.5, 0], [2, 0, 0.5]]
    assert not known.any()


def test_pieces_that_hide_a_parameter_are_told() -> None:
    """Viscous friction beside one of its own in each direction, or on each side."""
    for where in (DQ < 0, Q < 0):
        pieces = Piecewise((b1 * DQ, where), (b2 * DQ, True))
        model = derive(rotor(pieces, b3 * DQ, parameters=(b1, b2, b3)))
        assert [str(e) for e in model.base.expressions] == ["J", "b1 + b3", "b2 + b3"]
    same = Piecewise((b3 * DQ, Q >= 0), (0, True))
    model = derive(
        rotor(Piecewise((b1 * DQ, Q < 0), (b2 * DQ, True)), same, parameters=(b1, b2, b3))
    )
    assert [str(e) for e in model.base.expressions] == ["J", "b1", "b2 + b3"]


def test_pieces_and_the_modulus_are_one_function() -> None:
    pieces = Piecewise((b1 * DQ, DQ > 0), (-b1 * DQ, True))
    model = derive(rotor(pieces, b2 * Abs(DQ), parameters=(b1, b2)))
    assert [str(e) for e in model.base.expressions] == ["J", "b1 + b2"]


def test_a_place_that_is_a_parameter_enters_nonlinearly() -> None:
    place = Parameter("v", "rad/s", nominal=0.1)
    hinge = Piecewise((b1 * (DQ - place), place.symbol < DQ), (0, True))
    assert derive(rotor(hinge, parameters=(b1, place))).idm.nonlinear == (place.symbol,)
