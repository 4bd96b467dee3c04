"""A drive whose control does not make the force that it is said to make is refused."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import pytest
import sympy

from axisid import build, load_axis
from axisid.elements import Drive
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.quantities.symbols import CONTROL, FORCE
from tests.refusals import refused, refuses

CUBE = sympy.Symbol("cube", real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class CubedDrive(Drive):
    """A force that grows with the cube of the control."""

    factor: float = 1.0
    cube: object = 2.0

    @property
    def force(self) -> sympy.Expr:
        return CUBE * CONTROL**3

    @property
    def inverse(self) -> sympy.Expr:
        size = sympy.Abs(FORCE / CUBE) ** sympy.Rational(1, 3)
        return self.factor * sympy.sign(FORCE) * size

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        return {CUBE: self.cube}  # type: ignore[dict-item]


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnSymbol(Drive):
    """A gain by another symbol than that of `Drive`."""

    @property
    def force(self) -> sympy.Expr:
        return CUBE * CONTROL

    @property
    def inverse(self) -> sympy.Expr:
        return FORCE / CUBE

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        return {CUBE: self.gain}


def driven(drive: Drive) -> Axis:
    return replace(load_axis("emps2015"), drive=drive)


def test_an_inverse_that_undoes_the_force_is_taken() -> None:
    axis = build(driven(CubedDrive(gain=1.0, limit=10.0)), native=False)
    (control,) = axis.evaluate("drive_control", 16.0, 0.0, 0.0)
    assert control[0, 0] == pytest.approx(2.0, rel=1e-12)


test_another_inverse_is_refused_with_a_control = refused(
    (
        "generated-code",
        "CubedDrive",
        lambda k=k, limit=limit: build(
            driven(CubedDrive(gain=1.0, limit=limit, factor=k)), native=False
        ),
    )
    for limit in [10.0, math.inf, 1e-6]
    for k in [1.001, -1.0, 0.0]
)


@pytest.mark.parametrize("gain", [1e-320, 1e-150, 35.15, -1e150, 1e308])
@pytest.mark.parametrize("limit", [1e-9, 1e9, math.inf])
def test_a_plain_drive_of_any_size_is_right(gain: float, limit: float) -> None:
    axis = build(driven(Drive(gain=gain, limit=limit)), native=False)
    assert axis.evaluate("drive_force", 1.0, 0.0, 0.0)[0][0, 0] == gain


def test_a_deviation_of_a_gain_that_is_not_in_the_force_is_refused() -> None:
    drive = OwnSymbol(gain=35.15, limit=10.0, relative_sd=0.01)
    with refuses("generated-code", says="OwnSymbol"):
        build(driven(drive), native=False)
    build(driven(replace(drive, relative_sd=0.0)), native=False)
