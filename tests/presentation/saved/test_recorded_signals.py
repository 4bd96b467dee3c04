"""What is shown and saved of recorded signals: page of the axis, JSON, summary, figures, frames."""

import json
from pathlib import Path

import pytest

from axisid import Identification, build, derive, identify, load_result, twin_record, validate
from axisid.presentation.formulas.axis_page import FORMATS, axis_page
from axisid.presentation.plots.result import record_plot
from tests.axes.recorded import recorded_axis, recorded_values

AXIS = recorded_axis("pressure", "held")


@pytest.fixture(scope="module")
def result() -> Identification:
    axis = build(AXIS)
    return identify(axis, twin_record(axis, signals=recorded_values("pressure")))


def test_signals_are_on_the_page_of_an_axis_in_figures_and_in_frames(
    result: Identification,
) -> None:
    for form in FORMATS:
        page = axis_page(derive(AXIS), form)
        assert all(
            told in page for told in ("Recorded signals", "pressure", "held between samples")
        )
    labels = [panel.label for panel in record_plot(result).panels]
    assert any("pressure" in label and "Pa" in label for label in labels)
    frame = result.record.to_frame()
    assert list(frame["pressure"]) == list(result.record.signals["pressure"])


@pytest.mark.slow
def test_a_saved_result_knows_its_signals(result: Identification, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(result.to_dict()))
    saved = load_result(file, AXIS)
    declared = {"name": "pressure", "unit": "Pa", "between": "held"}
    assert result.to_dict()["signals"] == [declared]
    assert saved.summary() == result.summary()
    other = twin_record(build(AXIS), signals=recorded_values("pressure", 5), seed=5)
    for held in (validate(saved, other), validate(result, other)):
        assert held.methods[0].simulation_error_percent is not None
