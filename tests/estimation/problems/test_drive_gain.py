"""What the drive gain's own uncertainty adds to the estimates."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Constant, ModelError, Parameter, Record, build, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import cascade_pd
from axisid.elements import Drive, viscous
from axisid.estimation.estimates.estimate import Estimate
from axisid.modeling import Experiment, back_and_forth
from tests.axes.bodies import body, m, x
from tests.axes.drives import BRAKE, braked

SD = 0.005
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")


def declared(axis: GeneratedAxis, *, scale: float = 1.0, sd: float = SD) -> GeneratedAxis:
    drive = replace(axis.axis.drive, gain=scale * axis.axis.drive.gain, relative_sd=sd)
    return build(replace(axis.axis, drive=drive))


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_it_is_what_another_gain_does_to_the_estimate(emps2015: GeneratedAxis, method: str) -> None:
    record = twin_record(emps2015)
    step = 1e-2
    low, mid, high = (
        identify(declared(emps2015, scale=scale), record, methods=[method])[method]
        for scale in (1 - step, 1.0, 1 + step)
    )

    def slope(of: str) -> float:
        return (high.derive(of).value - low.derive(of).value) / (2 * step)

    for name, value in mid.parameters.items():
        assert value.sd_gain == pytest.approx(SD * abs(slope(name)), rel=1e-3)
        assert value.sd_gain == pytest.approx(SD * value.value, rel=1e-9)
    assert mid.derive("M/Fv").sd_gain == pytest.approx(0.0, abs=1e-12)
    assert slope("M/Fv") == pytest.approx(0.0, abs=1e-4)
    for i, value in enumerate(mid.ddm_parameters.values()):
        moved = (high.theta_ddm[i] - low.theta_ddm[i]) / (2 * step)
        assert value.sd_gain == pytest.approx(SD * abs(moved), rel=1e-2, abs=1e-6 * value.value)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_drive_that_is_no_gain_alone_is_asked_for_its_force_by_another_gain(
    emps2015: GeneratedAxis, method: str
) -> None:
    """The braking of the motor keeps its size, so that friction takes what the gain leaves."""
    axis, step = emps2015.declared, 1e-3
    record = twin_record(build(braked(axis)), seed=3)
    low, mid, high = (
        identify(build(braked(axis, scale=scale, relative_sd=0.01)), record, methods=[method])
        for scale in (1 - step, 1.0, 1 + step)
    )
    estimate = mid[method]
    for name, value in estimate.parameters.items():
        ends = [found[method].parameters[name].value for found in (low, high)]
        slope = abs(ends[1] - ends[0]) / (2 * step)
        assert value.sd_gain == pytest.approx(0.01 * slope, rel=2e-3, abs=1e-3)
    friction = estimate.parameters["Fv"]
    assert friction.sd_gain == pytest.approx(0.01 * (friction.value + BRAKE), rel=2e-3)


def test_measured_force_needs_no_gain(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015)
    force = emps2015.axis.drive.gain * record.control
    measured: Record = replace(record, force=force)
    estimate: Estimate = identify(declared(emps2015), measured, methods=["idm-ls"])["idm-ls"]
    assert estimate.parameters["M"].sd_gain == 0.0


@pytest.mark.parametrize("sd", [-0.1, 1.0, np.nan, np.inf])
def test_impossible_deviations_are_refused(sd: float) -> None:
    with pytest.raises(ModelError, match="drive gain"):
        Drive(gain=1.0, relative_sd=sd)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["idm-ls", "idm-iv", "ddm-ls"])
def test_known_terms_keep_their_size_and_the_others_take_what_is_left(method: str) -> None:
    """With 2 kg known, 1 % of gain moves the unknown 5 kg by 0.07 kg, not by 0.05."""
    b = Parameter("b", "N/(m/s)", nominal=20.0)
    axis = body(
        viscous(b, x),
        coordinate=x,
        inertia=m + Constant(2.0, "kg"),
        parameters=(m, b),
        drive=Drive(gain=18.0, relative_sd=0.01),
        control=cascade_pd(kp=50.0, kv=60.0, period=1e-3),
        experiment=Experiment(
            moves=back_and_forth(speeds=(0.1, 0.3), acceleration=4.0, seconds=0.5, repeat=2),
            position_noise=1e-7,
        ),
    )
    record = twin_record(axis)
    value = identify(axis, record, methods=[method])[method].parameters["m"]
    assert value.sd_gain == pytest.approx(0.07, rel=0.02)
    more = replace(axis, drive=replace(axis.drive, gain=18.0 * 1.01))
    refitted = identify(more, record, methods=["idm-ls"])["idm-ls"].parameters["m"]
    assert abs(refitted.value - value.value) == pytest.approx(value.sd_gain, rel=0.05)
