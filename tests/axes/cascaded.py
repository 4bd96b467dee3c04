"""A vertical axis of a screw under a servo drive's cascade."""

from axisid import Axis, Coordinate, Parameter, newton
from axisid.control import cascade_p_pi
from axisid.elements import Drive, coulomb, offset, viscous
from axisid.modeling import Experiment, back_and_forth


def cascaded(*, delay: float = 0.0, lag: float = 0.0) -> Axis:
    """The axis, with its twin's experiment, and a drive with such a delay and lag, s."""
    z = Coordinate("z", unit="m")
    mass = Parameter("M", "kg", nominal=200.0, lower=0.0)
    fv, fc = Parameter("Fv", "N/(m/s)", lower=0.0), Parameter("Fc", "N", lower=0.0)
    weight = Parameter("W", "N")
    return newton(
        "cascaded",
        coordinate=z,
        parameters=(mass, fv, fc, weight),
        inertia=mass,
        resistance=(viscous(fv, z), coulomb(fc, z), offset(weight)),
        drive=Drive(gain=282.7, unit="A", limit=20.0, delay=delay, lag=lag),
        control=cascade_p_pi(kp=40.0, kv=200.0, tn=0.02, period=1e-3),
        experiment=Experiment(
            moves=back_and_forth(speeds=(0.05, 0.2, 0.4), acceleration=4.0, seconds=0.6, repeat=2),
            truth={"M": 243.0, "Fv": 1800.0, "Fc": 320.0, "W": 834.0},
            position_noise=2e-6,
            seed=3,
        ),
    )
