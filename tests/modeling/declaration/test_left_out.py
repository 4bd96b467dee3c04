"""Parameters that are left out: which value stands for each, and what is refused."""

import pytest
import sympy

from axisid import (
    Axis,
    Coordinate,
    Parameter,
    fix,
    leave_out,
    load_axis,
    newton,
)
from axisid.elements import Drive, coulomb, stribeck, viscous
from axisid.modeling.declaration.variants import left_out_text
from tests.refusals import refused, refuses

x = Coordinate("x")
m = Parameter("m", "kg", nominal=5.0)
b = Parameter("b", "N/(m/s)", lower=1.0, nominal=2.0)
c = Parameter("c", "N")
s = Parameter("s", "N", nominal=3.0)
v = Parameter("v", "m/s", nominal=0.02, lower=1e-4)


def stage(speed: Parameter | float = 0.02) -> Axis:
    further = (speed,) if isinstance(speed, Parameter) else ()
    return newton(
        "stage",
        coordinate=x,
        parameters=(m, b, c, s, *further),
        inertia=m,
        resistance=(viscous(b, x), coulomb(c, x), stribeck(s, x, velocity=speed)),
        drive=Drive(gain=1.0, unit="N"),
    )


def names(axis: Axis) -> list[str]:
    return [p.name for p in axis.parameters]


@pytest.mark.slow
def test_a_linear_term_is_gone_and_told() -> None:
    plain = leave_out(stage(), "s")
    assert names(plain) == ["m", "b", "c"]
    assert not plain.force.has(sympy.exp)
    assert left_out_text(plain) == "s = 0 N"
    assert left_out_text(stage()) == ""


def test_what_is_known_stands_for_it_even_beyond_its_bounds() -> None:
    held = leave_out(fix(stage(), s=(12.0, 0.5)), "s")
    assert sympy.expand(held.force - stage().force.subs(s.symbol, 12.0)) == 0
    assert left_out_text(held) == "s = 12 N"
    assert leave_out(stage(), "b").left_out[0].known == 0.0  # below its lower bound
    assert leave_out(stage(), b=7.0).left_out[0].known == 7.0


def test_a_nonlinear_one_is_held_at_its_nominal_value() -> None:
    held = leave_out(stage(v), "v")
    assert names(held) == ["m", "b", "c", "s"]
    assert left_out_text(held) == "v = 0.02 m/s"
    with refuses("parameters", says=r"has no nominal value"):
        leave_out(stage(Parameter("v", "m/s")), "v")


def test_what_no_longer_appears_goes_too() -> None:
    plain = leave_out(stage(v), "s")
    assert names(plain) == ["m", "b", "c"]
    assert left_out_text(plain) == "s = 0 N, v = 0.02 m/s"


def test_the_twin_keeps_what_is_left_of_its_truth() -> None:
    axis = load_axis("emps")
    plain = leave_out(axis, "tau0")
    assert set(plain.experiment.truth) == set(axis.experiment.truth) - {"tau0"}


test_what_cannot_be_left_out_is_refused = refused(
    (code, says, lambda names=names, values=values: leave_out(stage(), *names, **values))
    for code, says, names, values in [
        ("parameters", "'z' to leave out", ("z",), {}),
        ("parameters", "m, b, c, s", ("m", "b", "c", "s"), {}),
        ("axis", "", ("m",), {}),
        ("axis", "replaces 's' is 'much'", (), {"s": "much"}),
    ]
)
