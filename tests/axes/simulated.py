"""Axes that put the simulation to the test: friction, gravity, springs and laws of every kind."""

from types import MappingProxyType

import sympy

from axisid import Coordinate, Parameter, lagrange, newton
from axisid.control import (
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    cascade_pd,
    cascade_pd_averaged,
    gain,
)
from axisid.elements import Drive, coulomb, offset, spring, viscous

q = Coordinate("q")
M = Parameter("M", "kg", nominal=100.0)
Fv = Parameter("Fv", "N/(m/s)", nominal=200.0)
Fc = Parameter("Fc", "N", nominal=20.0)
F0 = Parameter("F0", "N", nominal=-3.0)
Fb = Parameter("Fb", "N", nominal=5.0)
k = Parameter("k", "N/m", nominal=500.0)
Fr = Parameter("Fr", "N/(m/s)^(1/2)", nominal=200.0)
theta = Coordinate("theta", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.06)
mgl = Parameter("mgl", "N m", nominal=1.0)
fc = Parameter("fc", "N m", nominal=0.1)
J1 = Parameter("J1", "kg m^2", nominal=1.0)

_DRIVE = Drive(gain=35.15, limit=10.0)
_PD = cascade_pd(kp=160.18, kv=243.45, period=1e-3)
_SIGN = sympy.sign(q.velocity)
_total = Memory("total", gain("total") + REFERENCE - MEASURED_POSITION, sympy.Integer(0))

AXES = MappingProxyType(
    {
        "offset": newton(
            "offset",
            coordinate=q,
            parameters=(M, Fv, Fc, F0),
            inertia=M,
            resistance=(viscous(Fv, q), coulomb(Fc, q), offset(F0)),
            drive=_DRIVE,
            control=_PD,
        ),
        "delayed": newton(
            "delayed",
            coordinate=q,
            parameters=(M, Fv, Fc),
            inertia=M,
            resistance=(viscous(Fv, q), coulomb(Fc, q)),
            drive=_DRIVE,
            control=ControlLaw(
                name="PID with a delay of two samples",
                period=1e-3,
                gains={"kp": 60.0, "kv": 150.0, "ki": 1e-5},
                output=gain("kv")
                * (
                    gain("kp") * (REFERENCE - MEASURED_POSITION)
                    + gain("ki") * _total.symbol / PERIOD
                    - MEASURED_VELOCITY
                ),
                memory=(_total,),
                delay=2,
            ),
        ),
        "continuous": newton(
            "continuous",
            coordinate=q,
            parameters=(M, Fv, Fc),
            inertia=M,
            resistance=(viscous(Fv, q), coulomb(Fc, q)),
            drive=_DRIVE,
            control=cascade_pd(kp=160.18, kv=243.45, period=1e-3, continuous=True),
        ),
        "one_sided": newton(
            "one_sided",
            coordinate=q,
            parameters=(M, Fc, Fb),
            inertia=M,
            resistance=(Fc * (1 + _SIGN) / 2, Fb * (_SIGN - 1) / 2),
            drive=_DRIVE,
            control=_PD,
        ),
        "position_dependent": newton(
            "position_dependent",
            coordinate=q,
            parameters=(M, Fc, Fb, k),
            inertia=M,
            resistance=(
                (Fc + Fb * sympy.sin(200 * q.symbol)) * _SIGN,
                spring(k, q, rest=0.01),
            ),
            drive=_DRIVE,
            control=_PD,
        ),
        "root_of_speed": newton(
            "root_of_speed",
            coordinate=q,
            parameters=(M, Fr, Fc),
            inertia=M,
            resistance=(Fr * sympy.sqrt(sympy.Abs(q.velocity)) * _SIGN, coulomb(Fc, q)),
            drive=_DRIVE,
            control=cascade_pd_averaged(kp=160.18, kv=243.45, period=1e-3),
        ),
        "pendulum": lagrange(
            "pendulum",
            coordinate=theta,
            parameters=(J, mgl, fc),
            kinetic=J * theta.velocity**2 / 2,
            potential=-mgl * sympy.cos(theta.symbol),
            dissipation=fc * sympy.Abs(theta.velocity),
            drive=Drive(gain=0.5, unit="A", limit=20.0),
            control=ControlLaw(
                name="PD",
                period=5e-3,
                output=20 * (REFERENCE - MEASURED_POSITION)
                - sympy.Rational(1, 2) * MEASURED_VELOCITY,
            ),
        ),
        "open_pendulum": lagrange(
            "open_pendulum",
            coordinate=theta,
            parameters=(J, mgl, fc),
            kinetic=J * theta.velocity**2 / 2,
            potential=-mgl * sympy.cos(theta.symbol),
            dissipation=fc * sympy.Abs(theta.velocity),
            drive=Drive(gain=1.0, unit="A"),
            control=ControlLaw(name="reference as force", period=5e-3, output=REFERENCE),
        ),
        "crank": lagrange(
            "crank",
            coordinate=theta,
            parameters=(J, J1, fc),
            kinetic=(J + J1 * sympy.sin(theta.symbol) ** 2) * theta.velocity**2 / 2,
            dissipation=fc * sympy.Abs(theta.velocity),
            drive=Drive(gain=1.0, unit="A"),
            control=cascade_pd(kp=40.0, kv=15.0, period=1e-3),
        ),
    }
)
