"""A pendulum with Coulomb friction, declared by Lagrange, under a law of its own.

Run it: axisid identify examples/pendulum.py
"""

import sympy

from axisid import Coordinate, Parameter, lagrange
from axisid.control import MEASURED_POSITION, PERIOD, REFERENCE, ControlLaw, Memory, gain
from axisid.elements import Drive
from axisid.modeling import Experiment, back_and_forth

theta = Coordinate("theta", unit="rad")  # 0 hangs down
J = Parameter("J", "kg m^2", nominal=0.1, lower=0.0, description="inertia about the pivot")
mgl = Parameter("mgl", "N m", description="weight times distance to the centre of gravity")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0)
fc = Parameter("fc", "N m", lower=0.0)

last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)

axis = lagrange(
    "swing",
    title="pendulum with Coulomb friction",
    coordinate=theta,
    parameters=(J, mgl, fv, fc),
    kinetic=J * theta.velocity**2 / 2,
    potential=-mgl * sympy.cos(theta.symbol),
    dissipation=fv * theta.velocity**2 / 2 + fc * sympy.Abs(theta.velocity),
    drive=Drive(gain=0.5, unit="A", limit=20.0),
    control=ControlLaw(
        name="PD on encoder differences",
        period=1e-3,
        gains={"p": 40.0, "d": 4.0},
        output=gain("p") * (REFERENCE - MEASURED_POSITION)
        - gain("d") * (MEASURED_POSITION - last.symbol) / PERIOD,
        memory=(last,),
    ),
    experiment=Experiment(
        moves=back_and_forth(speeds=(1.0, 2.0, 4.0), acceleration=40.0, seconds=0.6, repeat=3),
        truth={"J": 0.0626, "mgl": 1.0, "fv": 0.02, "fc": 0.09},
        position_noise=1e-5,
    ),
)
