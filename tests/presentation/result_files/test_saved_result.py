"""A result that is read back has the numbers, text and figures of the one that was written.

What is saved is loaded and saved again the same, its drive with it.

What is shown and saved of recorded signals: page of the axis, JSON, summary, figures, frames.
"""

import json
import math
import pickle
import warnings
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.figure import Figure

from axisid import (
    AxisidError,
    DataError,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    compare_results,
    derive,
    export,
    fit,
    fix,
    leave_out,
    load_axis,
    load_result,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import Drive
from axisid.estimation import OutputFit, validate_fit
from axisid.estimation.findings import ReadFinding
from axisid.estimation.identification import DriveTime
from axisid.modeling.declaration import Axis
from axisid.presentation.documents.axis_page import FORMATS, axis_page
from axisid.presentation.plots.result import record_plot
from axisid.presentation.result_files import (
    SavedFitValidation,
    SavedIdentification,
    SavedOutputFit,
)
from axisid.presentation.result_files.file import refuse_differences
from benchmarks.random_axes import random_axis
from tests.axes.drives import braked
from tests.axes.recorded import recorded_axis, recorded_values
from tests.files import text_file
from tests.refusals import refuses
from tests.unjudged import identify

ARM = """\
name = "arm"
coordinate = { name = "q", unit = "rad" }
drive = { gain = 0.5, unit = "A", limit = 20.0, relative_sd = 0.01 }
control = { law = "cascade_pd_averaged", kp = 20.0, kv = 12.0, period = 1e-3 }
parameters.m = { unit = "kg", nominal = 0.3, known = 0.24, known_sd = 0.001 }
parameters.l = { unit = "m", nominal = 0.5 }
parameters.fv = { unit = "N m/(rad/s)" }

[newton]
inertia = "m*l**2"
resistance = ["fv*dq", "m*G*l*sin(q)"]

[experiment]
back_and_forth = { speeds = [1.0, 3.0], acceleration = 20.0, seconds = 0.3, repeat = 1 }
truth = { m = 0.24, l = 0.5, fv = 0.02 }
position_noise = 1e-6
"""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A result and what was read of its file."""

    axis: Axis
    result: Identification
    file: Path
    saved: SavedIdentification


def _axis(name: str, folder: Path) -> Axis:
    if name in ("arm", "random"):
        file = folder / f"{name}.toml"
        toml = ARM if name == "arm" else random_axis(np.random.default_rng(5)).toml
        file.write_text(toml, encoding="utf-8")
        return load_axis(file)
    if name == "braked":  # its own motion takes from the force: not all moves with the gain
        return braked(load_axis("emps2015"), relative_sd=0.005)
    return leave_out(_uncertain_gain(), "Fc") if name == "left out" else load_axis(name)


def _uncertain_gain() -> Axis:
    return replace(load_axis("emps2015"), drive=Drive(gain=35.0, unit="V", relative_sd=0.005))


@pytest.fixture(scope="module", params=["emps2015", "arm", "left out", "random", "braked"])
def pair(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Pair:
    folder = tmp_path_factory.mktemp("saved")
    axis = _axis(request.param, folder)
    methods = ["idm-ls", "idm-iv"] if request.param in ("random", "braked") else None
    chosen: Any = "robust" if request.param == "left out" else "hac"
    result = identify(axis, twin_record(axis), methods=methods, covariance=chosen)
    file = result.save(folder / "result.json", draws=20)
    # What `leave_out` left out the file says.
    given = {"emps2015": None, "left out": _uncertain_gain()}.get(request.param, axis)
    return Pair(axis=axis, result=result, file=file, saved=load_result(file, given))


@pytest.mark.slow
def test_text_pages_and_data_are_those_of_the_live_result(pair: Pair) -> None:
    saved, result = pair.saved, pair.result
    assert saved.summary() == str(saved) == result.summary()
    assert saved.summary(20, full=True) == result.summary(20, full=True)
    assert saved._repr_html_() == result._repr_html_()
    assert saved.to_dict() == result.to_dict(20)
    for read, live in zip(saved.verdict, result.verdict, strict=True):
        changes = {
            name: None
            for name in ("figure", "p_value")
            if not math.isfinite(getattr(live, name) or 0.0)
        }
        assert read == replace(live, **changes, finding=read.finding)
        assert read.meaning == live.meaning
        assert isinstance(read.finding, ReadFinding)
        assert read.finding.data["kind"] == type(live.finding).__name__
    for method in result:
        assert saved[method]._repr_html_() == result[method]._repr_html_()
        assert {**saved[method].to_dict(), "drawn": None, "physical": None} == {
            **result[method].to_dict(),
            "drawn": None,
            "physical": None,
        }


@pytest.mark.slow
def test_functions_of_the_parameters_are_those_of_the_live_estimate(pair: Pair) -> None:
    for method in pair.result:
        live, read = pair.result[method], pair.saved[method]
        names = [q.name for q in live.quantities]
        first, last = names[0], names[-1]
        for function in (first, f"{first}/{last}", f"{first}**2", f"sqrt(abs({last}))"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                wanted, found = live.derive(function), read.derive(function)
            assert found.unit == wanted.unit
            every = ("value", "sd", "sd_robust", "sd_hac", "interval", "filter_bias", "sd_gain")
            rounding = 1e-12 * abs(wanted.value)  # of what a quotient does not move by
            for name in every:
                assert getattr(found, name) == pytest.approx(
                    getattr(wanted, name), rel=1e-12, abs=rounding * (name == "sd_gain")
                ), (function, name)


@pytest.mark.slow
def test_an_axis_with_other_fixed_values_is_refused(tmp_path: Path) -> None:
    axis = _axis("arm", tmp_path)
    result = identify(axis, twin_record(axis), methods="idm-ls")
    file = result.save(tmp_path / "result.json")
    for other, said in (
        (fix(axis, m=0.25), r"m fixed at 0\.24 \+- 0\.001, but .* fixed at 0\.25"),
        (fix(axis, m=(0.24, 0.002)), r"fixed at 0\.24 \+- 0\.002\."),
        (fix(axis, l=0.5), r"with l free, but .* fixed at 0\.5\."),
    ):
        with refuses("result-file", says=said):
            load_result(file, other)
        with refuses("result-file", says=said):
            export(file, "csv", axis=other)
    free = replace(
        axis, parameters=tuple(replace(p, known=None, known_sd=0.0) for p in axis.parameters)
    )
    assert load_result(file, free).own_axis == axis, "the file says what was fixed"


@pytest.mark.slow
def test_it_is_exported_validated_and_compared_as_the_live_result(pair: Pair) -> None:
    for target in ("c", "json", "csv", "toml", "latex"):
        assert export(pair.saved, target) == export(pair.result, target)
    other = twin_record(pair.axis, seed=7)
    live, read = validate(pair.result, other), pair.saved.validate(other)
    assert read.summary() == live.summary() == validate(pair.saved, other).summary()
    both = compare_results(pair.result, pair.saved)
    assert all(d.difference == 0 for d in both.differences)
    alone = (*both.alone.first, *both.alone.second)
    assert (both.settings, both.checks, alone) == ({}, {}, ())
    assert compare_results(pair.file, pair.result).differences == both.differences


@pytest.mark.slow
def test_figures_whose_data_the_file_holds_are_drawn(pair: Pair) -> None:
    assert isinstance(pair.saved.plot("autocorrelation"), Figure)
    with refuses("figure", says="'force'"):
        pair.saved.plot("force")
    if "idm-iv" in pair.saved:
        assert isinstance(pair.saved["idm-iv"].plot("convergence"), Figure)
    with refuses("figure", says="is not iterative"):
        pair.saved.plot("convergence", method="idm-ls")
    with refuses("result", says="'ols'"):
        pair.saved["ols"]


def test_without_its_axis_the_rest_asks_for_it_and_another_is_refused(pair: Pair) -> None:
    alone = replace(pair.saved, declared=None)
    lines = [a.split()[1:] for a in alone.summary().splitlines() if a.startswith(("axis", "left"))]
    assert lines[0] == [pair.axis.name]
    wanted = [line for line in pair.result.summary().splitlines() if not line.startswith("axis ")]
    there = {*alone.summary().splitlines()}
    missing = [line for line in wanted if line not in there]
    if pair.axis.drive.is_gain:  # another force is told by the axis alone
        assert all(line.startswith(("left out", "truth", "         ")) for line in missing), missing
    assert alone.preferred.derive(
        pair.axis.parameters[-1].name if pair.saved.physical == {} else "1"
    )
    with refuses("result-file"):
        export(alone)
    with refuses("result-file"):
        alone.validate(twin_record(pair.axis))
    assert pickle.loads(pickle.dumps(alone)).summary() == alone.summary()  # noqa: S301
    for saved in (pair.file, pair.saved):
        with refuses("result-file"):
            load_result(saved, "emps")
    assert load_result(pair.saved) is pair.saved


def test_draws_are_those_that_were_written(pair: Pair) -> None:
    estimate = pair.saved.preferred
    name = estimate.quantities[0].name
    assert estimate.propagate(name, draws=20) == pair.result.preferred.propagate(name, draws=20)
    assert estimate.propagate(name) == estimate.propagate(name, draws=20)
    with refuses("result-file", says="20 draws of .* 21"):
        estimate.propagate(name, draws=21)
    with refuses("result-file", says="'no such' by .*"):
        estimate.propagate("no such")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory, emps2015: Any, twin: Any) -> Path:
    prefilter = Prefilter(cutoff=60.0, drop=(30, 40), reversals="keep")
    found = identify(emps2015, twin, prefilter).to_dict()
    return text_file(tmp_path_factory.mktemp("written") / "result.json", json.dumps(found))


def _changed(change: Callable[[dict[str, Any]], object]) -> Callable[[str], str]:
    def made(text: str) -> str:
        content = json.loads(text)
        change(content)
        return json.dumps(content)

    return made


def _first(content: dict[str, Any]) -> dict[str, Any]:
    return dict.__getitem__(content, "estimates")[0]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda _: "", "is not JSON"),
        (lambda text: text[: len(text) // 2], "is not JSON: input data was truncated"),
        (lambda _: "[" * 100_000, "is not JSON"),
        (lambda _: "[1]", "it has no schema"),
        (lambda text: text.replace("identification/1", "identification/0"), "identification/0'"),
        (lambda text: text.replace("identification/1", "sweep/1"), "'axisid.sweep/1'"),
        (lambda text: text.replace("identification/1", "stream/1"), "are no longer supported"),
        (_changed(lambda w: w.pop("verdict")), "object missing required field verdict"),
        (_changed(lambda w: _first(w).update(rows="7")), "expected int, got str at"),
        (_changed(lambda w: w["prefilter"].update(cutoff=-1.0)), "cutoff is -1"),
    ],
)
def test_a_file_that_is_no_result_is_refused_in_a_sentence(
    written: Path, tmp_path: Path, change: Callable[[str], str], said: str
) -> None:
    file = text_file(tmp_path / "x.json", change(written.read_text()))
    with pytest.raises(DataError) as refused:
        load_result(file)
    assert said in str(refused.value)
    assert str(file) in str(refused.value)


@pytest.mark.parametrize(
    "change",
    [
        lambda first: first["curvatures"].popitem(),
        lambda first: first.update(curvatures={}),
        lambda first: first.update(covariance_hac=[]),
        lambda first: first["covariance"].pop(),
        lambda first: first["covariance_robust"][0].pop(),
        lambda first: first["correlation"].pop(0),
        lambda first: first["iterations"].append({"M": 1.0}),
        lambda first: first["parameters"].popitem(),
    ],
)
def test_an_estimate_whose_members_are_of_other_parameters_is_refused(
    written: Path, tmp_path: Path, change: Callable[[dict[str, Any]], object]
) -> None:
    """When it is read, and not when something is computed of it."""
    made = _changed(lambda content: change(_first(content)))(written.read_text())
    with refuses("result-file", says="contradicts itself"):
        load_result(text_file(tmp_path / "x.json", made))


def _places(node: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the members of a document are; of a list the first stands for all."""
    members: list[Any] = [*node] if isinstance(node, dict) else [0] * bool(node)
    for name in members if isinstance(node, (dict, list)) else ():
        yield (*above, name)
        yield from _places(node[name], (*above, name))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["identification", "fit"])
def test_a_file_without_any_one_member_is_read_or_refused_in_a_sentence(
    written: Path, fitted: OutputFit, tmp_path: Path, kind: str
) -> None:
    text = written.read_text() if kind == "identification" else json.dumps(fitted.to_dict())
    whole = {k: v for k, v in json.loads(text).items() if k != "digest"}
    for place in _places(whole):
        content = json.loads(json.dumps(whole))
        above = content
        for name in place[:-1]:
            above = above[name]
        del above[place[-1]]
        with suppress(AxisidError):
            read: Any = load_result(text_file(tmp_path / "x.json", json.dumps(content)))
            for estimate in [read] if kind == "fit" else read.estimates.values():
                estimate.derive("M/Fv")


def test_a_name_of_a_later_version_is_passed_over(written: Path, tmp_path: Path) -> None:
    content = json.loads(written.read_text())
    _first(content).update(later=None)
    file = text_file(tmp_path / "x.json", json.dumps({**content, "later": {"a": 1}}))
    assert load_result(file).summary() == load_result(written).summary()


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis) -> Identification:
    return identify(emps2015, twin_record(emps2015), methods=["idm-ls"])


@pytest.mark.slow
def test_what_is_saved_is_loaded_and_saved_again_the_same(
    result: Identification, tmp_path: Path
) -> None:
    file = result.save(tmp_path / "result.json")
    read = load_result(file)
    assert read.to_dict() == result.to_dict()
    assert read.save(tmp_path / "again.json").read_bytes() == file.read_bytes()


@pytest.fixture(scope="module")
def fitted(emps2015: GeneratedAxis, twin: Record) -> OutputFit:
    return fit(emps2015, twin, bootstrap=0)


@pytest.mark.slow
def test_a_fit_read_from_its_file_says_what_the_law_moves(
    fitted: OutputFit, tmp_path: Path
) -> None:
    read = load_result(fitted.save(tmp_path / "fit.json"))
    assert isinstance(read, SavedOutputFit)
    assert fitted.law_move is not None
    assert read.law_move == pytest.approx(fitted.law_move, rel=1e-12)
    assert {name: [*moves] for name, moves in read.law_moves.items()} == {
        name: pytest.approx(moves, rel=1e-12) for name, moves in fitted.law_moves.items()
    }


def test_a_validation_of_a_fit_is_printed_saved_and_loaded(
    emps2015: GeneratedAxis, fitted: OutputFit, tmp_path: Path
) -> None:
    found = validate_fit(fitted, twin_record(emps2015, seed=2))
    read = load_result(found.save(tmp_path / "held.json"))
    assert isinstance(read, SavedFitValidation)
    assert read.to_dict() == found.to_dict()
    assert (read.summary(), read.belief) == (found.summary(), found.belief)
    for one, other in zip(read.checks, found.checks, strict=True):
        assert one == replace(other, finding=one.finding)
        assert one.meaning == other.meaning
    assert (read.percent, read.error, read.output) == (found.percent, found.error, found.output)


@pytest.mark.parametrize(
    ("name", "how", "says"),
    [
        ("result.txt", {}, "name that ends in .json"),
        (3, {}, "name that ends in .json"),
        ("result.json", {"full": True}, "no argument 'full'.* draws"),
    ],
)
def test_other_names_and_what_no_result_is_saved_by_are_refused(
    result: Identification, name: object, how: dict[str, Any], says: str, tmp_path: Path
) -> None:
    with refuses("result-file", says=says):
        result.save(tmp_path / name if isinstance(name, str) else name, **how)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def _lag(nominal: float) -> Parameter:
    return Parameter("Tc", "s", nominal=nominal)


FOUND = DriveTime(
    name="lag", parameter=_lag(1e-4), value=1e-3, deviation=1e-5, interval=(9e-4, 1.1e-3)
)


@pytest.mark.parametrize(
    ("given", "found", "says"),
    [
        ({"lag": 2e-3}, None, "lag 0.001"),
        ({"logged": "current"}, None, "logged command"),
        ({"lag": _lag(1e-3)}, None, "lag 0.001, but .* estimated from 0.001"),
        ({"relative_sd": 0.02}, None, "relative_sd 0.005"),
        ({}, None, ""),
        # The start of a lag that was found is part of the drive.
        ({"lag": _lag(1e-4)}, FOUND, ""),
        ({"lag": _lag(1e-3)}, FOUND, ""),
        ({"lag": _lag(5e-4)}, FOUND, "estimated from 0.0001"),
    ],
)
def test_an_axis_with_another_drive_is_refused(
    given: dict[str, Any], found: Any, says: str
) -> None:
    then = Drive(gain=1.0, lag=1e-3)
    estimate = SimpleNamespace(gain_relative_sd=0.005, physical=None)
    document = SimpleNamespace(estimates=[estimate])
    held = SimpleNamespace(file="result.json", document=document, drive=then, drive_time=found)
    drive = Drive(**{"gain": 35.0, "lag": 1e-3, "relative_sd": 0.005, **given})
    axis = replace(load_axis("emps2015"), drive=drive)
    with refuses("result-file", says) if says else nullcontext():
        refuse_differences(cast(Any, held), axis)


AXIS = recorded_axis("pressure", "held")


@pytest.fixture(scope="module")
def pressurised() -> Identification:
    axis = build(AXIS)
    return identify(axis, twin_record(axis, signals=recorded_values("pressure")))


@pytest.mark.slow
def test_signals_are_on_the_page_of_an_axis_in_figures_and_in_frames(
    pressurised: Identification,
) -> None:
    for form in FORMATS:
        page = axis_page(derive(AXIS), form)
        assert all(
            told in page for told in ("Recorded signals", "pressure", "held between samples")
        )
    labels = [panel.label for panel in record_plot(pressurised).panels]
    assert any("pressure" in label and "Pa" in label for label in labels)
    frame = pressurised.record.to_frame()
    assert list(frame["pressure"]) == list(pressurised.record.signals["pressure"])


@pytest.mark.slow
def test_a_saved_result_knows_its_signals(pressurised: Identification, tmp_path: Path) -> None:
    file = pressurised.save(tmp_path / "pressurised.json")
    saved = load_result(file, AXIS)
    assert pressurised.to_dict()["signals"] == [
        {"name": "pressure", "unit": "Pa", "between": "held"}
    ]
    assert saved.summary() == pressurised.summary()
    other = twin_record(build(AXIS), signals=recorded_values("pressure", 5), seed=5)
    for held in (validate(saved, other), validate(pressurised, other)):
        assert held.methods[0].simulation_error_percent is not None
