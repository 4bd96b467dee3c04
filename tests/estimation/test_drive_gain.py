"""What the drive gain's own uncertainty adds to the estimates."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Drive,
    ModelError,
    Parameter,
    Record,
    build,
    identify,
    load_axis,
    newton,
    twin_record,
    viscous,
)
from axisid.codegen import GeneratedAxis
from axisid.estimation import Estimate

SD = 0.005
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")


def declared(axis: GeneratedAxis, *, scale: float = 1.0, sd: float = SD) -> GeneratedAxis:
    drive = replace(axis.axis.drive, gain=scale * axis.axis.drive.gain, relative_sd=sd)
    return build(replace(axis.axis, drive=drive))


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
        assert value.sd_gain == pytest.approx(SD * value.value, rel=1e-12)
    assert mid.derive("M/Fv").sd_gain == pytest.approx(0.0, abs=1e-15)
    assert slope("M/Fv") == pytest.approx(0.0, abs=1e-4)
    for i, value in enumerate(mid.ddm_parameters.values()):
        moved = (high.theta_ddm[i] - low.theta_ddm[i]) / (2 * step)
        assert value.sd_gain == pytest.approx(SD * abs(moved), rel=1e-2, abs=1e-6 * value.value)


def test_it_is_in_no_other_figure(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015)
    exact = identify(emps2015, record, methods=["idm-ls"])
    known = identify(declared(emps2015), record, methods=["idm-ls"])
    for name, value in known["idm-ls"].parameters.items():
        assert replace(value, sd_gain=0.0) == exact["idm-ls"].parameters[name]
    assert "The drive gain is declared" not in exact.summary().partition("[1]")[2]
    text = " ".join(known.summary().split())
    assert "the drive gain is declared to 0.5 %" in text.lower()
    entry = known.to_dict()["estimates"][0]["parameters"]["M"]
    assert entry["sd_gain"] == pytest.approx(SD * entry["value"])


def test_measured_force_needs_no_gain(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015)
    assert record.control is not None
    force = emps2015.axis.drive.gain * record.control
    measured: Record = replace(record, force=force)
    estimate: Estimate = identify(declared(emps2015), measured, methods=["idm-ls"])["idm-ls"]
    assert estimate.parameters["M"].sd_gain == 0.0


@pytest.mark.parametrize("sd", [-0.1, 1.0, np.nan, np.inf])
def test_impossible_deviations_are_refused(sd: float) -> None:
    with pytest.raises(ModelError, match="drive gain"):
        Drive(gain=1.0, relative_sd=sd)


def test_generated_code_does_not_depend_on_it() -> None:
    axis = load_axis("emps2015")
    assert declared(build(axis)).signature == build(axis).signature


def test_known_terms_forbid_a_figure_and_say_so() -> None:
    x = Coordinate("x")
    m, b = Parameter("m", "kg", nominal=5.0), Parameter("b", "N/(m/s)")
    axis = newton(
        "half_known",
        coordinate=x,
        parameters=(m, b),
        inertia=m + 2.0,
        resistance=(viscous(b, x),),
        drive=Drive(gain=18.0, relative_sd=SD),
    )
    t = 1e-3 * np.arange(4000)
    record = Record(
        time=t, position=0.05 * np.sin(6 * t), control=-2.0 * np.sin(6 * t) + 0.1 * np.cos(6 * t)
    )
    result = identify(axis, record, methods=["idm-ls"])
    assert result["idm-ls"].parameters["m"].sd_gain is None
    assert result["idm-ls"].derive("m/b").sd_gain is None
    assert "the model has known terms" in " ".join(result.summary().split())
    assert result.to_dict()["estimates"][0]["parameters"]["m"]["sd_gain"] is None
