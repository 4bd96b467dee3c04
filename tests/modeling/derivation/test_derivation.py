"""From declaration to regressors and maps."""

from collections.abc import Callable

import pytest
import sympy

from axisid import (
    Constant,
    Coordinate,
    Parameter,
    derive,
    load_axis,
)
from axisid.elements import coulomb, spring, viscous
from axisid.modeling.derivation.description import describe_loss
from axisid.modeling.derivation.model import AxisModel
from axisid.modeling.quantities.symbols import DIRECTION, FORCE
from axisid.support.missing import Missing
from tests.axes.bodies import Fc, Fv, J, M, body, energetic, k, q
from tests.axes.simulated import AXES
from tests.bounded import within
from tests.refusals import refused, refuses

mu = Parameter("mu", "1")
vs = Parameter("vs", "m/s")
angle = Coordinate("phi", unit="rad")
J1 = Parameter("J1", "kg m^2")
RATIO = Parameter("ratio", "1")
PLACE = q.symbol / Constant(1.0, "m").symbol
SPEED = q.velocity / Constant(1.0, "m/s").symbol


def test_paper_equations_2_and_4() -> None:
    model = derive(load_axis("emps2015"))
    assert model.idm.columns == (q.acceleration, q.velocity, DIRECTION)
    assert model.ddm.columns == (FORCE, -q.velocity, -DIRECTION)
    mapping = model.parameter_map
    assert list(mapping.forward) == [1 / M.symbol, Fv / M.symbol, Fc / M.symbol]
    assert [str(unit) for unit in mapping.units] == ["1/kg", "1/s", "m/s^2"]


def substituted(model: AxisModel) -> sympy.Expr:
    """Acceleration by the direct regressor, in physical parameters."""
    row = model.ddm
    terms = zip(row.columns, model.parameter_map.forward, strict=True)
    return sum((c * t for c, t in terms), row.intercept)


CASES = {
    "gravity on the mass alone": body(9.81 * M, viscous(Fv, q), parameters=(M, Fv)),
    "two inertias, one with gravity": body(
        9.81 * M, coulomb(Fc, q), inertia=M + 4 * J, parameters=(M, J, Fc)
    ),
    "two inertias, both with gravity": body(9.81 * M + 3 * J, inertia=M + 4 * J, parameters=(M, J)),
    "known mass beside the unknown one": body(
        9.81 * M, viscous(Fv, q), inertia=M + 3, parameters=(M, Fv)
    ),
    "known inertia": body(9.81 * Fv, coulomb(Fc, q), inertia=sympy.Integer(3), parameters=(Fv, Fc)),
    "known force and spring": body(sympy.Integer(50), spring(k, q, rest=0.5), parameters=(M, k)),
    "pendulum": AXES["open_pendulum"],
}


@pytest.mark.parametrize("name", CASES)
def test_regressors_reproduce_both_dynamics_and_the_map_goes_there_and_back(name: str) -> None:
    model = derive(CASES[name])
    parameters = [p.symbol for p in model.axis.parameters]
    force = (
        sum(c * p for c, p in zip(model.idm.columns, parameters, strict=True)) + model.idm.intercept
    )
    assert sympy.expand(force - model.force) == 0
    assert sympy.simplify(substituted(model) - model.acceleration) == 0
    mapping = model.parameter_map
    back = mapping.inverse.subs(dict(zip(mapping.symbols, mapping.forward, strict=True)))
    assert sympy.simplify(back - sympy.Matrix(mapping.parameters)).is_zero_matrix
    product = (
        mapping.inverse_jacobian.subs(dict(zip(mapping.symbols, mapping.forward, strict=True)))
        * mapping.forward_jacobian
    )
    assert sympy.simplify(product) == sympy.eye(len(mapping.parameters))


def test_ball_screw_pitch_does_not_hide_that_inertias_add_up() -> None:
    screw = (2 * sympy.pi / 0.01) ** 2
    model = derive(body(viscous(Fv, q), inertia=M + screw * J, parameters=(M, J, Fv)))
    (lost,) = map(describe_loss, model.base.unidentifiable)
    assert lost.endswith("; only M + 3.948e+05 J can be identified")
    assert [p.name for p in model.axis.parameters] == ["M_plus_J", "Fv"]


test_what_cancels_out_or_is_not_linear_in_the_acceleration_is_refused = refused(
    ("equation", says, lambda force=force, own=own: derive(body(force, parameters=own)))
    for force, own, says in [
        (
            Fc * ((PLACE + 1) ** 2 - PLACE**2 - 2 * PLACE - 1),
            (M, Fc),
            "Fc has no effect",
        ),
        (
            M * ((PLACE - 1) * (PLACE + 1) - PLACE**2) * q.acceleration,
            (M,),
            "Add an inertia",
        ),
        (
            M * q.acceleration**2 / Constant(1.0, "m/s^2"),
            (M,),
            "not linear in the acceleration",
        ),
    ]
)


def test_configuration_dependent_inertia_has_no_direct_regressor_and_says_why() -> None:
    inertia = J + J1 * sympy.sin(angle.symbol) ** 2
    crank = energetic(coordinate=angle, inertia=inertia, parameters=(J1, J))
    model = derive(crank)
    assert isinstance(model.ddm, Missing)
    assert "depends on phi" in model.ddm.reason
    assert len(model.idm.columns) == 2


@pytest.mark.parametrize(
    ("resistance", "parameters", "nonlinear"),
    [
        (Fc * sympy.tanh(q.velocity / vs), (M, Fc, vs), vs),
        (Fc * sympy.Abs(q.velocity / vs) ** mu.symbol, (M, Fc, vs, mu), (vs, mu)),
    ],
)
def test_nonlinear_parameters_are_told_from_linear_ones(
    resistance: sympy.Expr,
    parameters: tuple[Parameter, ...],
    nonlinear: Parameter | tuple[Parameter, ...],
) -> None:
    model = derive(body(resistance, parameters=parameters))
    names = nonlinear if isinstance(nonlinear, tuple) else (nonlinear,)
    assert model.idm.nonlinear == tuple(p.symbol for p in names)
    assert isinstance(model.ddm, Missing)
    assert all(str(p.symbol) in model.ddm.reason for p in names)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("resistance", "code", "says"),
    [
        (
            lambda: Fc * (SPEED + sum(RATIO.symbol**i for i in range(1, 5))) ** 90,
            "equation",
            "too many products of parameters",
        ),
        (
            lambda: sympy.Add(*(sympy.sin(i * q.symbol) * Fv.symbol for i in range(1, 1500))),
            "formula",
            "4000",
        ),
        (
            lambda: sympy.Mul(*(sympy.sin(i * PLACE) + RATIO for i in range(1, 30)), Fc.symbol),
            "equation",
            "multiplied out.*4000",
        ),
    ],
    ids=["power", "sum", "product"],
)
def test_what_would_take_for_ever_is_refused_at_once(
    resistance: Callable[[], sympy.Expr], code: str, says: str
) -> None:
    force = resistance()
    with within(12_000_000), refuses(code, says):  # it would take hours
        derive(body(force, parameters=(M, Fv, Fc, k, RATIO)))


def test_hidden_linearity_is_found() -> None:
    unit = Constant(1.0, "kg")
    square = ((M + unit) ** 2 - M**2 - unit**2) / (2 * unit)
    model = derive(body(inertia=square, parameters=(M,)))
    assert sympy.nsimplify(model.idm.columns[0]) == q.acceleration
