"""Numbers and bounds in sentences have the digits that a reader needs."""

import pytest

from axisid.support.wording import plain_numbers, range_text


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


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a force of 1e+02 N", "a force of 100 N"),
        ("by +3.1e+03 deviations.", "by +3100 deviations."),
        ("M by -1.234e+04 kg (2e+01 %), 9e+04", "M by -12340 kg (20 %), 90000"),
        ("Fc = 1e+05 N", "Fc = 100000 N"),
        ("1.2345e+02 m", "123.45 m"),
        ("Fc = 1.1e+05 N, 3e+06 N, 2e-06 m, 0.001 s", None),
        ("'1e+02.csv' and a/1e+02.csv, x1e+02, 1e+02**2, 1e+02.5", None),
    ],
)
def test_numbers_of_sentences_up_to_a_hundred_thousand_are_written_out(
    text: str, plain: str | None
) -> None:
    assert plain_numbers(text) == (text if plain is None else plain)
