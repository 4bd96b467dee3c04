"""A belt drive with a return spring, declared by Newton and identified from its twin.

Run it: python examples/belt_drive.py
"""

from axisid import Coordinate, Parameter, Prefilter, identify, newton, twin_record
from axisid.control import cascade_pd_averaged
from axisid.elements import Drive, coulomb, spring, viscous
from axisid.modeling import Experiment, back_and_forth

x = Coordinate("x", unit="m")
m = Parameter("m", "kg", nominal=5.0, lower=0.0, description="carriage and pulleys")
b = Parameter("b", "N/(m/s)", lower=0.0)
c = Parameter("c", "N", lower=0.0)
k = Parameter("k", "N/m", lower=0.0)

axis = newton(
    "belt",
    title="belt drive with a return spring",
    coordinate=x,
    parameters=(m, b, c, k),
    inertia=m,
    resistance=(viscous(b, x), coulomb(c, x), spring(k, x, rest=0.02)),
    drive=Drive(gain=18.0, unit="A", limit=12.0),
    control=cascade_pd_averaged(kp=50.0, kv=60.0, period=5e-4),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.1, 0.3, 0.5), acceleration=4.0, seconds=0.5, repeat=3),
        truth={"m": 6.2, "b": 14.0, "c": 7.5, "k": 120.0},
        position_noise=1e-6,
    ),
)

if __name__ == "__main__":
    result = identify(axis, twin_record(axis), Prefilter(cutoff=100.0, decimate=5))
    print(result.summary())
