"""The DFKI torque-controlled pendulum, declared by Lagrange, under the law of its drive.

Run it: axisid identify examples/dfki_pendulum.py pd_system_identification_measured.csv --hold raw
(least squares; `dfki_pendulum_study.py` adds the reference that instruments need, and
docs/dfki_pendulum.md says what comes of it).

The drive is a T-Motor AK80-6: the computer sends it a position, a velocity and two gains, and the
drive's own board closes the loop, ``tau = p (reference - q) + d (dreference - dq)``. The gains of
the recorded run are not in the log; 50 N m/rad and 4 N m s/rad are those of the authors' parameter
file for PD control.
"""

import sympy

from axisid import Constant, Coordinate, Parameter, lagrange
from axisid.control import (
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    gain,
)
from axisid.elements import Drive

GRAVITY = Constant(9.81, "m/s^2", "g")  # as the authors have it, so that mc compares

q = Coordinate("q", unit="rad")  # 0 hangs down
J = Parameter("J", "kg m^2", nominal=0.15, lower=0.0, description="inertia about the pivot")
mc = Parameter("mc", "kg m", nominal=0.30, description="mass times distance to centre of gravity")
Fv = Parameter("Fv", "N m/(rad/s)", lower=0.0)
Fc = Parameter("Fc", "N m", lower=0.0)
tau0 = Parameter("tau0", "N m", description="offset of the torque")


def drive_law(p: float = 50.0, d: float = 4.0) -> ControlLaw:
    """PD on position and velocity, without feed-forward.

    The velocity is the drive's own, taken as ideal; the commanded one is the reference's backward
    difference. The board evaluates the law many times in a period of the log; here once.

    Parameters
    ----------
    p : float
        N m/rad.
    d : float
        N m/(rad/s).
    """
    # The record begins at rest, so that its first position stands for the reference before it.
    last = Memory("last_reference", following=REFERENCE, start=MEASURED_POSITION)
    return ControlLaw(
        name="PD of the drive",
        period=1 / 300,
        gains={"p": p, "d": d},
        output=gain("p") * (REFERENCE - MEASURED_POSITION)
        + gain("d") * ((REFERENCE - last.symbol) / PERIOD - MEASURED_VELOCITY),
        memory=(last,),
    )


axis = lagrange(
    "dfki_pendulum",
    title="DFKI torque-limited simple pendulum",
    coordinate=q,
    parameters=(J, mc, Fv, Fc, tau0),
    kinetic=J * q.velocity**2 / 2,
    potential=-mc * GRAVITY * sympy.cos(q.symbol) + tau0 * q.symbol,
    dissipation=Fv * q.velocity**2 / 2 + Fc * sympy.Abs(q.velocity),
    drive=Drive(gain=1.0, unit="N m"),  # commanded and reported in newton metres
    control=drive_law(),
    columns={"control": "torque"},
)
