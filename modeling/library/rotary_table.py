"""A rotary table on a torque motor, with cogging: one harmonic, 66 periods a turn.

Figures typical of a direct-drive indexing table of 300 mm (22 pole pairs; cogging as in
[Gieras2012]_): 8 N m/A and a cogging of about 1 % of the rated torque.
"""

import math

from axisid.control import cascade_pd_averaged
from axisid.elements import cogging, coulomb, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Coordinate, Parameter

PERIOD = 2 * math.pi / 66  # rad

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=1.0, lower=0.0, description="table and rotor")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0, description="viscous friction")
fc = Parameter("fc", "N m", lower=0.0, description="Coulomb friction")
ca = Parameter("ca", "N m", description="cogging, cosine")
cb = Parameter("cb", "N m", description="cogging, sine")

axis = newton(
    "rotary_table",
    title="rotary table with cogging",
    coordinate=q,
    parameters=(J, fv, fc, ca, cb),
    inertia=J,
    resistance=(viscous(fv, q), coulomb(fc, q), cogging(ca, cb, q, period=PERIOD)),
    drive=Drive(gain=8.0, unit="A", limit=30.0),
    control=cascade_pd_averaged(kp=40.0, kv=20.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.7, 1.5, 3.0), acceleration=30.0, seconds=0.8, repeat=3),
        truth={"J": 0.82, "fv": 2.4, "fc": 5.5, "ca": 1.2, "cb": -0.7},
        position_noise=4e-6,
        seed=1,
    ),
)
