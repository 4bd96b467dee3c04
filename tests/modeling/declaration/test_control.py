"""A control law is taken apart into products of its gains without being multiplied out."""

import pytest
import sympy

from axisid.control import ControlLaw, cascade_pd, cascade_pd_averaged
from axisid.modeling.declaration.control import gain
from axisid.modeling.quantities.symbols import (
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
)

KP, KV, KI = (gain(name) for name in ("kp", "kv", "ki"))
ERROR = REFERENCE - MEASURED_POSITION


def law(output: sympy.Expr) -> ControlLaw:
    return ControlLaw(name="l", period=1e-3, output=output, gains={"kp": 2.0, "kv": 3.0, "ki": 5.0})


def test_the_papers_law_has_two_products() -> None:
    made = cascade_pd(kp=1.0, kv=2.0, period=1e-3)
    assert dict(made.terms) == {KP * KV: ERROR, KV: -MEASURED_VELOCITY}
    terms = dict(cascade_pd_averaged(kp=1.0, kv=2.0, period=1e-3).terms)
    q2 = sympy.Symbol("q2", real=True)
    assert terms.keys() == {KP * KV, KV}
    assert terms[KV] == -((MEASURED_POSITION - q2) / (2 * PERIOD))


@pytest.mark.parametrize(
    ("output", "wanted"),
    [
        (KP * (ERROR - 2) ** 9, {KP: (ERROR - 2) ** 9}),
        (
            KP * (ERROR**3 + KV * (ERROR - 1) ** 5) + KI**2 * ERROR,
            {KP: ERROR**3, KP * KV: (ERROR - 1) ** 5, KI**2: ERROR},
        ),
        ((KP + KV) ** 2 * ERROR, {KP**2: ERROR, KP * KV: 2 * ERROR, KV**2: ERROR}),
        (KP * ERROR + (ERROR - 3) ** 7, {KP: ERROR, sympy.S.One: (ERROR - 3) ** 7}),
    ],
)
def test_signals_stay_as_they_were_written(
    output: sympy.Expr, wanted: dict[sympy.Expr, sympy.Expr]
) -> None:
    assert dict(law(output).terms) == wanted


def test_a_law_that_is_no_polynomial_in_its_gains_is_one_term() -> None:
    output = sympy.tanh(KP * ERROR) + KV * ERROR
    assert law(output).terms == ((sympy.S.One, output),)
