"""Every library axis declared the other way, Lagrange for Newton: the same regressors."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Constant, derive, lagrange, load_axis, newton
from axisid.elements import G, end_stop
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.derivation.inverse import Regressor
from axisid.modeling.derivation.model import AxisModel
from axisid.modeling.library import crank
from axisid.modeling.quantities.symbols import DIRECTION, FORCE
from axisid.support.errors import Missing


def other_way(name: str, **energies: Any) -> Axis:
    axis = load_axis(name)
    return lagrange(
        name,
        coordinate=axis.coordinate,
        parameters=axis.parameters,
        drive=axis.drive,
        **energies,
    )


def symbols(name: str) -> tuple[sympy.Symbol, ...]:
    """Position, velocity, then the parameters."""
    axis = load_axis(name)
    return axis.coordinate.symbol, axis.coordinate.velocity, *(p.symbol for p in axis.parameters)


def friction(dq: sympy.Symbol, fv: sympy.Symbol, fc: sympy.Symbol) -> sympy.Expr:
    return fv * dq**2 / 2 + fc * sympy.Abs(dq)


def _emps2015() -> Axis:
    _, dq, M, Fv, Fc = symbols("emps2015")
    return other_way("emps2015", kinetic=M * dq**2 / 2, dissipation=friction(dq, Fv, Fc))


def _emps() -> Axis:
    _, dq, M, Fv, Fc, tau0 = symbols("emps")
    return other_way(
        "emps",
        kinetic=M * dq**2 / 2,
        dissipation=friction(dq, Fv, Fc),
        generalised_force=-tau0,
    )


def _pendulum() -> Axis:
    q, dq, J, mx, fv, fc = symbols("pendulum")
    return other_way(
        "pendulum",
        kinetic=J * dq**2 / 2,
        potential=-mx * G * sympy.cos(q),
        dissipation=friction(dq, fv, fc),
    )


def _vertical_screw() -> Axis:
    q, dq, M, Fv, Fc, Fb, kb = symbols("vertical_screw")
    pitch, rotor = Constant(0.01, "m"), Constant(3.2e-3, "kg m^2")
    spin = 2 * sympy.pi * dq / pitch.symbol
    return other_way(
        "vertical_screw",
        kinetic=M * dq**2 / 2 + rotor * spin**2 / 2,
        potential=M * G * q - Fb * q + kb * q**2 / 2,
        dissipation=friction(dq, Fv, Fc),
    )


def _belt_axis() -> Axis:
    _, dq, m, Fvp, Fvm, Fcp, Fcm = symbols("belt_axis")
    spin = 5 * dq / Constant(0.03, "m").symbol
    forwards, backwards = (dq + sympy.Abs(dq)) / 2, (dq - sympy.Abs(dq)) / 2
    return other_way(
        "belt_axis",
        kinetic=m * dq**2 / 2 + Constant(1.8e-4, "kg m^2") * spin**2 / 2,
        dissipation=Fvp * forwards**2 / 2
        + Fvm * backwards**2 / 2
        + Fcp * forwards
        - Fcm * backwards,
    )


def _rotary_table() -> Axis:
    q, dq, J, fv, fc, ca, cb = symbols("rotary_table")
    return other_way(
        "rotary_table",
        kinetic=J * dq**2 / 2,
        potential=(ca * sympy.sin(66 * q) - cb * sympy.cos(66 * q)) / 66,
        dissipation=friction(dq, fv, fc),
    )


def _valve() -> Axis:
    q, dq, m, Fv, Fc, Fs, F0, k1, k3 = symbols("valve")
    axis = load_axis("valve")
    sticks = Fs * sympy.exp(-sympy.Abs(dq) / sympy.Float(0.05)) * sympy.sign(dq)
    stops = end_stop(axis.coordinate, lower=-0.01, upper=0.01, stiffness=2e6, dissipation=2.0)
    return other_way(
        "valve",
        kinetic=m * dq**2 / 2,
        potential=F0 * q + k1 * q**2 / 2 + k3 * q**4 / 4,
        dissipation=friction(dq, Fv, Fc),
        generalised_force=-stops - sticks,
    )


def _crank() -> Axis:
    """By d'Alembert: the slider's force of inertia and weight, times the lever ``x'``."""
    q, dq, J, m, fv, fc = symbols("crank")
    axis = load_axis("crank")
    lever = crank.x.diff(q)
    slider = lever * axis.coordinate.acceleration + lever.diff(q) * dq**2
    return newton(
        "crank",
        coordinate=axis.coordinate,
        parameters=axis.parameters,
        inertia=J,
        resistance=(m * (slider + G) * lever, fv * dq, fc * sympy.sign(dq)),
        drive=axis.drive,
    )


def _balanced_slide() -> Axis:
    q, dq, M, Fv, Fc, area = symbols("balanced_slide")
    (pressure,) = load_axis("balanced_slide").signals
    return other_way(
        "balanced_slide",
        kinetic=M * dq**2 / 2,
        potential=M * G * q,
        dissipation=friction(dq, Fv, Fc),
        generalised_force=area * pressure,
        signals=(pressure,),
    )


def _linear_motor() -> Axis:
    q, dq, M, Fv, Fc, Fa, Fb = symbols("linear_motor")
    wave = 2 * sympy.pi / Constant(0.016, "m").symbol
    return other_way(
        "linear_motor",
        kinetic=M * dq**2 / 2,
        potential=(Fa * sympy.sin(wave * q) - Fb * sympy.cos(wave * q)) / wave,
        dissipation=friction(dq, Fv, Fc),
    )


def _servo_joint() -> Axis:
    q, dq, J, mgl, fv, fcp, fcm = symbols("servo_joint")
    forwards, backwards = (dq + sympy.Abs(dq)) / 2, (dq - sympy.Abs(dq)) / 2
    return other_way(
        "servo_joint",
        kinetic=J * dq**2 / 2 + Constant(2e-5, "kg m^2", "rotor") * (50 * dq) ** 2 / 2,
        potential=mgl * sympy.sin(q),
        dissipation=fv * dq**2 / 2 + fcp * forwards - fcm * backwards,
    )


OTHER_WAY = {
    "emps2015": _emps2015,
    "emps": _emps,
    "pendulum": _pendulum,
    "vertical_screw": _vertical_screw,
    "belt_axis": _belt_axis,
    "rotary_table": _rotary_table,
    "valve": _valve,
    "crank": _crank,
    "linear_motor": _linear_motor,
    "balanced_slide": _balanced_slide,
    "servo_joint": _servo_joint,
}


def rows(model: AxisModel, expressions: Iterable[sympy.Expr]) -> np.ndarray:
    """The expressions at motions that slide in both directions, and reach the stops."""
    q = model.axis.coordinate
    signals = model.axis.signal_symbols
    arguments = [q.symbol, q.velocity, q.acceleration, FORCE, DIRECTION, *signals]
    function = sympy.lambdify(arguments, list(expressions), "math")
    motions = np.random.default_rng(7).normal(size=(20, 4)) * [0.3, 1, 10, 10]
    recorded = np.random.default_rng(8).normal(size=(20, len(signals)))
    return np.array(
        [
            function(*motion, math.copysign(1, motion[1]), *beside)
            for motion, beside in zip(motions, recorded, strict=True)
        ]
    )


def direct_row(model: AxisModel) -> Regressor | None:
    return None if isinstance(model.ddm, Missing) else model.ddm.regressor


@pytest.mark.parametrize("name", LIBRARY)
def test_newton_and_lagrange_give_the_same_regressors(name: str) -> None:
    one, other = derive(load_axis(name)), derive(OTHER_WAY[name]())
    for regressor in ("idm", "ddm"):
        first, second = (m.idm if regressor == "idm" else direct_row(m) for m in (one, other))
        assert (first is None) == (second is None)
        if first is None or second is None:
            continue
        left = rows(one, (*first.columns, first.intercept))
        right = rows(other, (*second.columns, second.intercept))
        assert np.abs(left - right).max(axis=0) == pytest.approx(
            0, abs=1e-10 * (1 + np.abs(left).max(axis=0)).max()
        )


@pytest.mark.parametrize("name", ["emps2015", "emps"])
def test_for_the_emps_they_are_identical_expressions(name: str) -> None:
    one, other = derive(load_axis(name)), derive(OTHER_WAY[name]())
    assert one.idm == other.idm
    assert one.ddm == other.ddm
    assert one.parameter_map == other.parameter_map


def test_every_library_axis_is_here() -> None:
    assert set(OTHER_WAY) == set(LIBRARY)


@pytest.mark.parametrize("name", LIBRARY)
def test_library_axes_can_be_identified_and_every_unit_is_checked(name: str) -> None:
    axis = load_axis(name)
    assert axis.unchecked_terms == ()
    assert not derive(axis).unidentifiable
    assert set(axis.experiment.truth) == {p.name for p in axis.parameters}
