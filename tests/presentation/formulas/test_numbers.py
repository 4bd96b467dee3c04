"""Numbers, signs and units as they are printed."""

import pytest

from axisid.presentation.formulas.numbers import (
    figure_text,
    readable_text,
    significant,
)


@pytest.mark.parametrize(
    ("plain", "printed"),
    [
        ("Ljung-Box 1.777e+04, less than 47.4", "Ljung-Box 17\u202f770, less than 47.4"),
        ("J by +1.2e-06 kg m^2", "J by +1.2 \u00d7 10⁻⁶ kg m²"),
        ("by -1.9e-05 N m/(rad/s)", "by \u22121.9 \u00d7 10⁻⁵ N m/(rad/s)"),
        ("(-0.25), 6.4e-03 m/s^2", "(\u22120.25), 0.0064 m/s²"),
        ("0.46 +- 0.04 or +-0.1", "0.46 ± 0.04 or ±0.1"),
        ("4.27e+07 %", "4.27 \u00d7 10⁷ %"),
    ],
)
def test_numbers_in_sentences_are_printed_as_in_tables(plain: str, printed: str) -> None:
    assert readable_text(plain) == printed


@pytest.mark.parametrize(
    "text", ["log-2.csv", "run_1e5", "--fix m=1.2+-0.01", "n/(n - k)", "IDM-IV", "1.2e3x", "2-3"]
)
def test_names_options_and_formulas_stay_as_they_are(text: str) -> None:
    assert readable_text(text) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.001414, "0.0014"),
        (0.2433, "0.24"),
        (3.0, "3.0"),
        (0.0999, "0.10"),
        (17.4, "17"),
        (1234.0, "1200"),
        (3.14e-9, "3.1 \u00d7 10⁻⁹"),
        (-0.5, "\u22120.50"),
        (0.0, "0"),
    ],
)
def test_two_digits_are_two_digits(value: float, text: str) -> None:
    assert significant(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(101.4, "101"), (99.96, "100"), (1034.0, "1034"), (2.34e7, "2.34e+07")]
)
def test_figures_of_a_column_agree_in_form(value: float, text: str) -> None:
    assert figure_text(value) == text
