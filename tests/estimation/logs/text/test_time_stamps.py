"""Time stamps of many ways give the same seconds; one that may mean two times is refused."""

import numpy as np
import pytest

from axisid.estimation.logs.text.time_stamps import TimeStampError, stamp_seconds

EXPECTED = [0.0, 0.25, 60.5]


@pytest.mark.parametrize(
    "cells",
    [
        ["2026-02-01T12:00:00", "2026-02-01T12:00:00.25", "2026-02-01T12:01:00.5"],
        ["2026-02-01 12:00:00,000", "2026-02-01 12:00:00,250", "2026-02-01 12:01:00,5"],
        ["2026/02/01 12:00:00", "2026/02/01 12:00:00.250", "2026/2/1 12:01:00.5"],
        ["1.2.2026 12:00:00", "01.02.2026 12:00:00,25", "1.2.2026 12:01:00,5"],
        ["02/01/2026 12:00:00", "02/01/2026 12:00:00.25", "2/1/2026 12:01:00.5"],
        ["2/1/2026 12:00:00 PM", "2/1/2026 12:00:00.25 PM", "2/1/2026 12:01:00.5 pm"],
        ["12:00:00", "12:00:00.25", "12:01:00.5"],
        ["11:59:59 AM", "11:59:59.25 AM", "12:00:59.5 PM"],
        ["2026-02-01T12:00:00Z", "2026-02-01T12:00:00.25Z", "2026-02-01T12:01:00.5Z"],
        ["2026-02-01 12:00:00+00:00", "2026-02-01 12:00:00.25 UTC", "2026-02-01 13:01:00.5+01:00"],
        ["2026-02-01T12:00:00-0530", "2026-02-01T12:00:00.25-0530", "2026-02-01T17:31:00.5+00"],
        ["2026-02-01 12:00:00 CET", "2026-02-01 12:00:00.25 CET", "2026-02-01 12:01:00.5 CET"],
        [f"2026-02-01T12:0{t}+01:00[Europe/Berlin]" for t in ("0:00", "0:00.25", "1:00.5")],
        [f"2026-02-01 12:0{t} Europe/Berlin" for t in ("0:00", "0:00.25", "1:00.5")],
        ["0 days 00:00:00", "0 days 00:00:00.250000", "0 days 00:01:00.500000"],
        ["-1 days +23:59:59", "-1 days +23:59:59.25", "0 days 00:00:59.5"],
    ],
)
def test_stamps_of_many_ways_count_from_the_first(cells: list[str]) -> None:
    seconds, note = stamp_seconds(cells)
    assert seconds == pytest.approx(EXPECTED, abs=1e-12)
    assert note.startswith("time stamps, relative to the first")


def test_nanoseconds_are_kept_and_an_empty_cell_has_no_time() -> None:
    seconds, _ = stamp_seconds(["", "2026-02-01 12:00:00", "", "2026-02-01 12:00:00.000000001"])
    assert np.array_equal(seconds, [np.nan, 0.0, np.nan, 1e-9], equal_nan=True)


def test_times_without_a_date_pass_midnight_and_say_so() -> None:
    cells = ["23:59:59.5", "00:00:00", "00:00:00.5", "12:00:00", "23:59:59.5", "00:00:01"]
    seconds, note = stamp_seconds(cells)
    assert seconds == pytest.approx([0.0, 0.5, 1.0, 43200.5, 86400.0, 86401.5])
    assert "midnight" in note
    seconds, note = stamp_seconds(["12:00:01", "12:00:00"])
    assert "midnight" not in note
    assert seconds[1] == -1.0  # a small step back is left as it is, to be refused


@pytest.mark.parametrize(
    ("dates", "days", "first"),
    [(["12/31/2026", "01/01/2027"], 1, "month"), (["31/12/2026", "01/01/2027"], 1, "day")],
)
def test_order_of_day_and_month_is_told_by_a_number_beyond_twelve(
    dates: list[str], days: int, first: str
) -> None:
    seconds, note = stamp_seconds([f"{date} 12:00:00" for date in dates])
    assert seconds[1] == days * 86400
    assert note.endswith(f"{first} first")


@pytest.mark.parametrize(
    ("cells", "row", "why"),
    [
        (["02/01/2026 12:00:00", "03/01/2026 12:00:00"], 0, "day and month"),
        (["30.2.2026 12:00:00", "1.3.2026 12:00:00"], 0, "no such day"),
        (["1.3.2026 12:00:00", "", "30.2.2026 12:00:00"], 2, "no such day"),
        (["", "2026-02-01 12:00:00", "", "2026-02-01 25:00:00"], 3, ""),
        (["13:00:00 PM", "01:00:00 PM"], 0, ""),
        (["2026-02-01 12:00:00Z", "2026-02-01 12:00:00"], 0, "several formats"),
        (["2026-02-01 12:00:00", "12:00:01"], 0, "several formats"),
        (["2026-10-25 02:59:59 CEST", "2026-10-25 02:00:00 CET"], 0, "several formats"),
        (["12:00:00", "noon"], 1, ""),
        (["12:00", "12:01"], 0, ""),
        (["2.1.26 12:00:00"], 0, ""),
    ],
)
def test_what_may_mean_two_times_or_none_is_refused(cells: list[str], row: int, why: str) -> None:
    with pytest.raises(TimeStampError, match=why or None) as caught:
        stamp_seconds(cells)
    assert caught.value.row == row
    assert bool(caught.value.why) == bool(why)
