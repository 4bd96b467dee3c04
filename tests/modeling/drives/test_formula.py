"""A drive of two formulas: the second undoes the first, in the units of axis and control."""

import pytest
import sympy

from axisid import Constant, build
from axisid.elements import CONTROL, DRIVE_GAIN, FORCE, VELOCITY, formula_drive
from tests.axes.bodies import body, x
from tests.refusals import refuses

BRAKED = DRIVE_GAIN * CONTROL - 40 * VELOCITY


def test_the_inverse_of_a_straight_line_follows() -> None:
    drive = formula_drive(BRAKED, gain=12.0)
    assert sympy.simplify(drive.inverse - (FORCE + 40 * VELOCITY) / DRIVE_GAIN) == 0
    assert drive.constants == {DRIVE_GAIN: 12.0}


def test_an_inverse_that_undoes_another_force_is_refused_by_its_numbers() -> None:
    own = 3 * CONTROL * sympy.Abs(CONTROL)
    root = sympy.sign(FORCE) * sympy.sqrt(sympy.Abs(FORCE) / 3)
    build(body(drive=formula_drive(own, root, limit=3.0)), native=False)
    with refuses("inverse-differs", says="FormulaDrive"):
        build(body(drive=formula_drive(own, 1.01 * root, limit=3.0)), native=False)


def test_the_motion_is_the_axiss_own_or_that_of_any() -> None:
    for velocity in (VELOCITY, x.velocity):
        axis = body(coordinate=x, drive=formula_drive(3 * CONTROL - 2 * velocity))
        assert axis.drives_by_motion
        assert "2*dx" in axis.drive.force_text(x).replace("dot x", "dx")


def test_what_no_inverse_follows_from_is_refused() -> None:
    with refuses("no-inverse"):
        formula_drive(CONTROL**3)
    with refuses("formula-gain"):
        formula_drive(2 * CONTROL, relative_sd=0.01)


def test_symbols_and_units_of_the_formulas_are_checked() -> None:
    with refuses("drive-symbols", says="heat"):
        body(drive=formula_drive(sympy.Symbol("heat") * CONTROL))
    with refuses("drive-formula-units"):
        body(drive=formula_drive(Constant(3.0, "N m/V").symbol * CONTROL))
    assert body(drive=formula_drive(Constant(3.0, "N/V").symbol * CONTROL)).drive.force == (
        3.0 * CONTROL
    )


@pytest.mark.parametrize("control", [-0.3, 0.7])
def test_a_formula_is_generated(control: float) -> None:
    axis = build(body(drive=formula_drive(BRAKED, gain=12.0)), native=False)
    (force,) = axis.evaluate("drive_force", control, 0.2, 0.5)
    assert force[0, 0] == pytest.approx(12 * control - 20, rel=1e-14)
