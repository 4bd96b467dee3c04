"""Every result is shown by one hook: text, plain data, figures, notebooks, dataframes."""

from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from axisid import (
    Identification,
    Record,
    compare,
    fit,
    friction_ladder,
    load_axis,
    load_result,
    sweep,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.presentation.views import as_frame
from axisid.support.presentable import Presentable
from tests.refusals import refuses

FIGURES = "force autocorrelation spectrum convergence friction tracking record".split()


@pytest.fixture(scope="module")
def others(result: Identification, emps2015: GeneratedAxis, twin: Record) -> dict[str, Presentable]:
    return {
        "record": twin,
        "validation": validate(result, twin_record(emps2015, seed=3)),
        "fit": fit(emps2015, twin),
        "sweep": sweep(emps2015, twin, [40.0, 60.0], methods=["idm-ls"]),
        "comparison": compare(friction_ladder(emps2015.declared), twin),
    }


@pytest.mark.slow
def test_every_result_has_text_plain_data_and_a_page(
    result: Identification, others: dict[str, Presentable]
) -> None:
    for shown in (result, *others.values()):
        assert str(shown) == shown.summary() != repr(shown)
        assert shown.to_dict()
        assert "<table>" in shown._repr_html_()
    assert "pendulum" in load_axis("pendulum")._repr_html_()


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
    assert load_result(result.save(tmp_path / "r.json")).to_frame(library).equals(frame)


@pytest.mark.slow
@pytest.mark.parametrize("library", ["pandas", "polars"])
@pytest.mark.parametrize(
    ("kind", "column", "wanted"),
    [
        ("comparison", "candidate", lambda of: [each.name for each in of.candidates]),
        ("validation", "holds", lambda of: [each.holds for each in of]),
        ("sweep", "cutoff", lambda _: [40.0] * 3 + [60.0] * 3),
        ("fit", "value", lambda of: [value.value for value in of.parameters.values()]),
        ("record", "position", lambda of: list(of.position)),
    ],
)
def test_other_results_are_dataframes(
    others: dict[str, Presentable], kind: str, column: str, wanted: Any, library: str
) -> None:
    pytest.importorskip(library)
    assert list(others[kind].to_frame(library)[column]) == wanted(others[kind])


def test_what_is_no_library_or_no_table_is_refused(
    result: Identification, monkeypatch: pytest.MonkeyPatch
) -> None:
    with refuses("dataframe"):
        result.to_frame("excel")
    with refuses("dataframe"):
        as_frame(Presentable(), "pandas")
    monkeypatch.setattr("axisid.presentation.views.find_spec", lambda _: None)
    for library in (None, "polars"):
        with refuses("missing-library"):
            result.to_frame(library)


@pytest.mark.parametrize("what", FIGURES)
def test_every_figure_is_drawn_anew_or_on_axes_that_are_given(
    result: Identification, what: str
) -> None:
    panels = len(result.plot(what).axes)
    figure = Figure()
    axes = figure.subplots(panels, 1, squeeze=False)[:, 0]
    assert result.plot(what, ax=axes) is figure
    assert all(each.has_data() for each in axes)
    with refuses("figure", f"has {panels} panels, but ax has {panels + 1} axes"):
        result.plot(what, ax=figure.subplots(panels + 1, 1))
    with refuses("figure"):
        result.plot(what, ax="here")


@pytest.mark.slow
def test_figures_have_names_and_methods(
    result: Identification, others: dict[str, Presentable]
) -> None:
    assert isinstance(result["idm-iv"].plot("convergence"), Figure)
    assert isinstance(result.plot("force", method="idm-ls"), Figure)
    assert isinstance(others["sweep"].plot(), Figure)
    with refuses("figure", says="'colour'"):
        result.plot("colour")
    for shown, name in ((others["sweep"], "sweep"), (result["idm-iv"], "force")):
        with refuses("figure"):
            shown.plot(name, method="ddm-ls")
    with refuses("result", says="'ols'"):
        result.plot("force", method="ols")
