"""A linear motor whose force constant depends on the position, with cogging.

Figures typical of an iron-core motor of 16 mm pole pitch (as in [Gieras2012]_): 58 N/A on average,
a ripple of 3 % known from the back-EMF, cogging of a few newtons. The profile divides the force
balance, so that every parameter stays linear: this is exact for a known profile, which is not
identified here. Because the inertia relative to the nominal force depends on the position, there is
no direct regressor.
"""

import sympy

from axisid.control import cascade_pd_averaged
from axisid.elements import cogging, coulomb, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Constant, Coordinate, Parameter

pitch = Constant(0.016, "m", "pitch")

q = Coordinate("q", unit="m")
M = Parameter("M", "kg", nominal=10.0, lower=0.0, description="carriage and coils")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")
Fa = Parameter("Fa", "N", description="cogging, cosine")
Fb = Parameter("Fb", "N", description="cogging, sine")

axis = newton(
    "linear_motor",
    title="linear motor with a force constant of its position",
    coordinate=q,
    parameters=(M, Fv, Fc, Fa, Fb),
    inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q), cogging(Fa, Fb, q, period=pitch)),
    drive=Drive(
        gain=58.0,
        unit="A",
        limit=12.0,
        profile=1 + 0.03 * sympy.cos(sympy.pi * q / pitch),
    ),
    control=cascade_pd_averaged(kp=60.0, kv=35.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.05, 0.15, 0.4), acceleration=15.0, seconds=0.7, repeat=3),
        truth={"M": 8.3, "Fv": 14.0, "Fc": 9.0, "Fa": 5.0, "Fb": -3.5},
        position_noise=1.5e-6,
        seed=1,
    ),
)
