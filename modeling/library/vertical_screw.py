"""A vertical ball-screw axis with gravity and a pneumatic counterbalance: the Z axis of a mill.

Figures typical of a machining centre (feed drives are in [Altintas2012]_): a screw of 10 mm pitch
on a motor of 1.2 N m/A. The inertia of motor and screw, 1260 kg at the slide, is known from their
data sheets. Without it, the inertia could not be distinguished from the mass, nor the weight from
the counterbalance. The force of the counterbalance falls as the slide rises, by its rate.
"""

import math

from axisid.control import cascade_pd_averaged
from axisid.elements import coulomb, gravity, motor_inertia, offset, spring, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Constant, Coordinate, Parameter

TURNS = 2 * math.pi / 0.01  # rad/m
rotor = Constant(3.2e-3, "kg m^2", "rotor")

q = Coordinate("q", unit="m")  # upwards
M = Parameter("M", "kg", nominal=200.0, lower=0.0, description="slide and spindle")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")
Fb = Parameter("Fb", "N", description="counterbalance at 0")
kb = Parameter("kb", "N/m", lower=0.0, description="fall of the counterbalance over the stroke")

axis = newton(
    "vertical_screw",
    title="vertical ball screw with counterbalance",
    coordinate=q,
    parameters=(M, Fv, Fc, Fb, kb),
    inertia=M + motor_inertia(rotor, q, ratio=TURNS),
    resistance=(viscous(Fv, q), coulomb(Fc, q), gravity(M), offset(-Fb), spring(kb, q)),
    drive=Drive(gain=1.2 * TURNS, unit="A", limit=30.0),
    control=cascade_pd_averaged(kp=60.0, kv=480.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.1, 0.25, 0.4), acceleration=6.0, seconds=0.6, repeat=3),
        truth={"M": 180.0, "Fv": 1500.0, "Fc": 160.0, "Fb": 1200.0, "kb": 450.0},
        position_noise=3e-7,
        seed=1,
    ),
)
