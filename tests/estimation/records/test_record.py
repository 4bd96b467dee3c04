"""A record is checked once, then read-only; outside its windows it is as if never recorded."""

from typing import Any

import numpy as np
import pytest

from axisid import (
    AxisidError,
    DataError,
    Record,
    UsageError,
    load_result,
    read_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation import Repairs
from tests.refusals import refuses
from tests.unjudged import identify

N, PERIOD = 4000, 1e-3
TIME = 10 + PERIOD * np.arange(N)


LOG = {
    "time": TIME,
    "position": np.sin(30 * TIME),
    "reference": np.sin(30 * TIME + 0.01),
    "control": np.cos(30 * TIME),
}


def test_a_window_is_the_log_cut_there() -> None:
    record = read_record(LOG, windows=[(11.0, 12.5)])
    cut = {name: values[1000:2501] for name, values in LOG.items()}
    assert record.digest == read_record(cut).digest
    assert record.windows == ((11.0, 12.5),)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("window", N - 1501)


def test_what_lies_outside_may_be_anything() -> None:
    """Empty cells, a clock that stands still, a constant, jumps: nothing of it is looked at."""
    clean = read_record(LOG, windows=[(11.0, 12.5)])
    spoilt = {name: values.copy() for name, values in LOG.items()}
    spoilt["time"][3000:] = spoilt["time"][3000]
    spoilt["position"][:900] = np.nan
    spoilt["control"][2600:] = 1e6
    with pytest.raises(AxisidError):
        read_record(spoilt)
    assert read_record(spoilt, windows=[(11.0, 12.5)]).digest == clean.digest


@pytest.mark.parametrize(
    ("windows", "samples", "first", "end"),
    [
        ([(13.0, None), (10.5, 11.0)], 1501, 13.0, TIME[-1]),
        ([(10.5, 11.0), (11.0, 11.5)], 1001, 11.001, 11.5),  # share no sample
    ],
)
def test_several_windows_are_segments_in_their_order(
    windows: Any, samples: int, first: float, end: float
) -> None:
    record = read_record(LOG, windows=windows)
    assert record.segments == ((0, 501), (501, samples))
    assert record.windows == ((10.5, 11.0), (max(w[0] for w in windows), end))
    assert record.time[[0, 500, 501, -1]] == pytest.approx([10.5, 11.0, first, end])


def test_windows_are_cut_as_gaps_are_and_beside_them() -> None:
    gapped = {name: np.delete(values, slice(1500, 1600)) for name, values in LOG.items()}
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
        ([(float("nan"), 12.0)], "two times of the log"),
        ([(float("inf"), None)], "two times of the log"),
        ([(0.0, 5.0)], "10 to 13"),
        ([(20.0, None)], "no samples"),
        ([(11.00001, 11.00009)], "no samples"),
        ([(10.0, 12.0), (11.0, 13.0)], "overlap"),
        ("10-12", "FROM..TO in seconds"),
        (["1..2..3"], "FROM..TO in seconds"),
        ([(1, 2, 3)], "FROM..TO in seconds"),
        (12.0, "FROM..TO in seconds"),
    ],
)
def test_a_window_that_cannot_be_taken_is_refused(windows: Any, said: str) -> None:
    with pytest.raises((UsageError, DataError), match=said):
        read_record(LOG, windows=windows)


@pytest.mark.slow
def test_results_say_what_was_taken(emps2015: GeneratedAxis, twin: Record, tmp_path: Any) -> None:
    import json

    windows = [(0.0, 1.5), (2.0, None)]
    result = identify(emps2015, twin.windowed(*windows))
    whole = twin.time[-1]
    assert "from 0 to 1.5 s and from 2 s on" in " ".join(result.summary().split())
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


GOOD: dict[str, Any] = {
    "time": np.arange(50) * 1e-3,
    "position": np.sin(np.arange(50)),
    "control": np.cos(np.arange(50)),
}


def changed(role: str, row: int, value: float) -> dict[str, Any]:
    return {role: np.where(np.arange(50) == row, value, GOOD[role])}


def test_arrays_are_copied_and_read_only() -> None:
    position = GOOD["position"].copy()
    record = Record(**{**GOOD, "position": position})
    position[0] = 99.0
    assert record.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        record.position[0] = 1.0


def test_period_is_the_mean_step_unless_given() -> None:
    assert Record(**GOOD).period == pytest.approx(1e-3)
    assert Record(**GOOD, sample_period=1.001e-3).period == 1.001e-3


@pytest.mark.parametrize(
    ("change", "code", "says"),
    [
        (changed("position", 7, np.nan), "not-finite", "position is nan in data row 8"),
        (changed("control", 3, np.inf), "not-finite", "control is inf in data row 4"),
        (changed("control", 3, -1e300), "not-finite", "control is -1e.300 in data row 4"),
        (changed("time", 9, 0.0), "time", "10"),
        (changed("time", 9, 0.008), "time", "10"),
        (
            {"time": np.r_[GOOD["time"][:30], GOOD["time"][30:] + 0.01]},
            "uneven-time",
            "31",
        ),
        ({"time": np.cumsum(np.r_[np.full(30, 1e-3), np.full(20, 1.4e-3)])}, "uneven-time", ""),
        ({"position": np.ma.masked_less(GOOD["position"], 0)}, "record", "[0-9]+"),
        ({"position": GOOD["position"] + 1j}, "record", "complex"),
        ({"position": np.zeros(50)}, "not-shown", "position is 0"),
        ({"control": np.full(50, 2.5)}, "not-shown", "control is 2.5"),
        ({"reference": np.zeros(50)}, "not-shown", "reference is 0"),
        ({"position": np.zeros(49)}, "record", "time 50, position 49"),
        ({"position": np.zeros((50, 2))}, "record", r"\(50, 2\)"),
        ({"position": ["a"] * 50}, "record", "text"),
        ({"sample_period": 1.0}, "time", "1 s, but the time column steps by 0.001"),
        ({"sample_period": -1e-3}, "time", ""),
        ({"time": None}, "missing-column", "no time"),
        ({"signals": None}, "record", "signals are None"),
        ({k: v[:2] for k, v in GOOD.items()}, "too-short", "3 rows"),
    ],
)
def test_bad_records_are_explained(change: dict[str, Any], code: str, says: str) -> None:
    with refuses(code, says):
        Record(**{**GOOD, **change})
