"""A pendulum with Coulomb friction on a direct drive, its angle 0 hanging down.

Typical of a laboratory arm: 0.23 kg half a metre from the pivot, a disc motor of 0.5 N m/A.
"""

from axisid.control import cascade_pd_averaged
from axisid.elements import G, coulomb, gravity_moment, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Coordinate, Parameter

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.1, lower=0.0, description="inertia about the pivot")
mx = Parameter("mx", "kg m", description="mass times distance to its centre")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0, description="viscous friction")
fc = Parameter("fc", "N m", lower=0.0, description="Coulomb friction")

axis = newton(
    "pendulum",
    title="pendulum with Coulomb friction",
    coordinate=q,
    parameters=(J, mx, fv, fc),
    inertia=J,
    resistance=(viscous(fv, q), coulomb(fc, q), gravity_moment(G * mx, 0, q)),
    drive=Drive(gain=0.5, unit="A", limit=20.0),
    control=cascade_pd_averaged(kp=20.0, kv=12.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(1.0, 2.0, 4.0), acceleration=40.0, seconds=0.6, repeat=3),
        truth={"J": 0.0626, "mx": 0.12, "fv": 0.02, "fc": 0.09},
        position_noise=5e-6,
        seed=1,
    ),
)
