"""Numbers as text."""

import pytest

from axisid.estimation.estimates import Value
from axisid.support.number_text import range_text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (10.98, 11.04, "10.98 .. 11.04"),
        (10.99998, 11.00003, "10.99998 .. 11.00003"),
        (-2.0, 31.0, "-2 .. 31"),
        (1.20001e-7, 1.20004e-7, "1.20001e-07 .. 1.20004e-07"),
        (5.0, 5.0, "5 .. 5"),
    ],
)
def test_bounds_have_the_digits_that_tell_them_apart(low: float, high: float, text: str) -> None:
    assert range_text(low, high) == text


def test_an_interval_of_a_value_is_never_rounded_to_nothing() -> None:
    value = Value(
        value=183.2272658, unit="kg", deviations={"hac": 6e-5}, interval=(183.22715, 183.22738)
    )
    assert "95 %: 183.22715 to 183.22738 kg" in str(value)
