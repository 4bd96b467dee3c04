"""An axis never seen before: declared here, generated, simulated, identified."""

import pytest
import sympy

from axisid import Coordinate, Parameter, Prefilter, identify, lagrange, newton, twin_record
from axisid.control import (
    MEASURED_POSITION,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    cascade_pd_averaged,
    gain,
)
from axisid.elements import Drive, coulomb, spring, viscous
from axisid.modeling import Experiment, back_and_forth
from axisid.modeling.declaration.axis import Axis

x = Coordinate("x")
m = Parameter("m", "kg", nominal=5.0, lower=0.0)
b = Parameter("b", "N/(m/s)")
c = Parameter("c", "N")
k = Parameter("k", "N/m")

BELT = newton(
    "belt",
    title="belt drive with a spring",
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

theta = Coordinate("theta", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.1, lower=0.0)
mgl = Parameter("mgl", "N m")
fv = Parameter("fv", "N m/(rad/s)")
fc = Parameter("fc", "N m")
error = Memory("error_sum", following=gain("error_sum") + REFERENCE - MEASURED_POSITION, start=0)  # type: ignore[arg-type]
last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)

PENDULUM = lagrange(
    "pendulum",
    coordinate=theta,
    parameters=(J, mgl, fv, fc),
    kinetic=J * theta.velocity**2 / 2,
    potential=-mgl * sympy.cos(theta.symbol),
    dissipation=fv * theta.velocity**2 / 2 + fc * sympy.Abs(theta.velocity),
    drive=Drive(gain=0.5, unit="A"),
    control=ControlLaw(
        name="PID on encoder differences",
        period=1e-3,
        gains={"p": 40.0, "i": 0.02, "d": 4.0},
        output=gain("p") * (REFERENCE - MEASURED_POSITION)
        + gain("i") * error.symbol
        - gain("d") * (MEASURED_POSITION - last.symbol) / PERIOD,
        memory=(error, last),
    ),
    experiment=Experiment(
        moves=back_and_forth(speeds=(1.0, 2.0, 4.0), acceleration=40.0, seconds=0.6, repeat=3),
        truth={"J": 0.0626, "mgl": 1.0, "fv": 0.02, "fc": 0.09},
        position_noise=1e-6,
        seed=5,
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize("axis", [BELT, PENDULUM], ids=lambda axis: axis.name)
def test_unseen_axis_is_identified_from_its_twin_within_one_percent(axis: Axis) -> None:
    result = identify(
        axis, twin_record(axis), Prefilter(cutoff=100.0, decimate=5, hold="zoh", drop=(30, 30))
    )
    truth = [axis.experiment.truth[p.name] for p in axis.parameters]
    assert set(result.estimates) == {"idm-ls", "ddm-ls", "idm-iv", "ddm-iv", "didim"}
    for method in ("idm-ls", "idm-iv", "ddm-iv"):
        assert result[method].physical == pytest.approx(truth, rel=0.01), method


@pytest.mark.slow
def test_axis_without_law_is_identified_by_least_squares_and_says_what_it_left_out() -> None:
    from dataclasses import replace

    record = twin_record(BELT)
    result = identify(replace(BELT, control=None), record, Prefilter(cutoff=100.0, decimate=5))
    assert set(result.estimates) == {"idm-ls", "ddm-ls"}
    assert set(result.skipped) == {"idm-iv", "ddm-iv", "didim"}
    assert "no control law" in result.skipped["idm-iv"].text
    assert result["idm-ls"].simulation_error_percent is None
    assert "without idm-iv, ddm-iv, didim" in result.summary()
