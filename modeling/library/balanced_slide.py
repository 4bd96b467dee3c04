"""Vertical slide with a weight balanced by a pneumatic cylinder, whose pressure is recorded.

The pressure varies as the reservoir is fed and as the slide moves. The recorded pressure enters the
equation of motion, so that the area on which it acts can be distinguished from the weight.
"""

import sympy

from axisid.control import cascade_pd_averaged
from axisid.elements import TIME, coulomb, gravity, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Coordinate, Parameter, Signal

pressure = Signal("pressure", "Pa", description="pressure in the cylinder")

q = Coordinate("q", unit="m")  # upwards
M = Parameter("M", "kg", nominal=80.0, lower=0.0, description="slide")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")
area = Parameter("area", "m^2", nominal=1e-3, lower=0.0, description="area of the cylinder")

axis = newton(
    "balanced_slide",
    title="vertical slide with a pneumatic counterbalance",
    coordinate=q,
    parameters=(M, Fv, Fc, area),
    signals=(pressure,),
    inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q), gravity(M), -area * pressure),
    drive=Drive(gain=58.0, unit="A", limit=20.0),
    control=cascade_pd_averaged(kp=50.0, kv=180.0, period=5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.15, 0.35, 0.6), acceleration=6.0, seconds=0.6, repeat=3),
        truth={"M": 92.0, "Fv": 210.0, "Fc": 35.0, "area": 1.4e-3},
        position_noise=1e-6,
        seed=1,
        signals={
            "pressure": 6.2e5 + 5e4 * sympy.sin(2.1 * TIME) + 2e4 * sympy.sin(9.7 * TIME),
        },
    ),
)
