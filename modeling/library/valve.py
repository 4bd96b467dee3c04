"""A spring-loaded valve actuator: preload, a hardening spring, a sticking packing, end stops.

Figures typical of a small electric valve of 20 mm stroke on a moving coil of 22 N/A, which the
spring closes; 0 is the middle of the stroke, where the spring pushes with its preload. The end
stops are beyond the experiment's stroke: they are intended for simulations that reach them. The
amplifier produces no force within 0.1 A of 0, and acts 0.3 ms after its command, which is three
samples of the law. These figures of its data sheet are declared with the drive, not identified. The
stiction of the packing is a third of its friction; only slow strokes show it.
"""

from axisid.control import cascade_pd_averaged
from axisid.elements import coulomb, cubic_spring, end_stop, offset, spring, stribeck, viscous
from axisid.modeling.declaration import Drive, Experiment, Move, newton
from axisid.modeling.quantities import Coordinate, Parameter

# Reversals distributed over the stroke, m: at its ends alone they would bias the stiffness.
STROKES = (-0.008, 0.014, -0.008, 0.01, -0.014, 0.006)

q = Coordinate("q", unit="m")
m = Parameter("m", "kg", nominal=0.5, lower=0.0, description="stem, plug and coil")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="packing friction")
Fs = Parameter("Fs", "N", lower=0.0, description="stiction of the packing")
F0 = Parameter("F0", "N", description="force of the spring at 0")
k1 = Parameter("k1", "N/m", lower=0.0, description="stiffness of the spring")
k3 = Parameter("k3", "N/m^3", description="hardening of the spring")

axis = newton(
    "valve",
    title="spring-loaded valve actuator",
    coordinate=q,
    parameters=(m, Fv, Fc, Fs, F0, k1, k3),
    inertia=m,
    resistance=(
        viscous(Fv, q),
        coulomb(Fc, q),
        stribeck(Fs, q, velocity=0.05, exponent=1),
        offset(F0),
        spring(k1, q),
        cubic_spring(k3, q),
        end_stop(q, lower=-0.01, upper=0.01, stiffness=2e6, dissipation=2.0),
    ),
    drive=Drive(gain=22.0, unit="A", limit=12.0, delay=3e-4, deadband=0.1),
    control=cascade_pd_averaged(kp=250.0, kv=25.0, period=1e-4),
    experiment=Experiment(
        moves=tuple(Move(d, v, 60.0) for v in (0.02, *(0.1, 0.25, 0.5) * 2) for d in STROKES),
        truth={"m": 0.42, "Fv": 30.0, "Fc": 4.0, "Fs": 1.2, "F0": 45.0, "k1": 2200.0, "k3": 5e6},
        position_noise=1.5e-6,
        seed=1,
    ),
)
