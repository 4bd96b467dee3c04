"""What a record does not show of a model: named before it is solved, by every method."""

from dataclasses import replace

import pytest

from axisid import (
    EstimationError,
    Prefilter,
    Record,
    build,
    identify,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics import conclusion
from axisid.estimation.problems.visibility import Reach, check_visible
from axisid.estimation.regression.forms import InverseForm
from axisid.estimation.signals.filtered_record import FilteredRecord
from axisid.modeling import LIBRARY
from tests.axes.unseen import with_bump, with_stribeck
from tests.estimation.methods.test_partially_linear import TRUTH, stribeck_axis
from tests.refusals import refuses


def reach_of(axis: GeneratedAxis, record: Record) -> Reach:
    data = FilteredRecord.bind(axis, record, Prefilter.suited(record.period))
    return Reach.of([(data.signals, InverseForm(axis).equations(data.signals), data.kept)])


def leaves_out(error: EstimationError) -> list[str]:
    """The parameters that the remedy of an error leaves out."""
    others = {setting.name for setting in error.remedy.settings} - {"leave-out"}
    assert others == ({"reversals"} if "without the samples near" in str(error) else set())
    return [s.value for s in error.remedy.settings if s.name == "leave-out"]


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
@pytest.mark.parametrize("place", [0.07, 0.075])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_place_that_is_hardly_reached_is_never_believed(place: float, seed: int) -> None:
    """Its part of the force is below 1 %, and yet nothing is known of it."""
    axis = build(with_bump(place))
    result = identify(axis, twin_record(axis, seed=seed), methods=["idm-ls", "idm-iv"])
    (check,) = (c for c in result.verdict if c.name == "precision")
    assert check.status == "fail"
    assert check.meaning.startswith("Fb is not identified by this record")


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.008, 0.01])
def test_friction_in_few_slow_rows_is_never_believed(speed: float) -> None:
    axis = build(with_stribeck(speed))
    for seed in range(3):
        try:
            result = identify(axis, twin_record(axis, seed=seed), methods=["idm-ls"])
        except EstimationError as refused:
            assert "does not show Fs" in str(refused)
        else:
            assert not conclusion(result.verdict).startswith("Nothing")


@pytest.mark.slow
def test_without_it_the_others_are_found_and_what_stands_for_it_is_told() -> None:
    axis = with_stribeck(1e-3)
    record = twin_record(build(axis))
    result = identify(leave_out(axis, "Fs"), record)
    assert result["idm-iv"].physical == pytest.approx([100.2, 236.9, 24.8], rel=4e-3)
    assert conclusion(result.verdict).startswith("Nothing")
    assert "left out   Fs = 0 N" in result.summary()
    assert result.to_dict()["left_out"] == {"Fs": 0.0}


@pytest.mark.slow
def test_a_search_keeps_to_speeds_that_the_record_shows() -> None:
    """At a hundredth of the true speed every level of the friction would fit."""
    declared = stribeck_axis()
    small = tuple(replace(p, nominal=1e-3) if p.name == "v" else p for p in declared.parameters)
    axis = build(replace(declared, parameters=small))
    record = twin_record(axis)
    with refuses("failed-starts", says=r"no start of v .* At the first, .*not show s"):
        identify(axis, record, methods="idm-ls")
    found = identify(stribeck_axis(), record, methods="idm-ls")["idm-ls"].parameters
    assert found["s"].value == pytest.approx(TRUTH["s"], rel=0.2)


@pytest.mark.parametrize("name", LIBRARY)
def test_right_models_are_a_hundred_times_from_being_refused(name: str) -> None:
    """Even if each term acted 100 times as strongly somewhere else along the record."""
    axis = build(load_axis(name))
    for seed in range(3):
        record = twin_record(axis, seed=seed)
        reach = reach_of(axis, record)
        stretched = replace(reach, columns=100 * reach.columns)
        data = FilteredRecord.bind(axis, record, Prefilter.suited(record.period))
        rows = InverseForm(axis).equations(data.signals).reduced(data)
        check_visible(
            axis,
            stretched,
            rows.regressor,
            rows.left - rows.intercept,
            rows=len(rows.left),
            source="the record",
            without_turns=True,
        )
