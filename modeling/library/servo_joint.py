"""A joint of an arm on a servo drive with a gear, controlled by the cascade of most drives.

Figures typical of a 100 W joint module (harmonic gear of 50, motor of 0.05 N m/A, rotor of 2e-5 kg
m^2 by its data sheet, encoder of 16384 counts on the motor): 2.5 N m/A on the joint's side, where
friction of the gear is larger in one direction than in the other. The drive runs a position loop
over a velocity loop with an integral and velocity feed-forward; the integral stands still at the
current limit. The current follows the command with a lag of 0.8 ms; the command is logged. The law
measures whole counts of 7.7e-6 rad of the joint.
"""

import math

from axisid.control import cascade_p_pi
from axisid.elements import asymmetric_coulomb, gravity_moment, motor_inertia, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Constant, Coordinate, Parameter

GEAR, COUNTS = 50.0, 16384
ROTOR = Constant(2e-5, "kg m^2", "rotor")

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.2, lower=0.0, description="arm")
ml = Parameter("mgl", "N m", description="moment of the arm's weight, level at 0")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0, description="viscous friction")
fcp = Parameter("fcp", "N m", lower=0.0, description="Coulomb friction upwards")
fcm = Parameter("fcm", "N m", lower=0.0, description="Coulomb friction downwards")

axis = newton(
    "servo_joint",
    title="joint of an arm on a servo drive with a gear",
    coordinate=q,
    parameters=(J, ml, fv, fcp, fcm),
    inertia=J.symbol + motor_inertia(ROTOR, q, ratio=GEAR),
    resistance=(gravity_moment(0, ml, q), viscous(fv, q), asymmetric_coulomb(fcp, fcm, q)),
    drive=Drive(gain=2.5, unit="A", limit=8.0, lag=0.8e-3),
    control=cascade_p_pi(
        kp=25.0,
        kv=6.0,
        tn=0.02,
        period=1e-3,
        velocity="averaged",
        velocity_feed_forward=1.0,
        anti_windup="clamping",
    ),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.4, 0.9, 1.6), acceleration=12.0, seconds=0.6, repeat=3),
        truth={"J": 0.17, "mgl": 4.2, "fv": 0.9, "fcp": 1.6, "fcm": 1.3},
        position_noise=1e-6,
        resolution=2 * math.pi / COUNTS / GEAR,
        seed=1,
    ),
)
