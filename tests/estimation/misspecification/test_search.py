"""What a model lacks is named with its size; where it lacks nothing, nothing is."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Parameter,
    Record,
    build,
    fit,
    fix,
    leave_out,
    load_axis,
    load_result,
    newton,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import (
    Drive,
    asymmetric_viscous,
    coulomb,
    periodic_coulomb,
    quadratic,
    spring,
    stribeck,
    viscous,
)
from axisid.estimation.diagnostics.model_error_checks import (
    MissingTerms,
    Outliers,
    RecordedSignals,
    misspecification_check,
)
from axisid.estimation.misspecification import (
    LateSignal,
    MissingTerm,
    Misspecification,
    ScaledSignal,
)
from axisid.estimation.misspecification.hypotheses import Hypothesis
from axisid.estimation.misspecification.search import _tested
from axisid.estimation.verdict_checks import Check, Levels
from axisid.modeling import back_and_forth
from axisid.modeling.quantities import Constant
from axisid.support.arrays import Array
from tests.axes.recorded import AREA, recorded_axis, recorded_values
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

field: Any = import_module("field")

AXIS = load_axis("emps2015")
Q = AXIS.coordinate
PLACED = "friction place"
ADDED: dict[str, tuple[object, float, float]] = {
    "direction": (asymmetric_viscous(20.0, -20.0, Q), 40.0, 0.1),
    "quadratic": (quadratic(1000.0, Q), 1000.0, 0.1),
    "stribeck": (stribeck(8.0, Q, velocity=0.02, exponent=1), 8.0, 0.5),
    "slope": (spring(200.0, Q), 200.0, 0.1),
    "constant": (Constant(5.0, "N", "F0").symbol, 5.0, 0.05),
    PLACED: (periodic_coulomb(2.5, 1.0, Q, period=0.03), np.hypot(2.5, 1.0), 0.1),
}


@cache
def of_plant(kind: str) -> Record:
    """The twin of the paper's axis with a term that its model lacks."""
    return twin_record(replace(AXIS, name="plant", force=AXIS.force + ADDED[kind][0]))


def found(record: Record) -> tuple[Misspecification, ...]:
    """What is found lacking, with least squares alone where the record has no loop."""
    axis = AXIS if record.reference is not None else replace(AXIS, control=None)
    methods = ["idm-ls", "idm-iv"] if axis.control else ["idm-ls"]
    return identify(axis, record, methods=methods).case.lacking


@pytest.mark.slow
@pytest.mark.parametrize("bootstrap", [0, 32])
def test_a_loop_that_follows_by_a_velocity_of_no_record_is_not_searched(bootstrap: int) -> None:
    twin = twin_record(AXIS, seed=1)
    record = Record(time=twin.time, position=twin.position, control=twin.control)
    result = identify(AXIS, record, methods=["idm-ls"], bootstrap=bootstrap)
    said = {c.name: c.meaning for c in result.verdict if c.status == "not evaluated"}
    for name in ("missing terms", "alignment"):
        assert "a velocity that is not in the record" in said[name]
    assert result.belief == "with care"
    low, high = result.preferred.parameters["M"].interval
    assert not bootstrap or low < 100.2 < high


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "has_loop"), [*((k, True) for k in ADDED), ("direction", False), (PLACED, False)]
)
def test_a_term_that_is_missing_is_the_first_that_is_found(kind: str, has_loop: bool) -> None:
    """Without a loop away from reversals."""
    record, (_, size, near) = of_plant(kind), ADDED[kind]
    first = found(record if has_loop else replace(record, reference=None))[0]
    assert first.kind == kind
    assert first.size == pytest.approx(size, rel=near if has_loop else 0.5)
    assert kind != PLACED or first.at == pytest.approx(0.03, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("known", "name", "kind"),
    [
        ("", "Fc", "coulomb"),
        ("", "Fv", "viscous"),
        ("M", "Fc", "coulomb"),
        ("Fc", "Fv", "viscous"),
        ("Fc", "", ""),
    ],
)
@pytest.mark.parametrize("method", ["idm-iv", "didim"])
def test_friction_that_is_not_declared_is_told_as_what_it_is(
    twin: Record, known: str, name: str, kind: str, method: str
) -> None:
    """Of an axis with a known value too."""
    truth = twin.provenance.truth
    declared = leave_out(fix(AXIS, **{n: truth[n] for n in (known,) if n}), *filter(None, [name]))
    result = identify(declared, twin, methods=[method])
    assert [lack.kind for lack in result.case.lacking[:1]] == [*filter(None, [kind])]
    for first in result.case.lacking[:1]:
        assert first.size == pytest.approx(truth[name], rel=0.1)
        surer = replace(result.case, levels=Levels(level=first.p_value / 1e9))
        assert not any(lack.kind == kind for lack in surer.lacking)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["direction", "constant"])
def test_values_with_the_missing_term_are_the_machines(kind: str) -> None:
    """Friction that differs between directions has one value forward and one backward."""
    result, truth = identify(build(AXIS), of_plant(kind)), dict(AXIS.experiment.truth)
    halves = {"Fv": (20.0, -20.0)} if kind == "direction" else {}
    revised = result.diagnosis.with_missing_terms
    assert {*revised} == {*truth}
    for name, values in revised.items():
        expected = [truth[name] + each for each in halves.get(name, (0.0,))]
        deviation = result.preferred.parameters[name].deviation
        assert values == pytest.approx(expected, abs=4 * deviation)


def _limited(limit: float, commanded: float = 0.5) -> tuple[GeneratedAxis, Record]:
    """A rotor whose drive gives no more than a limit, which its declaration does not have."""
    q = Coordinate("q", unit="rad")
    J, b, c = (Parameter(*each) for each in (("J", "kg*m^2"), ("b", "N*m*s/rad"), ("c", "N*m")))
    drive, resistance = Drive(gain=1.0, unit="N*m"), (viscous(b, q), coulomb(c, q))
    axis = newton(
        "rotor", coordinate=q, parameters=(J, b, c), inertia=J, resistance=resistance, drive=drive
    )
    levels = commanded * np.array([1.0, -1.0, 0.3, -0.3, 0.6, -0.6])
    control = np.repeat(np.tile(levels, 6), 80)
    position, at, speed = np.empty(len(control)), 0.0, 0.0
    for k, u in enumerate(control):
        position[k] = at
        for _ in range(10):
            force = min(max(u, -limit), limit) - 1e-3 * speed - 0.03 * np.sign(speed or u)
            at, speed = at + 1e-4 * speed, speed + 1e-4 * force / 2e-3
    return build(axis), Record(
        time=1e-3 * np.arange(len(control)), position=position, control=control
    )


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "percent"), [(0.25, 30.0), (0.4, 0.0), (9.0, 0.0)])
def test_a_limit_that_the_drive_has_and_is_not_declared_is_named_with_its_level(
    limit: float, percent: float
) -> None:
    axis, record = _limited(limit)
    result = identify(axis, record)
    if limit > 1:
        assert not result.case.lacking
        return
    first = result.case.lacking[0]
    assert first.kind == "saturation"
    assert first.at == pytest.approx(limit, rel=0.05)
    moved = checks_of(result).get("moved parameters")
    assert (result.belief == "not believed") == (moved is not None) == (percent > 0)
    assert (moved.figure if moved else 0.0) >= percent


@pytest.mark.parametrize("given", [0, 1, 2.0, -0.1, math.nan, "0.01", True, None])
@pytest.mark.parametrize("name", ["level", "least_share"])
@pytest.mark.parametrize("by", [identify, fit])
def test_levels_are_shares(twin: Record, by: Callable[..., object], name: str, given: Any) -> None:
    with refuses("method", says=f"the {name.replace('_', ' ')} is"):
        by(AXIS, twin, **{name: given})


@pytest.mark.slow
def test_levels_are_those_of_the_checks_and_of_the_file(twin: Record, tmp_path: Path) -> None:
    asked = {"level": 0.05, "least_share": 0.02}
    result = identify(leave_out(AXIS, "Fc"), twin, methods=["idm-ls"], **asked)
    saved = load_result(result.save(tmp_path / "result.json"))
    assert saved.levels == result.levels == Levels(**asked)
    missing = checks_of(saved)["missing terms"]
    assert (missing.status, missing.threshold) == ("fail", 2.0)
    assert "5 % over all" in missing.source
    document = result.to_dict()
    assert saved.belief == document["belief"] == result.belief
    del document["levels"], document["belief"]  # as earlier versions wrote it
    (tmp_path / "earlier.json").write_text(json.dumps(document), encoding="utf-8")
    assert load_result(tmp_path / "earlier.json").levels == Levels()


@pytest.mark.slow
def test_a_delay_is_found_and_said_by_one_check() -> None:
    late = replace(AXIS, name="late", drive=replace(AXIS.drive, delay=1e-3))
    result = identify(AXIS, twin_record(late), methods=["idm-ls", "idm-iv"])
    first = result.case.lacking[0]
    assert (first.kind, first.size) == ("delay", pytest.approx(1e-3, rel=0.3))
    checks = checks_of(result)
    assert checks["alignment"].status == "fail"
    missing = finding_of(checks["missing terms"], MissingTerms).found
    assert "delay" not in [each.term.kind for each in missing if isinstance(each, MissingTerm)]


@pytest.mark.slow
def test_a_feed_forward_that_is_not_in_the_log_is_found() -> None:
    case = field.wrong(1)["feed-forward out of the log; P-PI"]
    result = identify(case.axis, *case.records(1, 1), methods="didim")
    check = checks_of(result)["missing terms"]
    assert check.status == "fail"
    (first, *_) = finding_of(check, MissingTerms).found
    assert isinstance(first, MissingTerm)
    assert first.term.kind == "delay"
    assert first.size < 0


@pytest.mark.parametrize(
    ("name", "method"),
    [
        *(("emps2015", method) for method in ("idm-ls", "idm-iv", "ddm-ls")),
        *(
            pytest.param(name, "idm-iv", marks=pytest.mark.slow)
            for name in ("pendulum", "belt_axis", "rotary_table", "crank")
        ),
    ],
)
def test_a_right_model_lacks_nothing(name: str, method: str) -> None:
    axis = build(load_axis(name))
    assert identify(axis, twin_record(axis, seed=1), methods=[method]).case.lacking == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("term", "kind", "parameter", "size"),
    [("acceleration", "change", "M", 10.0), ("direction", "drift", "Fc", -6.0)],
)
def test_a_parameter_that_changes_is_found_with_how_much_and_when(
    emps2015: GeneratedAxis, twin: Record, term: str, kind: str, parameter: str, size: float
) -> None:
    """Of a record with a force column that has so much of a term more, and without a loop."""
    part = np.linspace(0.0, 1.0, len(twin))
    course = size * (part if kind == "drift" else part >= 0.6)
    data = identify(emps2015, twin, methods=["idm-ls"]).data
    force = data.force + course * getattr(data.signals, term)
    first = found(replace(twin, force=force, reference=None))[0]
    assert (first.kind, first.parameter) == (kind, parameter)
    assert first.size == pytest.approx(size, rel=0.1)
    assert first.before == pytest.approx(twin.provenance.truth[parameter], rel=0.05)
    assert math.isnan(first.at) or first.at == pytest.approx(0.6 * twin.time[-1], abs=0.5)


def _coarse(name: str, spikes: int = 0) -> Record:
    """The twin with a measured velocity in steps of 2 % of its size, and single samples far off."""
    record = twin_record(build(load_axis(name)), velocity_noise=0.0)
    exact = np.asarray(record.velocity)
    step = 0.02 * float(np.sqrt(np.mean(exact**2)))
    coarse = step * np.round(exact / step)
    coarse[3000 : 3000 + 500 * spikes : 500] += 40 * step
    return replace(record, velocity=coarse)


def _outliers(name: str, record: Record, **options: str) -> Check:
    result = identify(build(load_axis(name)), record, methods=["idm-iv"], **options)
    return checks_of(result)["outliers"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "pendulum", "rotary_table"])
def test_outliers_are_told_with_their_sample_and_steps_of_a_velocity_are_none(name: str) -> None:
    assert _outliers(name, _coarse(name)).status == "pass"
    if name == "emps":
        record = _coarse(name, spikes=3)
        check = _outliers(name, record)
        assert check.status == "fail"
        samples = [each.sample for each in finding_of(check, Outliers).found]
        assert samples == [3001, 3501, 4001]
        assert _outliers(name, record, loss="huber").status != "fail"


@cache
def _axis(kind: str, *, known: bool = False) -> GeneratedAxis:
    """The axis of a signal; with a known area its scale can be told."""
    axis = recorded_axis(kind)
    if not known:
        return build(axis)
    area, experiment = Constant(1e-3, "m^2", "area").symbol, axis.experiment
    truth = {name: value for name, value in experiment.truth.items() if name != "A"}
    return build(
        replace(
            axis,
            parameters=tuple(p for p in axis.parameters if p.name != "A"),
            force=axis.force.subs(AREA.symbol, area),
            experiment=replace(experiment, truth=truth),
        )
    )


def _check(kind: str, *, known: bool = False, late: int = 0, factor: float = 1.0) -> Check:
    """Of the twin with its signal late and scaled."""
    axis = _axis(kind, known=known)
    record = twin_record(axis, signals=recorded_values(kind, 0), seed=1)
    rows = np.clip(np.arange(len(record)) - late, 0, len(record) - 1)
    signals = {name: factor * values[rows] for name, values in record.signals.items()}
    result = identify(axis, replace(record, signals=signals), methods=["idm-iv"])
    return checks_of(result)["recorded signals"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "known", "changed", "unit"),
    [
        *((kind, known, {}, "") for kind, known in (("pressure", False), ("supply", False))),
        ("pressure", True, {}, ""),
        ("pressure", True, {"factor": 1e-5}, "bar"),
        ("pressure", True, {"factor": 1e-3}, "kPa"),
        ("pressure", True, {"factor": 1.05}, None),
    ],
)
def test_a_right_signal_passes_and_one_in_another_unit_is_told_where_its_coefficient_is_known(
    kind: str, known: bool, changed: dict[str, float], unit: str | None
) -> None:
    check = _check(kind, known=known, **changed)  # type: ignore[arg-type]
    assert check.status == ("fail" if changed else "pass")
    found = finding_of(check, RecordedSignals).found
    if not changed:
        assert found == ()
        return
    first = found[0]
    assert isinstance(first, ScaledSignal)
    assert (first.signal, first.likely_unit) == ("pressure", unit)
    assert first.factor == pytest.approx(1 / changed["factor"], rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pressure", "supply"])
@pytest.mark.parametrize("samples", [100, -100])
def test_a_late_signal_is_told_with_its_delay(kind: str, samples: int) -> None:
    check = _check(kind, late=samples)
    assert check.status == "fail"
    first = finding_of(check, RecordedSignals).found[0]
    assert isinstance(first, LateSignal)
    assert first.samples == pytest.approx(samples, abs=1.0)
    assert first.shift is not None
    assert first.shift.role == kind
    assert first.shift.samples == pytest.approx(-samples, abs=1.0)


class _Powers:
    """Scores whose test takes most at one of the places of a delay."""

    force = np.array([-1.0, 1.0])

    def __init__(self, powers: Array) -> None:
        self._powers = powers

    def test(self, _: Array) -> SimpleNamespace:
        ones = np.ones(len(self._powers))
        return SimpleNamespace(
            values=ones[:, None],
            powers=self._powers,
            whole_powers=self._powers,
            p_values=1e-9 * ones,
        )

    def moved_by(self, _: Array, __: Array) -> Array:
        return np.ones(1)


@pytest.mark.parametrize(("most", "is_end"), [(0, True), (1, False), (2, False), (3, True)])
def test_a_delay_at_the_end_of_its_range_is_no_number_to_move_a_signal_by(
    most: int, is_end: bool
) -> None:
    hypothesis = Hypothesis(
        kind="late signal",
        parameter="pressure",
        columns=lambda places: np.ones((2, len(places), 1)),
        places=np.array([-250.0, -1.0, 1.0, 250.0]),
        is_whole=True,
    )
    scores: Any = _Powers(np.where(np.arange(4) == most, 4.0, 1.0))
    tested = _tested(scores, hypothesis, np.ones(1), 0.01)
    assert tested.at_the_end is is_end
    lack = Misspecification(
        kind="late signal",
        parameter="pressure",
        values=(tested.at,),
        deviation=0.1,
        before=0.0,
        at=tested.at,
        share=0.1,
        own_share=0.1,
        p_value=tested.p_value,
        at_the_end=tested.at_the_end,
    )
    axis, time = recorded_axis("pressure"), np.arange(3.0)
    record = Record(time=time, position=time, control=time, signals={"pressure": time})
    check = misspecification_check([lack], "recorded signals", build(axis, native=False), record)
    assert isinstance(check, Check)
    assert check.status == "fail"
    (late,) = finding_of(check, RecordedSignals).found
    assert isinstance(late, LateSignal)
    assert late.at_the_end is (late.shift is None) is is_end


@pytest.mark.slow
def test_a_record_of_one_stroke_is_searched_and_its_noise_is_measured() -> None:
    """Of 40 rows in motion, not half of which were once enough for neither."""
    moves = back_and_forth(speeds=(0.15,), acceleration=3.0, seconds=0.25, repeat=1)
    short = replace(AXIS, experiment=replace(AXIS.experiment, moves=moves))
    result = identify(short, twin_record(short), methods=["idm-iv"])
    assert 24 <= len(result.preferred.y) < 80
    assert result.preferred.inference.chains
    assert checks_of(result)["missing terms"].status == "pass"
