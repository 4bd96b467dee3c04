"""Figures by Matplotlib, and their ticks."""

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import font_manager

from axisid.presentation.matplotlib import draw, rendered
from axisid.presentation.plots.plot import Panel, Plot, PlotSeries


def without_superscripts(folder: Path) -> Path:
    """A font as Liberation Sans is: under its name, and without the signs of exponents."""
    ttlib = pytest.importorskip("fontTools.ttLib")
    subset = pytest.importorskip("fontTools.subset")
    font = ttlib.TTFont(Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))
    chosen = subset.Subsetter()
    chosen.populate(unicodes=[*range(0x20, 0x7F), *range(0xA0, 0x100), 0x2212])
    chosen.subset(font)
    for record in font["name"].names:
        if record.nameID in (1, 4, 16):
            record.string = "Liberation Sans"
    file = folder / "LiberationSans-Regular.ttf"
    font.save(file)
    return file


def plot_of(x: np.ndarray, y: np.ndarray, label: str = "a", **how: Any) -> Plot:
    panel = Panel(label=label, series=(PlotSeries(label="a", x=x, y=y),), **how)
    return Plot(name="a", title="", caption="", x_label="s⁻¹", panels=(panel,))


@pytest.mark.slow
@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_exponents_are_drawn_where_the_chosen_font_lacks_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, form: str
) -> None:
    manager = font_manager.fontManager
    monkeypatch.setattr(manager, "ttflist", [f for f in manager.ttflist if "DejaVu" in f.name])
    manager.addfont(without_superscripts(tmp_path))
    x = np.geomspace(1e-7, 1e3, 20)
    plot = replace(plot_of(x, 1e8 * x, "inertia [10⁻³ kg m²] ⁰¹⁴⁵⁶⁷⁸⁹"), log=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a glyph that is missing is one
        figure = draw(plot, "τ and θ̈")
        assert rendered(figure, form)
    used = figure.axes[0].yaxis.label.get_fontfamily()
    assert used == ["Liberation Sans", "DejaVu Sans"]


def test_fonts_that_are_not_there_are_not_asked_for(caplog: pytest.LogCaptureFixture) -> None:
    x = np.arange(5.0)
    assert rendered(draw(plot_of(x, x, "a [mm]")), "png")
    assert "not found" not in caplog.text


@pytest.mark.parametrize(
    ("reach", "log", "ticks", "taken_out"),
    [
        ((1e-6, 1e3), True, ["10^-6", "10^-4", "10^0", "10^2"], ""),
        ((15, 130), True, ["20", "50", "100"], ""),
        ((0.0, 0.5), False, ["0.0", "0.2", "0.4"], ""),
        ((-5e-6, 5e-6), False, ["\u22124", "0", "4"], "10^\u22126"),
    ],
)
def test_ticks_are_round_enough_and_written_as_numbers_are_read(
    reach: tuple[float, float], log: bool, ticks: list[str], taken_out: str
) -> None:
    y = np.array(reach)
    axis = draw(plot_of(y, y, log=log, span=reach)).axes[0].yaxis
    labels = axis.get_major_formatter().format_ticks(axis.get_majorticklocs())
    shown = {re.sub(r"\\mathdefault|[${}]", "", text) for text in labels}
    assert {*ticks} <= shown
    assert taken_out in re.sub("[{}]", "", axis.get_major_formatter().get_offset())
