"""The equation of motion in its units: what is caught, what passes, what is open and listed."""

from typing import Any

import pytest
import sympy

from axisid import Constant, Coordinate, ModelError, Parameter, lagrange
from axisid.elements import (
    Drive,
    G,
    cogging,
    coulomb,
    gravity,
    load_dependent,
    motor_inertia,
    offset,
    spring,
    stribeck,
    viscous,
)
from axisid.modeling.declaration.axis import Axis
from tests.axes.bodies import J, M, body, energetic, q
from tests.refusals import refused, refuses

theta = Coordinate("theta", unit="rad")


def p(unit: str, name: str = "p") -> Parameter:
    return Parameter(name, unit)


def rotary(*resistance: sympy.Expr, **more: Any) -> Axis:
    return body(*resistance, coordinate=theta, inertia=J, **more)


HALF = sympy.Rational(1, 2)


test_wrong_unit_is_refused_with_the_term_and_both_units = refused(
    (
        "units",
        f"^axis 'test': .*{message}",
        lambda element=element, own=own: body(element, parameters=(own,)),
    )
    for element, own, message in [
        (
            viscous(p("N"), q),
            p("N"),
            r"the term dq\*p is in kg m\^2/s\^3 \(dq in m/s, p in N\), but the drive of a linear "
            r"axis gives N",
        ),
        (coulomb(p("N/(m/s)"), q), p("N/(m/s)"), r"the term p\*sign\(dq\) is in N/\(m/s\)"),
        (offset(p("N m")), p("N m"), r"the term p is in N m .* gives N\."),
        (p("N") * sympy.sin(q.symbol), p("N"), r"sin\(q\) takes a number, not m"),
        (
            p("N/m") * (q.symbol + q.velocity),
            p("N/m"),
            r"the term p\*\(dq \+ q\) do not fit: dq \+ q adds m.* and m.*. Give both the same",
        ),
        (
            spring(p("N/m"), q, rest=Constant(0.1, "s", "rest")),
            p("N/m"),
            "adds .*. Give both the same unit",
        ),
        (gravity(p("N")), p("N"), r"the term G\*p is in .* \(G in m/s\^2, p in N\)"),
        (
            p("N") * sympy.exp(-q.velocity / Constant(0.1, "m")),
            p("N"),
            r"exp\(-dq/0\.1\) takes a number, not 1/s",
        ),
        (p("N") * sympy.sqrt(sympy.Abs(q.velocity)), p("N"), r"m\^\(3/2\)"),
        (p("N") * sympy.Max(q.symbol, q.velocity), p("N"), "compares m.* and m"),
        (
            p("N") * sympy.Piecewise((1, q.symbol > q.velocity), (0, True)),
            p("N"),
            "compares m.* and m",
        ),
        (p("N") * q.symbol ** (q.velocity), p("N"), "the power in .* is in m/s"),
        (p("N") * sympy.atan2(q.symbol, q.velocity), p("N"), "compares m.* and m"),
        (p("N m/rad") * q, p("N m/rad"), "the term p\\*q is in kg m"),
        (2 * p("kg") * q, p("kg"), r"the term 2\*p\*q is in kg m"),
        # A factor that energies bring excuses no term.
        *(
            (
                factor * p("N/(m/s)") * q.symbol,
                p("N/(m/s)"),
                r"p\*q.* is in .* \(p in N/\(m/s\), q in m\)",
            )
            for factor in (1, 1.0, -1.0, 2, 2.0, -2.0, HALF, 0.5, -0.5)
        ),
    ]
)


test_what_does_not_fit_its_place_is_refused = refused(
    ("units", says, declared)
    for declared, says in [
        (
            lambda: body(
                stribeck(p("N"), q, velocity=p("m", "vs")), parameters=(p("N"), p("m", "vs"))
            ),
            r"takes a number, not 1/s\^2",
        ),
        (lambda: body(sympy.sign(q.velocity)), r"is in 1 .* gives N\."),
        (lambda: body(-sympy.sign(q.velocity)), r"is in 1 .* gives N\."),
        (lambda: body(2 * Constant(0.25, "m", "arm").symbol), "arm in m"),
        (lambda: body(0.5 * Constant(0.25, "m", "arm").symbol), "arm in m"),
        *(
            (
                lambda unit=unit: rotary(coulomb(p(unit), theta), parameters=(p(unit),)),
                "the drive of a rotary axis gives N m",
            )
            for unit in ("N", "N/(rad/s)", "kg")
        ),
        (
            lambda: body(coordinate=theta, inertia=M),
            r"the term M\*ddtheta is in .* gives N m",
        ),
        (
            lambda: body(inertia=M + J.symbol, parameters=(M, J)),
            r"J \+ M adds.*the same unit",
        ),
        (
            lambda: energetic(
                coordinate=theta, parameters=(p("N"),), potential=-p("N") * sympy.cos(theta.symbol)
            ),
            r"sin\(theta\)",
        ),
    ]
)


@pytest.mark.parametrize("half", [HALF, 0.5, sympy.Float(0.5, 30)], ids=str)
def test_energy_of_a_wrong_unit_is_refused_however_its_half_is_written(half: Any) -> None:
    def by_energy(parameter: Parameter) -> Axis:
        return lagrange(
            "test",
            coordinate=theta,
            parameters=(parameter,),
            kinetic=half * parameter.symbol * theta.velocity**2,
            drive=Drive(gain=1.0),
        )

    assert by_energy(J).unchecked_terms == ()
    with refuses("units", says=r"the term .*M\*ddtheta is in .*, but the drive"):
        by_energy(M)


@pytest.mark.parametrize("amount", [0.5, 2, -2, 3, 1.0])
def test_a_known_load_of_the_motion_may_have_any_plain_factor(amount: Any) -> None:
    for motion in (sympy.sign(q.velocity), q.symbol, q.velocity * sympy.Abs(q.velocity)):
        assert len(body(amount * motion).unchecked_terms) == 1
    assert len(rotary(amount * sympy.cos(theta.symbol)).unchecked_terms) == 1


@pytest.mark.parametrize(
    ("axis", "open_terms"),
    [
        (lambda: rotary(p("N m") * sympy.sin(theta.symbol), parameters=(p("N m"),)), ()),
        (lambda: rotary(p("N m s") * theta.velocity, parameters=(p("N m s"),)), ()),
        (lambda: rotary(p("J/rad") * sympy.sin(3 * theta.symbol), parameters=(p("J/rad"),)), ()),
        (lambda: body(0.5 * p("N/(m/s)") * q.velocity, parameters=(p("N/(m/s)"),)), ()),
        (lambda: body(cogging(p("N"), 0, q, period=0.016), parameters=(p("N"),)), ()),
        (lambda: body(G * M), ()),
        (lambda: body(coulomb(3.0, q), spring(10, q, 0.1), viscous(2, q)), ()),
        (
            lambda: body(load_dependent(p("1"), 50.0, q), parameters=(p("1"),)),
            (),
        ),
        (
            lambda: body(9.81 * M),
            (r"9.81*M (correct if its plain numbers have the unit m/s^2)",),
        ),
        (
            lambda: body(sympy.Integer(50)),
            (r"50 (correct if its plain numbers have the unit kg m/s^2)",),
        ),
        (
            lambda: body(p("N/m") * (q.symbol - 0.25), parameters=(p("N/m"),)),
            (r"p*(q - 0.25) (correct if its plain numbers have the unit m)",),
        ),
        (
            lambda: body(p("N") * sympy.sin(200 * q.symbol), parameters=(p("N"),)),
            (r"p*sin(200*q) (correct if its plain numbers have the unit 1/m)",),
        ),
        (
            lambda: body(p("N") * sympy.tanh(q.velocity / 1e-3), parameters=(p("N"),)),
            (r"p*tanh(1000.0*dq) (correct if its plain numbers have the unit s/m)",),
        ),
        (
            lambda: body(p("N") * sympy.sqrt(sympy.Abs(q.velocity) / 0.1), parameters=(p("N"),)),
            None,
        ),
        (lambda: body(inertia=M + motor_inertia(J, q, ratio=400.0), parameters=(M, J)), ()),
        (
            lambda: body(
                p("N/(m/s)^(3/2)")
                * sympy.Abs(q.velocity) ** sympy.Rational(3, 2)
                * sympy.sign(q.velocity),
                parameters=(p("N/(m/s)^(3/2)"),),
            ),
            (),
        ),
        (
            lambda: body(p("N/m") * sympy.Max(0, q.symbol - 0.2), parameters=(p("N/m"),)),
            (r"p*Max(0, q - 0.2) (correct if its plain numbers have the unit m)",),
        ),
    ],
)
def test_right_declarations_pass_and_what_a_plain_number_leaves_open_is_listed(
    axis: Any, open_terms: tuple[str, ...] | None
) -> None:
    declared = axis()
    if open_terms is None:
        assert len(declared.unchecked_terms) == 1
    else:
        assert declared.unchecked_terms == open_terms


def test_constant_closes_what_a_number_leaves_open_and_is_held_to_its_unit() -> None:
    arm, weight = Constant(0.25, "m", "arm"), p("N")
    assert (
        rotary(arm * weight * sympy.cos(theta.symbol), parameters=(weight,)).unchecked_terms == ()
    )
    with refuses("units", says=r"arm in m, p in N m"):
        rotary(arm * p("N m") * sympy.cos(theta.symbol), parameters=(p("N m"),))


def test_profile_of_a_drive_is_a_number() -> None:
    pitch = Constant(0.032, "m", "pitch")
    fine = Drive(gain=1.0, profile=1 + 0.03 * sympy.cos(2 * sympy.pi * q / pitch))
    assert body(drive=fine).drive == fine
    for profile, message in (
        (1 + sympy.cos(q.symbol), "takes a number, not m"),
        (pitch.symbol, "the drive's profile pitch is in m"),
        (sympy.Symbol("z"), "unknown symbols z"),
        (sympy.S.Zero, "not finite"),
    ):
        with pytest.raises(ModelError, match=message):
            body(drive=Drive(gain=1.0, profile=profile))
