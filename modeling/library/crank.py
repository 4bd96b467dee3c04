"""A crank press: a slider on a crank, whose inertia depends on the crank's angle.

Figures typical of a small servo press: crank 50 mm, rod 200 mm, a slider of 4 kg moving vertically,
highest at 0, a geared motor of 1.2 N m/A. The slider's position is
``x = r cos q + sqrt(l^2 - r^2 sin^2 q)``, its velocity ``x' dq``; `lagrange` derives the equation
of motion. The acceleration is not linear in a finite set of parameters, so there is no direct
regressor.
"""

import sympy

from axisid.control import cascade_pd_averaged
from axisid.elements import G
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, lagrange
from axisid.modeling.quantities import Constant, Coordinate, Parameter

radius, rod = Constant(0.05, "m", "radius").symbol, Constant(0.2, "m", "rod").symbol

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.03, lower=0.0, description="crank, gear and motor")
m = Parameter("m", "kg", nominal=3.0, lower=0.0, description="slider")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0, description="viscous friction")
fc = Parameter("fc", "N m", lower=0.0, description="Coulomb friction")

x = radius * sympy.cos(q.symbol) + sympy.sqrt(rod**2 - radius**2 * sympy.sin(q.symbol) ** 2)

axis = lagrange(
    "crank",
    title="crank with configuration-dependent inertia",
    coordinate=q,
    parameters=(J, m, fv, fc),
    kinetic=(J + m * x.diff(q.symbol) ** 2) * q.velocity**2 / 2,
    potential=m * G * x,
    dissipation=fv * q.velocity**2 / 2 + fc * sympy.Abs(q.velocity),
    drive=Drive(gain=1.2, unit="A", limit=20.0),
    control=cascade_pd_averaged(kp=20.0, kv=3.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(4.0, 8.0, 12.0), acceleration=80.0, seconds=0.9, repeat=3),
        truth={"J": 0.024, "m": 4.1, "fv": 0.06, "fc": 0.5},
        position_noise=2e-5,
        seed=1,
    ),
)
