"""Windows of time: the rest of a log is as if it had never been recorded."""

from typing import Any

import numpy as np
import pytest

from axisid import AxisidError, DataError, Record, UsageError, identify, load_result, read_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation import Repairs

N, PERIOD = 4000, 1e-3
TIME = 10 + PERIOD * np.arange(N)


def log(**changes: Any) -> dict[str, Any]:
    motion = {"position": np.sin(30 * TIME), "reference": np.sin(30 * TIME + 0.01)}
    return {"time": TIME, **motion, "control": np.cos(30 * TIME)} | changes


def test_a_window_is_the_log_cut_there() -> None:
    record = read_record(log(), windows=[(11.0, 12.5)])
    cut = read_record({name: values[1000:2501] for name, values in log().items()})
    assert record.digest == cut.digest
    assert record.windows == ((11.0, 12.5),)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("window", N - 1501)


def test_what_lies_outside_may_be_anything() -> None:
    """Empty cells, a clock that stands still, a constant, jumps: nothing of it is looked at."""
    clean = read_record(log(), windows=[(11.0, 12.5)])
    spoilt = log()
    for name, values in spoilt.items():
        spoilt[name] = values.copy()
    spoilt["time"][3000:] = spoilt["time"][3000]
    spoilt["position"][:900] = np.nan
    spoilt["control"][2600:] = 1e6
    with pytest.raises(AxisidError):
        read_record(spoilt)
    assert read_record(spoilt, windows=[(11.0, 12.5)]).digest == clean.digest


def test_several_windows_are_segments_in_their_order() -> None:
    record = read_record(log(), windows=[(13.0, None), (10.5, 11.0)])
    assert record.segments == ((0, 501), (501, 1501))
    assert record.windows == ((10.5, 11.0), (13.0, TIME[-1]))
    assert record.time[[0, 500, 501, -1]] == pytest.approx([10.5, 11.0, 13.0, TIME[-1]])


def test_windows_that_touch_share_no_sample() -> None:
    record = read_record(log(), windows=[(10.5, 11.0), (11.0, 11.5)])
    assert len(record) == 1001
    assert record.segments == ((0, 501), (501, 1001))


def test_windows_are_cut_as_gaps_are_and_beside_them() -> None:
    kept = np.ones(N, dtype=bool)
    kept[1500:1600] = False
    gapped = {name: values[kept] for name, values in log().items()}
    windows = [(11.0, 12.0), (13.0, 13.5)]
    with pytest.raises(DataError, match="from 11 to 12 s"):
        read_record(gapped, windows=windows)
    record = read_record(gapped, windows=windows, repairs=Repairs(gaps="split"))
    assert record.segments == ((0, 500), (500, 901), (901, 1402))
    assert [r.count for r in record.provenance.repairs if r.kind == "gaps"] == [1]


def test_masked_rows_stay_masked_in_a_window() -> None:
    record = Record(time=TIME, position=np.sin(TIME), masked=((1200, 1300), (3000, 3100)))
    assert record.windowed((11.25, 12.0)).masked == ((0, 50),)


@pytest.mark.parametrize(
    ("windows", "said"),
    [
        ([(12.0, 11.0)], "does not end after it begins"),
        ([(12.0, 12.0)], "does not end after it begins"),
        ([(float("nan"), 12.0)], "give two times of the log"),
        ([(float("inf"), None)], "give two times of the log"),
        ([(0.0, 5.0)], "whose time goes from 10 to 13"),
        ([(20.0, None)], "holds no samples of the log"),
        ([(11.00001, 11.00009)], "holds no samples"),
        ([(10.0, 12.0), (11.0, 13.0)], "overlap"),
        ("10-12", "give FROM..TO in seconds"),
        (["1..2..3"], "give FROM..TO in seconds"),
        ([(1, 2, 3)], "give FROM..TO in seconds"),
        (12.0, "give FROM..TO in seconds"),
    ],
)
def test_a_window_that_cannot_be_taken_is_refused(windows: Any, said: str) -> None:
    with pytest.raises((UsageError, DataError), match=said):
        read_record(log(), windows=windows)


@pytest.mark.slow
def test_results_say_what_was_taken(emps2015: GeneratedAxis, twin: Record, tmp_path: Any) -> None:
    import json

    windows = [(0.0, 1.5), (2.0, None)]
    result = identify(emps2015, twin.windowed(*windows))
    whole = twin.time[-1]
    assert "only from 0 to 1.5 s and from 2 s on taken" in " ".join(result.summary().split())
    document = result.to_dict()
    assert document["record"]["windows"] == [[0.0, 1.5], [2.0, whole]]
    file = tmp_path / "result.json"
    file.write_text(json.dumps(document))
    saved = load_result(file)
    assert saved.record.windows == ((0.0, 1.5), (2.0, whole))
    assert saved.validate(twin.windowed((1.5, 2.0))).record.windows == ((1.5, 2.0),)


def test_the_figure_of_the_record_shades_the_rest(emps2015: GeneratedAxis, twin: Record) -> None:
    from axisid.presentation.plots import record_plot

    plot = record_plot(identify(emps2015, twin.windowed((0.5, 1.5), (2.0, None))))
    drawn = plot.panels[0].series[0]
    assert (drawn.x[0], drawn.x[-1]) == (twin.time[0], twin.time[-1])
    for left_out in ((0.0, 0.5), (1.5, 2.0)):
        assert any(a <= left_out[0] and left_out[1] <= b for a, b in plot.shaded)
    assert "time of the log" in plot.x_label
