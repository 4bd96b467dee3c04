"""Units in the labels of columns: factors against closed forms, and what is cut from a name."""

import math

import pytest

from axisid.estimation.raw_tables.unit_labels import exact_unit, split_label, split_labels
from axisid.modeling.quantities.units import parse_unit


@pytest.mark.parametrize(
    ("text", "factor", "coherent"),
    [
        ("mm", 1e-3, "m"),
        ("um", 1e-6, "m"),
        ("nm", 1e-9, "m"),
        ("Nm", 1.0, "N m"),
        ("\u00b5m", 1e-6, "m"),
        ("Millimeter", 1e-3, "m"),
        ("inch", 0.0254, "m"),
        ("deg", math.pi / 180, "rad"),
        ("\u00b0", math.pi / 180, "rad"),
        ("rev", 2 * math.pi, "rad"),
        ("arcsec", math.pi / 648000, "rad"),
        ("rpm", math.pi / 30, "rad/s"),
        ("ms", 1e-3, "s"),
        ("us", 1e-6, "s"),
        ("mA", 1e-3, "A"),
        ("mV", 1e-3, "V"),
        ("kN", 1e3, "N"),
        ("Ncm", 1e-2, "N m"),
        ("N\u00b7m", 1.0, "N m"),
        ("N*m", 1.0, "N m"),
        ("mN m", 1e-3, "N m"),
        ("m/s", 1.0, "m/s"),
    ],
)
def test_factors(text: str, factor: float, coherent: str) -> None:
    found = exact_unit(text)
    assert float(found) == pytest.approx(factor, rel=1e-15)
    assert found.unit.same_dimension(parse_unit(coherent))


def test_names_that_differ_by_their_units_only_stay_as_written() -> None:
    labels = ["t [s]", "angle [deg]", "angle [rad]"]
    assert split_labels(labels) == [("t", "s"), ("angle [deg]", "deg"), ("angle [rad]", "rad")]


@pytest.mark.parametrize("text", ["counts", "Hz", "NM", "MM", "", "deg/", "m m m m m m m" * 20])
def test_unknown_units_are_not_guessed(text: str) -> None:
    assert exact_unit(text) is None


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("position [mm]", "position", "mm"),
        ("vel (rad/s)", "vel", "rad/s"),
        ("t / s", "t", "s"),
        ("q[1]", "q[1]", ""),
        ("axis/s", "axis/s", ""),
        ("torque (actual)", "torque (actual)", ""),
        ("position [inc]", "position", "inc"),
        ("position[%In]", "position", "%In"),
        ("position (Counts)", "position", "Counts"),
        ("slip [-]", "slip", ""),
        ("[mm]", "[mm]", ""),
    ],
)
def test_units_known_or_in_square_brackets_are_cut_from_a_name(
    label: str, name: str, unit: str
) -> None:
    assert split_label(label) == (name, unit)
