"""The paper's axis: a ball-screw stage with a DC motor under position control.

[Brunot2015]_: mass, viscous and Coulomb friction. The true values of the twin are the paper's
IDM-IV estimates of Table 1. The paper does not publish its motion: the twin's motion was chosen
here, for forces within 150 N.
"""

from axisid.control import cascade_pd
from axisid.elements import coulomb, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Coordinate, Parameter

q = Coordinate("q", unit="m")
M = Parameter("M", "kg", nominal=100.0, lower=0.0, description="mass")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")

axis = newton(
    "emps2015",
    title="EMPS as in the paper of 2015",
    coordinate=q,
    parameters=(M, Fv, Fc),
    inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q)),
    drive=Drive(gain=35.15, unit="V", limit=10.0),
    control=cascade_pd(kp=160.18, kv=243.45, period=1e-3),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.05, 0.1, 0.15), acceleration=0.75, seconds=0.3, repeat=3),
        truth={"M": 100.2, "Fv": 236.9, "Fc": 24.8},
        position_noise=3.8e-6,
        seed=2015,
    ),
)
