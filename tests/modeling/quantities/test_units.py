"""Units are exponents of kg, m, s, A, K; the whitelist has no traps."""

from fractions import Fraction

import pytest
from hypothesis import given, strategies as st

from axisid.modeling.quantities.units import _SYMBOLS, parse_unit
from axisid.support.errors import ModelError
from tests.refusals import refused


@pytest.mark.parametrize(
    ("text", "exponents"),
    [
        ("kg", (1, 0, 0, 0, 0)),
        ("N/(m/s)", (1, 0, -1, 0, 0)),
        ("N m", (1, 2, -2, 0, 0)),
        ("Nm", (1, 2, -2, 0, 0)),
        ("N*m/rad", (1, 2, -2, 0, 0)),
        ("m/s^2", (0, 1, -2, 0, 0)),
        ("m/s**2", (0, 1, -2, 0, 0)),
        ("V/(m/s)", (1, 1, -2, -1, 0)),
        ("Pa", (1, -1, -2, 0, 0)),
        ("N/K", (1, 1, -2, 0, -1)),
        ("1/s", (0, 0, -1, 0, 0)),
        ("s^-1", (0, 0, -1, 0, 0)),
        ("N/m/s", (1, 0, -3, 0, 0)),
        ("J", (1, 2, -2, 0, 0)),
        ("m^(1/2)", (0, Fraction(1, 2), 0, 0, 0)),
        ("N/(m/s)^(3/2)", (1, Fraction(-1, 2), Fraction(-1, 2), 0, 0)),
    ],
)
def test_units_are_read(text: str, exponents: tuple[int, ...]) -> None:
    assert parse_unit(text).exponents == exponents


OTHERS = ("Hz", "mm", "N/", "(N", "N)", "N^", "N^x", "", "/s", "m^1.5", "m^(1/0)", "µm", "2 m")


test_other_texts_are_refused = refused(
    ("units", says, lambda text=text: parse_unit(text))
    for text, says in [
        *((text, "unit") for text in OTHERS),
        # Symbols that are written as one are proposed apart.
        ("Ns/m", "Did you mean 'N s/m'"),
        ("Nms/rad", "Did you mean 'Nm s/rad'"),
        # A prefix is no metre.
        *((text, "^(?!.*Did you mean)") for text in ("ms", "mA", "mN/m")),
    ]
)


SYMBOLS = st.sampled_from(sorted(_SYMBOLS))


@pytest.mark.slow
@given(SYMBOLS, SYMBOLS)
def test_products_and_quotients_are_consistent_with_text(left: str, right: str) -> None:
    a, b = parse_unit(left), parse_unit(right)
    assert (a * b).exponents == parse_unit(f"{left} {right}").exponents
    assert (a / b).exponents == parse_unit(f"{left}/({right})").exponents
    assert parse_unit(str(a / b)).same_dimension(a / b)


@pytest.mark.slow
@given(st.text(max_size=12))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        parse_unit(text)
    except ModelError as error:
        assert str(error)
