"""Base parameters: as few as the force has, the same force, and the words about what is lost."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import Axis, Parameter, derive, fix, load_axis
from axisid.elements import G, asymmetric_coulomb
from axisid.modeling import Experiment, Move
from axisid.modeling.declaration.variants import read_fixed
from axisid.modeling.derivation.base_model import base_model
from axisid.modeling.derivation.description import (
    derived_sections,
    describe_undecided,
    describe_undetermined,
)
from axisid.modeling.derivation.force_guard import check_force
from axisid.modeling.derivation.inverse import with_direction
from axisid.modeling.library import LIBRARY
from axisid.modeling.quantities import with_numbers
from tests.axes.bodies import ROD, body, energetic, rod, rotor, turn as q, x
from tests.bounded import within
from tests.refusals import refused, refuses

m, l, J = ROD  # noqa: E741
fc = Parameter("fc", "N m")

PENDULUM = rod(
    (fc,),
    name="pendulum",
    dissipation=fc * sympy.Abs(q.velocity),
    experiment=Experiment(moves=(Move(1.0, 1.0, 1.0),), truth={"m": 3.0, "fc": 0.5}),
)


@pytest.mark.parametrize("name", LIBRARY)
def test_axis_that_is_linear_and_told_apart_is_returned_itself(name: str) -> None:
    axis = load_axis(name)
    base = base_model(axis)
    assert base.axis is axis
    assert not base.changed
    assert base.expressions == tuple(p.symbol for p in axis.parameters)
    assert (base.unidentifiable, base.undetermined, base.combined) == ((), (), ())


def test_what_must_be_known_of_a_chain_of_masses_is_said_at_once() -> None:
    hub = Parameter("J", "kg*m^2")
    m1, m2, m3 = (Parameter(f"m{i}", "kg") for i in (1, 2, 3))
    l1, l2, l3 = (Parameter(f"l{i}", "m") for i in (1, 2, 3))
    arms = (l1.symbol, l1 + l2, l1 + l2 + l3)
    inertia = hub + sum(m * arm**2 for m, arm in zip((m1, m2, m3), arms, strict=True))
    axis = rotor(inertia=inertia, parameters=(hub, m1, m2, m3, l1, l2, l3), name="chain")
    with within(1_000_000):
        (words,) = describe_undetermined(base_model(axis))
    assert "if 6 of these" in words


def test_products_rounded_by_the_user_are_still_products() -> None:
    """``g k`` computed in floating point is not the product of the decimals g and k."""
    a, b = Parameter("a", "kg"), Parameter("b", "kg")
    g, k = 9.80665, 0.123456789
    lift = body(
        g * a.symbol * x.symbol,
        (g * k) * b.symbol * x.symbol,
        coordinate=x,
        inertia=a + k * b.symbol,
        parameters=(a, b),
    )
    base = base_model(lift)
    assert len(base.expressions) == 1
    assert base.at((1.0, 2.0)) == pytest.approx((1 + 2 * k,), rel=1e-12)


@pytest.mark.parametrize("centre", [9, 90, 900])
def test_a_small_weight_beside_large_ones_is_no_rounding(centre: int) -> None:
    """``(q - 900)**8`` has weights from 1 to 4e23, and none of them says anything of b and c."""
    a, b, c = (Parameter(name, "N m") for name in "abc")
    bump = a * (q.symbol - centre) ** 8
    bumpy = rotor(bump, asymmetric_coulomb(b, c, q), inertia=J, parameters=(a, b, c))
    assert not base_model(bumpy).changed
    d = Parameter("d", "N m")
    more = replace(
        bumpy, parameters=(*bumpy.parameters, d), force=bumpy.force + d * (q.symbol - centre) ** 8
    )
    assert [str(e) for e in base_model(more).expressions] == ["J", "a + d", "b", "c"]


@pytest.mark.parametrize("power", [Fraction(1), Fraction(2), Fraction(1, 2), Fraction(-1, 3)])
def test_powers_of_the_speed_are_one_function_in_all_their_words(power: Fraction) -> None:
    speed, sign, less = sympy.Abs(x.velocity), sympy.sign(x.velocity), sympy.Rational(power)
    unit = f"N/(m/s)^({(power + 1).numerator}/{power.denominator})"
    one, two = Parameter("one", unit), Parameter("two", unit)
    axis = body(
        one * speed**less * x.velocity,
        two * speed ** (less + 1) * sign,
        coordinate=x,
        inertia=m,
        parameters=(one, two),
    )
    assert base_model(axis).unidentifiable == ({one.symbol: -1, two.symbol: 1},)


def test_constants_stay_in_the_force_and_have_their_unit_checked() -> None:
    weighed = energetic(
        inertia=m * l.symbol**2,
        parameters=(m, l),
        potential=-m * G * l * sympy.cos(q.symbol),
    )
    base = base_model(weighed)
    assert [(p.name, p.unit) for p in base.axis.parameters] == [
        ("m_l", "kg m"),
        ("m_l2", "kg m^2"),
    ]
    assert G.symbol in base.axis.force.free_symbols
    assert base.axis.unchecked_terms == weighed.unchecked_terms == ()
    assert base.unidentifiable == ()


def test_declaring_as_known_changes_nothing_that_is_generated() -> None:
    from axisid.codegen.generated_axes.texts import axis_artefacts

    for axis in (PENDULUM, load_axis("emps")):
        first = axis.parameters[0].name
        value = axis.parameters[0].nominal
        assert axis_artefacts(derive(fix(axis, **{first: (value, 0.1)}))) == axis_artefacts(
            derive(axis)
        )


test_values_that_cannot_be_fixed_are_refused = refused(
    (code, "", lambda values=values: fix(PENDULUM, **values))
    for values, code in [
        ({"mass": 1.0}, "parameters"),
        ({"m": (1.0, 2.0, 3.0)}, "parameters"),
        ({"m": "two"}, "axis"),
        ({"m": -1.0}, "axis"),
        ({"m": (1.0, -0.1)}, "axis"),
        ({"m": float("nan")}, "axis"),
    ]
)


def test_fixed_values_are_read_from_text() -> None:
    assert read_fixed(["m=2", "l = .3+-1e-3", "J=1.5e-2 ± 0.1"]) == {
        "m": (2.0, 0.0),
        "l": (0.3, 1e-3),
        "J": (0.015, 0.1),
    }
    for text in ("m", "m=", "m=two", "m=1+-", "=2", "m=1+0.1"):
        with refuses("parameters"):
            read_fixed([text])
    with refuses("parameters"):
        read_fixed(["m=1", "m=2"])


WINDOW = sympy.Max(0, 1 - sympy.Abs(q.symbol - 0.37) / 1e-4)


def test_a_narrow_window_is_not_refused() -> None:
    peak = Parameter("F1", "N m")
    axis = rotor(peak * WINDOW, fc * sympy.sign(q.velocity), parameters=(peak, fc))
    assert not derive(axis).base.changed


def test_friction_with_a_knee_beside_a_constant_force_keeps_its_sign() -> None:
    a, b = (Parameter(name, "N m") for name in "ab")
    axis = rotor(a * sympy.tanh(q.velocity / 1e-4), b.symbol, parameters=(a, b))
    model = derive(axis)
    columns = [c.subs({q.velocity: -1, q.acceleration: 0}) for c in model.idm.columns]
    beta = model.base.at([1.0, 2.0, 3.0])
    assert float(np.dot(columns, beta)) == pytest.approx(1.0)


def test_a_doubt_keeps_the_parameters_and_is_told() -> None:
    a, b = (Parameter(name, "N m") for name in "ab")
    flat = sympy.tanh(sympy.exp(q.symbol) + 1000)
    model = derive(rotor(a * flat, b.symbol, parameters=(a, b)))
    assert model.base.undecided == ((a.symbol, b.symbol),)
    assert not model.base.changed
    (words,) = describe_undecided(model.base)
    assert words in derived_sections(model)[-1].lines
    (words,) = describe_undecided(derive(rotor(a * (flat - 1), fc.symbol, parameters=(a, fc))).base)
    assert words.startswith("No effect of a")


def test_a_derivation_whose_force_is_another_is_refused() -> None:
    a, b = (Parameter(name, "N m") for name in "ab")
    model = derive(rotor(a * q.symbol, b * q.symbol, parameters=(a, b)))
    declared = with_direction(with_numbers(model.base.declared.force), q.velocity)
    check_force(model.base, declared, model.force)
    with refuses("equation", "not the declared force"):
        check_force(model.base, declared, model.force + WINDOW)
    wrong = replace(model.base, expressions=(J.symbol, a + 2 * b))
    with refuses("equation", "not the declared force"):
        check_force(wrong, declared, model.force)


TURN, SPEED = q.symbol, q.velocity
CUBIC = sympy.expand((TURN + 2) * (TURN - 7) * (TURN - sympy.Rational(15, 2)))
LAGGED = sympy.Max(0, 1 - 10 * abs(TURN - 3 * SPEED - 5))
PULSE = sympy.Max(0, sympy.cos(50 * TURN - 1) - sympy.Rational(999, 1000))
DIFFERENT = {
    "two near roots": (abs(CUBIC), sympy.sign(TURN + 2) * CUBIC),
    "two near roots of a hinge": (sympy.Max(0, CUBIC), sympy.Heaviside(TURN + 2) * CUBIC),
    "a lagged window": (LAGGED, LAGGED * sympy.sign(TURN)),
    "a lagged window that is open late": (LAGGED, LAGGED * sympy.Max(0, SPEED - 2)),
    "pulses": (PULSE, PULSE * sympy.sign(TURN)),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n == "pulses" else ()) for n in DIFFERENT]
)
def test_functions_that_differ_in_a_few_places_are_kept(name: str) -> None:
    a, b = (Parameter(name, "N m") for name in "ab")
    one, other = DIFFERENT[name]
    assert not derive(rotor(a * one, b * other, parameters=(a, b))).base.changed


COLUMNS = (q.acceleration, q.velocity, q.symbol, sympy.sin(q.symbol), sympy.S.One)
MONOMIALS = [(a, b, c) for a in range(3) for b in range(3) for c in range(2) if a + b + c]


@st.composite
def polynomial_axes(draw: st.DrawFn) -> tuple[Axis, list[list[int]]]:
    """Random axes whose force is polynomial in three parameters, with their weights."""
    chosen = draw(st.lists(st.sampled_from(MONOMIALS), min_size=2, max_size=5, unique=True))
    small = st.integers(-2, 2)
    weights = [[draw(small) for _ in chosen] for _ in COLUMNS]
    weights[0][0] = 1
    symbols = [sympy.Symbol(name, real=True) for name in "abc"]
    sizes = [sympy.Mul(*(s**e for s, e in zip(symbols, each, strict=True))) for each in chosen]
    force = sum(
        (
            w * column * size
            for column, row in zip(COLUMNS, weights, strict=True)
            for w, size in zip(row, sizes, strict=True)
        ),
        sympy.S.Zero,
    )
    used = [s for s in symbols if s in force.free_symbols]
    parameters = [Parameter(str(s), "kg", nominal=1.0) for s in used]
    axis = rotor(inertia=J)
    return replace(axis, parameters=tuple(parameters), force=sympy.expand(3.0 * force)), weights


@pytest.mark.slow
@settings(max_examples=25)
@given(polynomial_axes(), st.integers(0, 1000))
def test_force_is_that_of_as_few_base_parameters_as_its_weights_have_rank(
    drawn: tuple[Axis, list[list[int]]], seed: int
) -> None:
    (axis, weights), rng = drawn, np.random.default_rng(seed)
    base = base_model(axis)
    model = derive(axis)
    kept = [j for j in range(len(weights[0])) if any(row[j] for row in weights)]
    rank = np.linalg.matrix_rank(np.array(weights)[:, kept])
    assert len(base.axis.parameters) == rank
    symbols = [p.symbol for p in axis.parameters]
    motion = (q.symbol, q.velocity, q.acceleration)
    rows = []
    for _ in range(8):
        theta = {s: rng.uniform(-2, 2) for s in symbols}
        moved = {s: rng.uniform(-2, 2) for s in motion}
        columns = [float(c.subs(moved)) for c in model.idm.columns]
        beta = base.at(list(theta.values()))
        assert beta == pytest.approx([float(e.subs(theta)) for e in base.expressions], abs=1e-9)
        known = float(model.idm.intercept.subs(moved))
        force = float(axis.force.subs(theta | moved))
        assert float(np.dot(columns, beta)) + known == pytest.approx(force, rel=1e-9, abs=1e-9)
        rows.append(columns)
    assert np.linalg.matrix_rank(np.array(rows)) == rank
