"""Ticks: round, enough of them, and powers of a thousand taken out."""

import pytest

from axisid.presentation.drawing.matplotlib import Thousands, log_ticks


@pytest.mark.parametrize(
    ("first", "last", "ticks"),
    [
        (1e-6, 1e3, [1e-6, 1e-4, 0.01, 1, 100]),
        (1e-5, 400.0, [1e-5, 1e-4, 1e-3, 0.01, 0.1, 1, 10, 100]),
        (15, 130, [20, 50, 100]),
        (19, 31, [20, 22.5, 25, 27.5, 30]),
        (0.8, 6.0, [1, 2, 5]),
    ],
)
def test_logarithmic_ticks_are_round_and_enough(
    first: float, last: float, ticks: list[float]
) -> None:
    assert log_ticks(first, last) == pytest.approx(ticks)


def test_a_power_of_a_thousand_is_taken_out_of_small_ticks() -> None:
    form = Thousands()
    assert form.format_ticks([-5e-6, 0.0, 5e-6]) == ["\u22125", "0", "5"]
    assert form.get_offset() == "\u00d7 10⁻⁶"
    assert form.format_ticks([0.0, 0.25, 0.5]) == ["0.00", "0.25", "0.50"]
    assert form.get_offset() == ""
