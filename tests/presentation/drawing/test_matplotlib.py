"""Figures by Matplotlib, and their ticks."""

import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import font_manager

from axisid.presentation.drawing.matplotlib import Thousands, draw, log_ticks, rendered
from axisid.presentation.plots.plot import Panel, Plot, Series


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


@pytest.mark.slow
@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_exponents_are_drawn_where_the_chosen_font_lacks_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, form: str
) -> None:
    manager = font_manager.fontManager
    monkeypatch.setattr(manager, "ttflist", [f for f in manager.ttflist if "DejaVu" in f.name])
    manager.addfont(without_superscripts(tmp_path))
    x = np.geomspace(1e-7, 1e3, 20)
    panel = Panel(
        label="inertia [10⁻³ kg m²] ⁰¹⁴⁵⁶⁷⁸⁹", series=(Series(label="a", x=x, y=1e8 * x),)
    )
    plot = Plot(name="all", title="", caption="", x_label="s⁻¹", panels=(panel,), log=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a glyph that is missing is one
        figure = draw(plot, "τ and θ̈")
        assert rendered(figure, form)
    used = figure.axes[0].yaxis.label.get_fontfamily()
    assert used == ["Liberation Sans", "DejaVu Sans"]


def test_fonts_that_are_not_there_are_not_asked_for(caplog: pytest.LogCaptureFixture) -> None:
    x = np.arange(5.0)
    panel = Panel(label="a [mm]", series=(Series(label="a", x=x, y=x),))
    plot = Plot(name="all", title="", caption="", x_label="t", panels=(panel,))
    assert rendered(draw(plot), "png")
    assert "not found" not in caplog.text


@pytest.mark.parametrize(
    ("first", "last", "ticks"),
    [
        (1e-6, 1e3, [1e-6, 1e-4, 0.01, 1, 100]),
        (1e-5, 400.0, [1e-5, 1e-4, 1e-3, 0.01, 0.1, 1, 10, 100]),
        (15, 130, [20, 50, 100]),
        (19, 31, [20, 22.5, 25, 27.5, 30]),
        (0.8, 6.0, [1, 2, 5]),
    ],
)
def test_logarithmic_ticks_are_round_and_enough(
    first: float, last: float, ticks: list[float]
) -> None:
    assert log_ticks(first, last) == pytest.approx(ticks)


def test_a_power_of_a_thousand_is_taken_out_of_small_ticks() -> None:
    form = Thousands()
    assert form.format_ticks([-5e-6, 0.0, 5e-6]) == ["\u22125", "0", "5"]
    assert form.get_offset() == "\u00d7 10⁻⁶"
    assert form.format_ticks([0.0, 0.25, 0.5]) == ["0.00", "0.25", "0.50"]
    assert form.get_offset() == ""
