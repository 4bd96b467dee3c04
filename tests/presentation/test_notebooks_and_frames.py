"""Results in notebooks, as dataframes, and on axes that a script made."""

import json
from pathlib import Path

import pytest

from axisid import (
    Identification,
    Record,
    compare,
    friction_ladder,
    identify,
    load_result,
    sweep,
    twin_record,
    validate,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.presentation.frames import frame_of
from axisid.support.presentable import Presentable
from tests.refusals import refuses


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_result_is_a_dataframe_of_its_parameters(
    result: Identification, tmp_path: Path, library: str
) -> None:
    pytest.importorskip(library)
    frame = result.to_frame(library)
    assert type(frame).__module__.startswith(library)
    assert len(frame) == sum(len(e.parameters) for e in result.estimates.values())
    rows = frame.to_dict("records") if library == "pandas" else frame.to_dicts()
    first = next(row for row in rows if (row["method"], row["parameter"]) == ("idm-iv", "M"))
    value = result["idm-iv"].parameters["M"]
    assert (first["value"], first["sd_hac"], first["unit"]) == (value.value, value.sd_hac, "kg")
    assert (first["lower_95"], first["upper_95"]) == value.interval
    assert len(result["idm-ls"].to_frame(library)) == 3
    file = tmp_path / "result.json"
    file.write_text(json.dumps(result.to_dict()))
    assert load_result(file).to_frame(library).equals(frame)
    assert len(result.record.to_frame(library)) == len(result.record)


def test_what_is_no_library_or_no_table_is_refused(
    result: Identification, monkeypatch: pytest.MonkeyPatch
) -> None:
    with refuses("dataframe"):
        result.to_frame("excel")
    with refuses("dataframe"):
        frame_of(Presentable(), "pandas")
    monkeypatch.setattr("axisid.presentation.frames.find_spec", lambda _: None)
    with refuses("missing-library"):
        result.to_frame()
    with refuses("missing-library"):
        result.to_frame("polars")


@pytest.mark.slow
@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_comparison_sweep_validation_and_diagnosis_are_dataframes(
    result: Identification, emps2015: GeneratedAxis, twin: Record, library: str
) -> None:
    pytest.importorskip(library)
    compared = compare(friction_ladder(emps2015.declared), twin)
    candidates = compared.to_frame(library)
    assert list(candidates["candidate"]) == [each.name for each in compared.candidates]
    recommended = [each.name == compared.recommended for each in compared.candidates]
    assert list(candidates["recommended"]) == recommended
    held = validate(result, twin_record(emps2015, seed=3))
    methods = held.to_frame(library)
    assert list(methods["method"]) == [each.method for each in held]
    assert list(methods["holds"]) == [each.holds for each in held]
    swept = sweep(emps2015, twin, [40.0, 60.0], methods=["idm-ls"]).to_frame(library)
    assert sorted({*swept["cutoff"]}) == [40.0, 60.0]
    checks = result.diagnosis.to_frame(library)
    assert list(checks["check"]) == [check.name for check in result.verdict]
    assert list(checks["status"]) == [check.status for check in result.verdict]


@pytest.mark.parametrize(
    "what",
    ["force", "autocorrelation", "spectrum", "convergence", "friction", "tracking", "record"],
)
def test_every_figure_is_drawn_on_axes_that_are_given(result: Identification, what: str) -> None:
    from matplotlib.figure import Figure

    panels = len(result.plot(what).axes)
    figure = Figure()
    axes = figure.subplots(panels, 1, squeeze=False)[:, 0]
    assert result.plot(what, ax=axes) is figure
    assert all(each.has_data() for each in axes)
    with refuses("figure", f"has {panels} panels, and ax {panels + 1} axes"):
        result.plot(what, ax=figure.subplots(panels + 1, 1))
    with refuses("figure"):
        result.plot(what, ax="here")
