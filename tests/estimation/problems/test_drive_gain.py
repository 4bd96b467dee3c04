"""What the drive gain's uncertainty adds to estimates, and what a record does not show."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Axis,
    EstimationError,
    ModelError,
    Prefilter,
    build,
    identify,
    load_axis,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import Drive
from axisid.estimation.problems.visibility import SignalRanges, check_visible
from axisid.estimation.regression.forms import InverseForm
from axisid.estimation.signals.filtered_record import FilteredRecord
from axisid.modeling import LIBRARY
from tests.axes.drives import BRAKE, braked
from tests.axes.unseen import with_bump, with_stribeck
from tests.estimation.methods.test_partially_linear import TRUTH, stribeck_axis
from tests.refusals import refuses

SD = 0.005
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")


def scaled(axis: Axis, scale: float = 1.0, relative_sd: float = SD) -> Axis:
    gain = scale * axis.drive.gain
    return replace(axis, drive=replace(axis.drive, gain=gain, relative_sd=relative_sd))


@pytest.mark.slow
@pytest.mark.parametrize(("made", "kept"), [(scaled, 0.0), (braked, BRAKE)])
@pytest.mark.parametrize("method", METHODS)
def test_it_is_what_another_gain_does_to_the_estimate(
    emps2015: GeneratedAxis, method: str, made: Callable[..., Axis], kept: float
) -> None:
    """Where a motor brakes, that keeps its size: friction takes what the gain leaves."""
    step = 1e-3
    record = twin_record(build(made(emps2015.declared)), seed=3)
    axes = [made(emps2015.declared, scale=s, relative_sd=SD) for s in (1 - step, 1.0, 1 + step)]
    low, mid, high = (identify(a, record, methods=[method], bootstrap=0)[method] for a in axes)

    def slope(of: str) -> float:
        return abs(high.derive(of).value - low.derive(of).value) / (2 * step)

    for name, value in mid.parameters.items():
        assert value.sd_gain == pytest.approx(SD * slope(name), rel=2e-3, abs=1e-3)
        also = value.value + (kept if name == "Fv" else 0.0)
        assert value.sd_gain == pytest.approx(SD * also, rel=2e-3)
    for i, value in enumerate(mid.ddm_parameters.values()):
        moved = (high.theta_ddm[i] - low.theta_ddm[i]) / (2 * step)
        assert value.sd_gain == pytest.approx(SD * abs(moved), rel=1e-2, abs=1e-5 * value.value)


@pytest.mark.parametrize("sd", [-0.1, 1.0, np.nan, np.inf])
def test_impossible_deviations_are_refused(sd: float) -> None:
    with pytest.raises(ModelError, match="drive gain"):
        Drive(gain=1.0, relative_sd=sd)


def leaves_out(error: EstimationError) -> list[str]:
    """The parameters that an error advises to leave out."""
    assert ("reversals=" in str(error)) == ("without the samples near" in str(error))
    return re.findall(r"leave-out (\w+)", str(error))


@pytest.mark.parametrize("speed", [1e-3, 3e-3, 5e-3])
@pytest.mark.parametrize("method", ["idm-ls", "ddm-ls", "idm-iv", "ddm-iv"])
def test_friction_at_speeds_that_no_row_has_is_named(speed: float, method: str) -> None:
    axis = build(with_stribeck(speed))
    with refuses(
        "not-shown",
        says=r"Fs would have to be .* N where it acts most, in a record whose largest is 15\d N\.",
    ) as refused:
        identify(axis, twin_record(axis), methods=method)
    assert (refused.value.code, leaves_out(refused.value)) == ("not-shown", ["Fs"])


@pytest.mark.slow
@pytest.mark.parametrize(("nominal", "place"), [(10.0, 0.15), (10.0, 0.09), (0.0, 0.15)])
def test_a_place_that_the_axis_never_reaches_is_named(nominal: float, place: float) -> None:
    axis = build(with_bump(place, nominal))
    with refuses("not-shown", says=r"Fb would have to be .* make a parameter in N about"):
        identify(axis, twin_record(axis))


@pytest.mark.slow
@pytest.mark.parametrize(("place", "seed"), [(0.07, 0), (0.075, 1), (0.075, 2)])
def test_a_place_that_is_hardly_reached_is_never_believed(place: float, seed: int) -> None:
    """Its part of the force is below 1 %, and yet nothing is known of it."""
    axis = build(with_bump(place))
    result = identify(axis, twin_record(axis, seed=seed), methods=["idm-ls", "idm-iv"])
    (check,) = (c for c in result.verdict if c.name == "precision")
    assert check.status == "fail"
    assert check.meaning.startswith("Fb is not identified by this record")


@pytest.mark.slow
def test_a_search_keeps_to_speeds_that_the_record_shows() -> None:
    """At a hundredth of the true speed every level of the friction would fit."""
    declared = stribeck_axis()
    small = tuple(replace(p, nominal=1e-3) if p.name == "v" else p for p in declared.parameters)
    axis = build(replace(declared, parameters=small))
    record = twin_record(axis)
    with refuses("no-convergence", says=r"no start of v .* At the first, .*not show s"):
        identify(axis, record, methods="idm-ls")
    found = identify(stribeck_axis(), record, methods="idm-ls")["idm-ls"].parameters
    assert found["s"].value == pytest.approx(TRUTH["s"], rel=0.2)


@pytest.mark.parametrize("name", LIBRARY)
def test_right_models_are_a_hundred_times_from_being_refused(name: str) -> None:
    """Even if each term acted 100 times as strongly somewhere else along the record."""
    axis = build(load_axis(name))
    record = twin_record(axis, seed=1)
    data = FilteredRecord.bind(axis, record, Prefilter.suited(record.period))
    equations = InverseForm(axis).equations(data.signals)
    reach = SignalRanges.of([(data.signals, equations, data.sampling.kept)])
    rows = equations.reduced(data)
    check_visible(
        axis,
        replace(reach, columns=100 * reach.columns),
        rows.regressor,
        rows.left - rows.intercept,
        source="the record",
        without_turns=True,
    )
