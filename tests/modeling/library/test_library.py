"""Every library axis declared the other way, Lagrange for Newton: the same regressors."""

import math
from collections.abc import Callable, Iterable

import numpy as np
import pytest
import sympy

from axisid import Constant, derive, lagrange, load_axis, newton
from axisid.elements import G, end_stop
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.derivation.model import AxisModel
from axisid.modeling.library import crank
from axisid.modeling.quantities.symbols import DIRECTION, FORCE
from axisid.support.missing import Missing


def friction(dq: sympy.Symbol, fv: sympy.Symbol, fc: sympy.Symbol) -> sympy.Expr:
    return fv * dq**2 / 2 + fc * sympy.Abs(dq)


def one_way(dq: sympy.Symbol, forwards: sympy.Symbol, backwards: sympy.Symbol) -> sympy.Expr:
    return forwards * (dq + sympy.Abs(dq)) / 2 - backwards * (dq - sympy.Abs(dq)) / 2


SPIN = {  # rad/m
    "screw": 2 * sympy.pi / Constant(0.01, "m").symbol,
    "belt": 5 / Constant(0.03, "m").symbol,
    "wave": 2 * sympy.pi / Constant(0.016, "m").symbol,
}
SCREW, BELT = Constant(3.2e-3, "kg m^2").symbol, Constant(1.8e-4, "kg m^2").symbol
ROTOR = Constant(2e-5, "kg m^2", "rotor").symbol
WAVE = SPIN["wave"]
STOPS = {"lower": -0.01, "upper": 0.01, "stiffness": 2e6, "dissipation": 2.0}

#: Energies by position, velocity and the parameters.
ENERGIES: dict[str, Callable[..., dict[str, sympy.Expr]]] = {
    "emps2015": lambda _, dq, M, Fv, Fc: {
        "kinetic": M * dq**2 / 2,
        "dissipation": friction(dq, Fv, Fc),
    },
    "emps": lambda _, dq, M, Fv, Fc, tau0: {
        "kinetic": M * dq**2 / 2,
        "dissipation": friction(dq, Fv, Fc),
        "generalised_force": -tau0,
    },
    "pendulum": lambda q, dq, J, mx, fv, fc: {
        "kinetic": J * dq**2 / 2,
        "potential": -mx * G * sympy.cos(q),
        "dissipation": friction(dq, fv, fc),
    },
    "vertical_screw": lambda q, dq, M, Fv, Fc, Fb, kb: {
        "kinetic": M * dq**2 / 2 + SCREW * (SPIN["screw"] * dq) ** 2 / 2,
        "potential": M * G * q - Fb * q + kb * q**2 / 2,
        "dissipation": friction(dq, Fv, Fc),
    },
    "belt_axis": lambda _, dq, m, Fvp, Fvm, Fcp, Fcm: {
        "kinetic": m * dq**2 / 2 + BELT * (SPIN["belt"] * dq) ** 2 / 2,
        "dissipation": Fvp * (dq + sympy.Abs(dq)) ** 2 / 8
        + Fvm * (dq - sympy.Abs(dq)) ** 2 / 8
        + one_way(dq, Fcp, Fcm),
    },
    "rotary_table": lambda q, dq, J, fv, fc, ca, cb: {
        "kinetic": J * dq**2 / 2,
        "potential": (ca * sympy.sin(66 * q) - cb * sympy.cos(66 * q)) / 66,
        "dissipation": friction(dq, fv, fc),
    },
    "valve": lambda q, dq, m, Fv, Fc, Fs, F0, k1, k3: {
        "kinetic": m * dq**2 / 2,
        "potential": F0 * q + k1 * q**2 / 2 + k3 * q**4 / 4,
        "dissipation": friction(dq, Fv, Fc),
        "generalised_force": -end_stop(load_axis("valve").coordinate, **STOPS)
        - Fs * sympy.exp(-sympy.Abs(dq) / sympy.Float(0.05)) * sympy.sign(dq),
    },
    "linear_motor": lambda q, dq, M, Fv, Fc, Fa, Fb: {
        "kinetic": M * dq**2 / 2,
        "potential": (Fa * sympy.sin(WAVE * q) - Fb * sympy.cos(WAVE * q)) / WAVE,
        "dissipation": friction(dq, Fv, Fc),
    },
    "balanced_slide": lambda q, dq, M, Fv, Fc, area: {
        "kinetic": M * dq**2 / 2,
        "potential": M * G * q,
        "dissipation": friction(dq, Fv, Fc),
        "generalised_force": area * load_axis("balanced_slide").signals[0],
    },
    "servo_joint": lambda q, dq, J, mgl, fv, fcp, fcm: {
        "kinetic": J * dq**2 / 2 + ROTOR * (50 * dq) ** 2 / 2,
        "potential": mgl * sympy.sin(q),
        "dissipation": fv * dq**2 / 2 + one_way(dq, fcp, fcm),
    },
}


def other_way(name: str) -> Axis:
    axis = load_axis(name)
    shared = {"coordinate": axis.coordinate, "parameters": axis.parameters, "drive": axis.drive}
    q, dq, symbols = (
        axis.coordinate.symbol,
        axis.coordinate.velocity,
        [p.symbol for p in axis.parameters],
    )
    if name == "crank":  # by d'Alembert: the slider's inertia and weight, times the lever ``x'``
        (J, m, fv, fc), lever = symbols, crank.x.diff(q)
        slider = lever * axis.coordinate.acceleration + lever.diff(q) * dq**2
        resistance = (m * (slider + G) * lever, fv * dq, fc * sympy.sign(dq))
        return newton(name, inertia=J, resistance=resistance, **shared)
    return lagrange(name, signals=axis.signals, **shared, **ENERGIES[name](q, dq, *symbols))


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


@pytest.mark.parametrize("name", LIBRARY)
def test_newton_and_lagrange_give_the_same_regressors(name: str) -> None:
    one, other = derive(load_axis(name)), derive(other_way(name))
    for regressor in ("idm", "ddm"):
        first, second = (getattr(model, regressor) for model in (one, other))
        assert isinstance(first, Missing) == isinstance(second, Missing)
        if isinstance(first, Missing):
            continue
        left = rows(one, (*first.columns, first.intercept))
        right = rows(other, (*second.columns, second.intercept))
        assert np.abs(left - right).max(axis=0) == pytest.approx(
            0, abs=1e-10 * (1 + np.abs(left).max(axis=0)).max()
        )


@pytest.mark.parametrize("name", LIBRARY)
def test_library_axes_can_be_identified_and_every_unit_is_checked(name: str) -> None:
    axis = load_axis(name)
    assert axis.unchecked_terms == ()
    assert not derive(axis).unidentifiable
    assert set(axis.experiment.truth) == {p.name for p in axis.parameters}
