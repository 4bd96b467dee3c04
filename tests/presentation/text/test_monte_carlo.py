"""A study as text, figures, JSON and a page."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from axisid import load_result, trend
from axisid.estimation.monte_carlo import Mean, Share
from axisid.presentation.matplotlib import draw
from axisid.presentation.page import monte_carlo_page
from axisid.presentation.plots.monte_carlo import PLOTS, monte_carlo_plots
from axisid.presentation.plots.plot import Plot
from axisid.presentation.result_files import SavedMonteCarlo
from axisid.presentation.text.monte_carlo import mean_cell, share_texts
from tests.estimation.monte_carlo.short import judged
from tests.refusals import refuses


@pytest.mark.parametrize(
    ("share", "told"),
    [
        (Share(20, 20), ("100", "84 to 100")),
        (Share(2886, 3000), ("96.2", "95.5 to 96.8")),
        (Share(110_000, 1_000_000), ("11.00", "10.94 to 11.06")),
        (Share(0, 0), ("-", "-")),
        (None, ("-", "-")),
    ],
)
def test_shares_have_the_digits_that_their_intervals_tell(
    share: Share | None, told: tuple[str, str]
) -> None:
    assert share_texts(share) == told


@pytest.mark.parametrize(
    ("mean", "told"),
    [
        (Mean(0.000113, 0.0013), ("0.0001", "0.0013")),
        (Mean(101.4, 130.2), ("101", "130")),
        (Mean(2e-9, 1e-9), ("2e-09", "1e-09")),
        (Mean(float("nan"), float("nan")), ("-", "-")),
        (Mean(2.5, float("nan")), ("2.5", "-")),
    ],
)
def test_means_have_the_digits_of_their_errors(mean: Mean, told: tuple[str, str]) -> None:
    cell = mean_cell(mean)
    assert (cell.value, cell.deviation) == told


@pytest.mark.slow
def test_json_is_what_the_schema_says(root: Path) -> None:
    schema = json.loads((root / "docs" / "schema" / "results-1.json").read_text(encoding="utf-8"))
    document = json.loads(json.dumps(judged().to_dict(), allow_nan=False))
    jsonschema.validate(document, schema)
    assert document["schema"] == "axisid.monte_carlo/1"
    assert document["estimands"][0]["coverage"]["hac"]["of"] == 10


def test_a_file_reads_back_as_what_was_written(tmp_path: Path) -> None:
    live, file = judged(), tmp_path / "study.json"
    file.write_text(json.dumps(live.to_dict()))
    written = json.loads(file.read_text())
    saved = load_result(file)
    assert isinstance(saved, SavedMonteCarlo)
    assert saved.summary() == live.summary()
    assert saved.to_dict() == written
    assert (len(saved), saved.judged, saved.check_figures) == (
        len(live),
        live.judged,
        live.check_figures,
    )
    assert (saved.checks, saved.belief) == (live.checks, live.belief)
    assert (saved.figures, saved.failures) == (live.figures, live.failures)
    chain = written["twins"].pop("chain")  # as earlier versions wrote it
    written["twins"]["noise"] |= {"position": None, "resolution": None}
    file.write_text(json.dumps(written))
    earlier = load_result(file)
    assert chain["position"] == written["twins"]["position_noise"]
    assert earlier.summary() == live.summary()
    with refuses("result"):
        saved.of("idm-iv", "mass")
    with refuses("figure", says="the figure 'coverage' needs rows, samples or runs"):
        saved.plot("coverage")
    with refuses("trend"):
        trend(file)


def test_figures_have_a_panel_for_each_parameter_and_a_curve_for_each_method() -> None:
    for name, plot in monte_carlo_plots(judged()).items():
        assert isinstance(plot, Plot)
        assert plot.name == name
        assert [panel.label.partition(",")[0] for panel in plot.panels] == ["M", "Fv", "Fc"]
        assert [s.label for s in plot.panels[0].series if s.label] == ["DDM-LS", "IDM-IV"]
        assert draw(plot).axes


def test_curve_of_95_percent_is_the_share_of_the_intervals() -> None:
    plot = PLOTS["coverage"](judged())
    curve = plot.panels[0].series[1]
    at = int(np.flatnonzero(curve.x == 95)[0])
    assert curve.y[at] == pytest.approx(100 * judged().of("idm-iv", "M").coverage["hac"].value)


def test_page_and_frame_show_every_figure_and_run() -> None:
    page = monte_carlo_page(judged(), command="axisid study emps2015")
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")
    assert all(f'id="plot-{name}"' in page for name in PLOTS)
    assert "SIMULATED" in page
    assert "axisid study emps2015" in page
    assert len(judged().to_frame("polars")) == 10
