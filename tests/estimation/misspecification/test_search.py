"""What a model lacks is named with its size; where it lacks nothing, nothing is."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Record,
    build,
    compare,
    fit,
    fix,
    identify,
    leave_out,
    load_axis,
    load_result,
    monte_carlo,
    sweep,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.elements import asymmetric_viscous, periodic_coulomb, quadratic, spring, stribeck
from axisid.estimation.checks import DEFAULT_LEVELS, Levels
from axisid.estimation.misspecification import Misspecification, find_misspecification, scores_at
from axisid.support.arrays import Array
from tests.refusals import refuses

field: Any = import_module("field")

AXIS = load_axis("emps2015")
Q = AXIS.coordinate
ADDED: dict[str, tuple[object, tuple[float, ...], float]] = {
    "direction": (asymmetric_viscous(20.0, -20.0, Q), (40.0,), 0.1),
    "quadratic": (quadratic(1000.0, Q), (1000.0,), 0.1),
    "stribeck": (stribeck(8.0, Q, velocity=0.02, exponent=1), (8.0,), 0.5),
    "slope": (spring(200.0, Q), (200.0,), 0.1),
    "friction place": (periodic_coulomb(2.5, 1.0, Q, period=0.03), (), 0.1),
}


@cache
def of_plant(kind: str) -> Record:
    """The twin of the paper's axis with a term that its model lacks."""
    force = ADDED[kind][0]
    return twin_record(replace(AXIS, name="plant", force=AXIS.force + force))


def _lacking(
    result: Identification, records: int = 1, levels: Levels = DEFAULT_LEVELS
) -> tuple[Misspecification, ...]:
    half = [np.ptp(value.interval) / 2 for value in result.preferred.parameters.values()]
    return find_misspecification(
        scores_at(result.data, result.preferred), np.array(half), records, levels
    )


def found(
    record: Record, methods: Sequence[str] = ("idm-ls", "idm-iv")
) -> tuple[Misspecification, ...]:
    """What is found lacking, with least squares alone where the record has no loop."""
    without_loop = record.reference is None
    axis = replace(AXIS, control=None) if without_loop else AXIS
    result = identify(axis, record, methods=["idm-ls"] if without_loop else methods)
    return _lacking(result)


@pytest.mark.slow
@pytest.mark.parametrize("bootstrap", [0, 32])
def test_a_loop_that_follows_by_a_velocity_of_no_record_is_not_searched(bootstrap: int) -> None:
    twin = twin_record(AXIS, seed=1)
    record = Record(time=twin.time, position=twin.position, control=twin.control)
    result = identify(AXIS, record, methods=["idm-ls"], bootstrap=bootstrap)
    checks = {check.name: check for check in result.verdict}
    assert checks["missing terms"].status == checks["alignment"].status == "not evaluated"
    assert "a velocity that is in no record" in checks["missing terms"].meaning
    assert result.belief == "believed"
    if bootstrap:
        low, high = result.preferred.parameters["M"].interval
        assert low < 100.2 < high


@pytest.mark.slow
@pytest.mark.parametrize("kind", ADDED)
def test_a_term_that_is_missing_is_the_first_that_is_found(kind: str) -> None:
    first, _, values, near = (found(of_plant(kind))[0], *ADDED[kind])
    assert first.kind == kind
    if values:
        assert first.values == pytest.approx(values, rel=near)
    else:
        assert float(np.hypot(*first.values)) == pytest.approx(np.hypot(2.5, 1.0), rel=near)
        assert first.at == pytest.approx(0.03, rel=0.02)


@pytest.mark.parametrize(("name", "kind"), [("Fc", "coulomb"), ("Fv", "viscous")])
@pytest.mark.parametrize("method", ["idm-iv", "didim"])
def test_friction_that_is_not_declared_is_told_as_what_it_is(
    twin: Record, name: str, kind: str, method: str
) -> None:
    result = identify(leave_out(AXIS, name), twin, methods=[method])
    lacks = _lacking(result)
    assert lacks[0].kind == kind
    assert lacks[0].values == pytest.approx([twin.provenance.truth[name]], rel=0.1)
    surer = Levels(level=lacks[0].p_value / 1e9)
    assert not any(lack.kind == kind for lack in _lacking(result, 1, surer))


@pytest.mark.parametrize("given", [0, 1, 2.0, -0.1, math.nan, "0.01", True, None])
@pytest.mark.parametrize("name", ["level", "least_share"])
def test_levels_are_shares(twin: Record, name: str, given: Any) -> None:
    with refuses("method", says=f"the {name.replace('_', ' ')} is"):
        identify(AXIS, twin, **{name: given})
    with refuses("method"):
        fit(AXIS, twin, **{name: given})


def test_levels_are_those_of_the_checks_and_of_the_file(twin: Record, tmp_path: Path) -> None:
    asked = {"level": 0.05, "least_share": 0.02}
    result = identify(leave_out(AXIS, "Fc"), twin, methods=["idm-ls"], **asked)
    saved = load_result(result.save(tmp_path / "result.json"))
    assert saved.levels == result.levels == Levels(**asked)
    (missing,) = (check for check in saved.checks if check.name == "missing terms")
    assert (missing.status, missing.threshold) == ("fail", 2.0)
    assert "5 % over all" in missing.source
    assert saved.belief == result.belief
    document = result.to_dict()
    assert document["belief"] == result.belief
    del document["levels"], document["belief"]  # as earlier versions wrote it
    (tmp_path / "earlier.json").write_text(json.dumps(document), encoding="utf-8")
    assert load_result(tmp_path / "earlier.json").levels == Levels()


@pytest.mark.parametrize(
    ("known", "name", "kind"), [("M", "Fc", "coulomb"), ("Fc", "Fv", "viscous"), ("Fc", "", "")]
)
def test_of_an_axis_with_a_known_value_the_friction_that_is_not_declared_is_told(
    twin: Record, known: str, name: str, kind: str
) -> None:
    declared = fix(AXIS, **{known: twin.provenance.truth[known]})
    result = identify(leave_out(declared, name) if name else declared, twin, methods=["idm-iv"])
    lacks = _lacking(result)
    assert [lack.kind for lack in lacks[:1]] == ([kind] if kind else [])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["direction", "friction place"])
def test_without_a_loop_a_term_is_found_away_from_reversals(kind: str) -> None:
    record = replace(of_plant(kind), reference=None)
    assert found(record)[0].kind == kind


@pytest.mark.slow
def test_a_delay_is_found_and_said_by_one_check() -> None:
    late = replace(AXIS, name="late", drive=replace(AXIS.drive, delay=1e-3))
    result = identify(AXIS, twin_record(late), methods=["idm-ls", "idm-iv"])
    lacks = _lacking(result)
    assert lacks[0].kind == "delay"
    assert lacks[0].values == pytest.approx((1e-3,), rel=0.3)
    failing = {check.name: check.meaning for check in result.verdict if check.status == "fail"}
    assert "drive's delay" in failing["alignment"]
    assert "delay" not in failing.get("missing terms", "")


@pytest.mark.slow
def test_a_feed_forward_that_is_not_in_the_log_is_found() -> None:
    case = field.wrong(1)["feed-forward out of the log; P-PI"]
    (record,) = case.records(1, 1)
    result = identify(case.axis, record, methods="didim")
    (check,) = (each for each in result.verdict if each.name == "missing terms")
    assert "feed-forward" in check.meaning


@pytest.mark.parametrize("methods", [["idm-ls"], ["idm-iv"]])
def test_a_right_model_lacks_nothing(twin: Record, methods: list[str]) -> None:
    assert found(twin, methods) == ()


def with_more_force(axis: GeneratedAxis, record: Record, term: str, values: Array) -> Record:
    """The record with a force column that has so much of a term more, and without a loop."""
    data = identify(axis, record, methods=["idm-ls"]).data
    more = values * getattr(data.signals, term)
    return replace(record, force=data.force + more, reference=None)


@pytest.mark.slow
def test_a_mass_that_changes_is_found_with_its_time(emps2015: GeneratedAxis, twin: Record) -> None:
    late = np.where(np.arange(len(twin)) >= 0.6 * len(twin), 10.0, 0.0)
    change = found(with_more_force(emps2015, twin, "acceleration", late))[0]
    assert (change.kind, change.parameter) == ("change", "M")
    assert change.values == pytest.approx((10.0,), rel=0.05)
    assert change.at == pytest.approx(0.6 * len(twin) * twin.period, abs=0.5)


@pytest.mark.slow
def test_a_friction_that_drifts_is_found_as_a_drift(emps2015: GeneratedAxis, twin: Record) -> None:
    falls = np.linspace(0.0, -6.0, len(twin))
    first = found(with_more_force(emps2015, twin, "direction", falls))[0]
    assert (first.kind, first.parameter) == ("drift", "Fc")
    assert first.values == pytest.approx((-6.0,), rel=0.1)
    assert first.before == pytest.approx(25.0, rel=0.05)


@pytest.mark.slow
def test_an_offset_that_is_not_declared_is_told_with_its_size() -> None:
    offset = Parameter("F0", "N")
    experiment = AXIS.experiment
    plant = replace(
        AXIS,
        name="plant",
        parameters=(*AXIS.parameters, offset),
        force=AXIS.force + offset.symbol,
        experiment=replace(experiment, truth={**experiment.truth, "F0": 5.0}),
    )
    first = found(twin_record(plant))[0]
    assert first.kind == "constant"
    assert first.values == pytest.approx((5.0,), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps2015", "pendulum", "belt_axis", "rotary_table", "crank"])
def test_nothing_is_lacking_in_right_models_of_other_axes(name: str) -> None:
    axis = build(load_axis(name))
    result = identify(axis, twin_record(axis, seed=1), methods=["idm-iv"])
    assert _lacking(result) == ()


def test_what_is_judged_does_not_matter(emps2015: GeneratedAxis, twin: Record) -> None:
    """The rows of an inverse model tell of a direct one too."""
    result = identify(emps2015, twin, methods=["ddm-ls"])
    assert _lacking(result) == ()


@pytest.mark.parametrize("judge", [identify, fit, sweep, compare, monte_carlo])
def test_whatever_judges_takes_levels(judge: Callable[..., object]) -> None:
    assert {*signature(judge).parameters} >= {"level", "least_share"}
