"""A toothed-belt axis driven through a gear, with friction that differs between directions.

Figures typical of a pick-and-place axis: a gear of 5, a pulley of 30 mm radius, a motor of
0.45 N m/A whose inertia of 1.8 kg cm^2, 5 kg at the carriage, is known from its data sheet.
"""

from axisid.control import cascade_pd_averaged
from axisid.elements import asymmetric_coulomb, asymmetric_viscous, motor_inertia
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Constant, Coordinate, Parameter

TURNS = 5 / 0.03  # rad/m
rotor = Constant(1.8e-4, "kg m^2", "rotor")

q = Coordinate("q", unit="m")
m = Parameter("m", "kg", nominal=10.0, lower=0.0, description="carriage, belt and pulleys")
Fvp = Parameter("Fvp", "N/(m/s)", lower=0.0, description="viscous friction forwards")
Fvm = Parameter("Fvm", "N/(m/s)", lower=0.0, description="viscous friction backwards")
Fcp = Parameter("Fcp", "N", lower=0.0, description="Coulomb friction forwards")
Fcm = Parameter("Fcm", "N", lower=0.0, description="Coulomb friction backwards")

axis = newton(
    "belt_axis",
    title="belt axis with motor inertia and gear",
    coordinate=q,
    parameters=(m, Fvp, Fvm, Fcp, Fcm),
    inertia=m + motor_inertia(rotor, q, ratio=TURNS),
    resistance=(asymmetric_viscous(Fvp, Fvm, q), asymmetric_coulomb(Fcp, Fcm, q)),
    drive=Drive(gain=0.45 * TURNS, unit="A", limit=15.0),
    control=cascade_pd_averaged(kp=40.0, kv=40.0, period=2.5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.2, 0.6, 1.2), acceleration=10.0, seconds=0.5, repeat=3),
        truth={"m": 12.0, "Fvp": 35.0, "Fvm": 42.0, "Fcp": 26.0, "Fcm": 31.0},
        position_noise=2e-6,
        seed=1,
    ),
)
