"""Times that are not even: told or refused, cut, counted, resampled onto one grid on request."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid import Record, UsageError, read_record
from axisid.estimation import Repairs
from axisid.estimation.raw_tables import Samples
from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.records.resampling import own_period, resample
from tests.refusals import refuses

N = 2000
PERIOD = 1e-3
TIME = PERIOD * np.arange(N)
CONTROL = np.cos(30 * TIME)
Clock = np.ndarray


def log(time: Clock = TIME, **changes: Any) -> dict[str, np.ndarray]:
    """A motion that goes on whatever its clock says."""
    motion = 30 * PERIOD * np.arange(len(time))
    return {"time": time, "position": np.sin(motion), "control": np.cos(motion)} | changes


def wavy(time: Clock) -> dict[str, np.ndarray]:
    """A motion by its clock."""
    return log(time, position=np.sin(30 * time), control=np.cos(30 * time))


def stepped(seconds: float) -> Clock:
    return TIME + seconds * (np.arange(N) >= 1200)


def test_period_that_drifts_is_refused_and_may_be_resampled() -> None:
    drifting = np.cumsum(np.linspace(0.8e-3, 1.2e-3, N))
    with refuses("uneven-time", says=r"drifts from 0\.81\d+ to 1\.1\d+ ms.*resample="):
        read_record(wavy(drifting))
    record = read_record(wavy(drifting), repairs=Repairs(resample="auto"))
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)


def test_drift_is_that_of_each_segment() -> None:
    """Two pieces of a log may have their own times, but not their own periods."""
    same: dict[str, Any] = {
        "position": np.sin(np.arange(2.0 * N)),
        "segments": ((0, N), (N, 2 * N)),
    }
    with refuses("uneven-time", says=r"drifts from 1 to 1\.1 ms"):
        Record(time=np.concatenate([TIME, 10 + 1.1 * TIME]), **same)
    Record(time=np.concatenate([TIME, 10 + TIME]), **same)


@pytest.mark.parametrize(
    ("time", "code"),
    [
        (stepped(0.5), "uneven-time"),
        (stepped(0.7e-3), "uneven-time"),
        (stepped(-0.7e-3), "uneven-time"),
        (stepped(-0.5), "time"),
        (np.concatenate([TIME, TIME]), "time"),
        (np.concatenate([TIME[:900], TIME[[901, 900]], TIME[902:]]), "time"),
        (np.repeat(TIME[:500:4], 4), "time"),
    ],
)
def test_times_that_are_not_even_are_refused(time: Clock, code: str) -> None:
    with refuses(code):
        read_record(log(time))


@pytest.mark.parametrize(
    ("time", "segments"),
    [
        *((stepped(s), ((0, 1200), (1200, N))) for s in (0.5, 0.7e-3, -0.7e-3, -0.5)),
        (np.concatenate([TIME, TIME, TIME]), ((0, N), (N, 2 * N), (2 * N, 3 * N))),
    ],
)
def test_advice_to_cut_gives_the_log_in_pieces(
    time: Clock, segments: tuple[tuple[int, int], ...]
) -> None:
    record = read_record(log(time), repairs=Repairs(gaps="split"))
    assert record.segments == segments
    assert np.array_equal(record.position, log(time)["position"])
    assert record.period == pytest.approx(PERIOD, rel=1e-9)


def test_clock_that_was_set_back_is_told_and_counted() -> None:
    columns = log(stepped(-0.5))
    clock, gaps = read_record(columns, repairs=Repairs(gaps="split")).provenance.repairs
    assert (clock.kind, clock.count, gaps.kind, gaps.count) == ("clock", 1, "gaps", 1)
    assert "before data row 1201, from 1.199 s to 0.7 s" in clock.text
    columns["position"][300:340] = np.nan
    columns["control"][::2] = np.nan
    both = read_record(columns, repairs=Repairs(gaps="split", resample="auto"))
    assert [stop - start for start, stop in both.segments] == [299, 860, 800]


def test_coarse_stamps_are_counted_by_a_given_period_that_is_theirs() -> None:
    coarse = np.floor(TIME * 250 + 1e-9) / 250
    record = read_record(log(coarse), sample_period=PERIOD)
    assert record.time == pytest.approx(TIME, abs=1e-12)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("clock", N)
    with refuses("time", says="too coarse"):
        read_record(log(coarse), sample_period=1.05 * PERIOD)


@pytest.mark.parametrize(("jitter", "told"), [(0.0, False), (0.005, False), (0.1, True)])
def test_jitter_that_is_taken_as_even_is_told(
    rng: np.random.Generator, jitter: float, told: bool
) -> None:
    time = TIME + jitter * PERIOD * rng.uniform(-1, 1, N)
    split = read_record(log(np.delete(time, slice(900, 1000))), repairs=Repairs(gaps="split"))
    for record in (read_record(log(time)), split):
        assert any(note.startswith("time steps of ") for note in record.provenance.doubts) == told


def test_uneven_time_is_resampled_to_the_motion_that_was_sampled(rng: np.random.Generator) -> None:
    uneven = wavy(TIME + PERIOD * rng.uniform(-0.4, 0.4, N))
    with refuses("uneven-time", says="jitter"):
        read_record(uneven)
    record = read_record(uneven, repairs=Repairs(resample=1000.0))
    assert record.period == 1e-3
    # A cubic spline's error is about h^4/384 times the fourth derivative, a line's h^2/8.
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)
    assert record.control == pytest.approx(np.cos(30 * record.time), abs=(30 * 2e-3) ** 2 / 8)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("resample", len(record))
    assert "position by cubic splines, control by straight lines" in repair.text


def test_column_of_a_lower_rate_has_empty_cells() -> None:
    sparse = log(control=np.where(np.arange(N) % 4, np.nan, CONTROL))
    with refuses("empty-cells", says=r"control is nan in data row 2 \(1500 of 2000 cells"):
        read_record(sparse)
    record = read_record(sparse, repairs=Repairs(resample="auto"))
    assert record.period == pytest.approx(PERIOD)
    assert record.control == pytest.approx(np.cos(30 * record.time), abs=(30 * 4e-3) ** 2 / 8)
    empty, resampled = (repair.text for repair in record.provenance.repairs)
    assert "control 1500" in empty
    assert "control 500 rows at 250 Hz" in resampled


GAPPED = {  # leaves a piece of two rows
    name: np.delete(values, np.r_[100:130, 250:252, 254:260]) for name, values in log().items()
}


def test_gaps_split_a_log_into_segments() -> None:
    with refuses("uneven-time", says='gaps="split"'):
        read_record(GAPPED)
    record = read_record(GAPPED, repairs=Repairs(gaps="split"))
    assert record.segments == ((0, 100), (100, 220), (220, 1960))
    assert record.period == pytest.approx(PERIOD, rel=1e-12)
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-12)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("gaps", 3)
    assert "0.038 s are missing" in repair.text
    assert "2 rows in pieces of fewer than 3" in repair.text
    assert record.longest().segments == ()
    assert np.array_equal(record.longest().time, record.time[220:])


def test_resampling_invents_no_motion_in_a_gap() -> None:
    with refuses("uneven-time", says=r"time has 2 gaps"):
        read_record(GAPPED, repairs=Repairs(resample="auto"))
    record = read_record(GAPPED, repairs=Repairs(resample="auto", gaps="split"))
    assert [stop - start for start, stop in record.segments] == [100, 124, 1740]
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)
    kinds = [(repair.kind, repair.count) for repair in record.provenance.repairs]
    assert kinds == [("resample", 1964), ("gaps", 2)]
    assert "0.036 s are missing" in record.provenance.repairs[1].text


@pytest.mark.parametrize(
    "settings", [{"resample": -1.0}, {"resample": "fast"}, {"gaps": "fill"}, {"mask": "all"}]
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        Repairs(**settings)


def cubic(time: np.ndarray) -> np.ndarray:
    return 0.3 - 2 * time + 5 * time**2 - 40 * time**3


def line(time: np.ndarray) -> np.ndarray:
    return 4.0 - 3.0 * time


def laid(position: Clock, force: Clock, rate: float | str = "auto", **more: Any) -> RoleColumns:
    """A position on a cubic, a force on a line, each at its own times."""
    samples = {
        "position": Samples(values=cubic(position), clock=position),
        "force": Samples(values=line(force), clock=force),
    }
    columns = RoleColumns(source="log", names={}, samples=samples, masks=more.pop("masks", {}))
    return resample(columns, rate, **{"split": False, **more})  # type: ignore[arg-type]


@pytest.mark.slow
@given(
    lost=st.sets(st.integers(1, 298), max_size=40),
    late=st.floats(0.0, 0.9),
    slower=st.integers(1, 7),
    rate=st.floats(1000.0, 5000.0),
)
def test_cubics_and_lines_come_back_at_any_rate(
    lost: set[int], late: float, slower: int, rate: float
) -> None:
    """A spline has no error on a cubic, a straight line none on a line, whatever was sampled."""
    position = PERIOD * np.array([k for k in range(300) if k not in lost])
    force = PERIOD * (late + np.arange(0, 300, slower))
    found = laid(position, force, rate, split=True, stated=PERIOD)
    time = found.motion.times
    assert found.samples["position"].values == pytest.approx(cubic(time), abs=1e-7)
    assert found.samples["force"].values == pytest.approx(line(time), abs=1e-7)
    assert found.period == pytest.approx(1 / rate)
    for start, stop in found.segments:
        assert np.diff(time[start:stop]) == pytest.approx(1 / rate, rel=1e-6)


@pytest.mark.slow
@given(
    position=st.sets(st.integers(1, 9), max_size=4),
    force=st.sets(st.integers(1, 9), max_size=4),
)
def test_rows_are_where_every_column_has_samples(position: set[int], force: set[int]) -> None:
    """Of ten stretches of 40 ms, 20 ms long each, some are missing of one column or the other."""

    def clock(missing: set[int]) -> Clock:
        stretches = [0.04 * k + PERIOD * np.arange(21) for k in range(10) if k not in missing]
        return np.concatenate(stretches)

    found = laid(clock(position), clock(force), split=True, stated=PERIOD)
    assert len(found.segments) == 10 - len(position | force)
    assert found.motion.times == pytest.approx(clock(position | force), abs=1e-9)


EVEN = TIME[:100]


def test_a_piece_too_short_for_a_spline_is_left_out() -> None:
    found = laid(np.concatenate([EVEN[:40], EVEN[50:53], EVEN[70:]]), EVEN, split=True)
    assert found.segments == ((0, 40), (40, 70))


def test_both_neighbours_of_a_masked_sample_are_masked() -> None:
    found = laid(EVEN, EVEN, 2000.0, masks={"position": np.arange(100) == 50})
    assert np.flatnonzero(found.masks["position"]).tolist() == [99, 100, 101]


@pytest.mark.parametrize(
    ("position", "force", "rate", "code"),
    [
        (EVEN, 0.1 + EVEN, "auto", "resampling"),
        (PERIOD * np.array([0, 1, 2, 3, 3, 4]), EVEN, "auto", "time"),
        (EVEN, EVEN[:3], "auto", "too-short"),
        (EVEN, EVEN, 890.0, "resampling"),  # folds the position's noise
        (EVEN, EVEN, 1e12, "resampling"),  # would fill the memory
    ],
)
def test_clocks_and_rates_that_give_no_grid_are_refused(
    position: Clock, force: Clock, rate: float | str, code: str
) -> None:
    with refuses(code):
        laid(position, force, rate)


@pytest.mark.parametrize("lost", [0.0, 0.03, 0.2])
@pytest.mark.parametrize("jitter", [0.0, 0.1, 0.3])
def test_period_of_uneven_times_is_the_loggers(
    rng: np.random.Generator, jitter: float, lost: float
) -> None:
    time = 5.0 + 1e-3 * (np.arange(5000) + rng.uniform(-jitter, jitter, 5000))
    period, uncertainty = own_period(time[rng.random(5000) >= lost])
    assert period == pytest.approx(1e-3, rel=1e-4 if jitter else 1e-12)
    assert uncertainty < 2e-3


def test_times_without_a_phase_leave_the_period_open(rng: np.random.Generator) -> None:
    period, uncertainty = own_period(np.cumsum(rng.uniform(0.2e-3, 1.8e-3, 3000)))
    assert period == pytest.approx(1e-3, rel=0.05)
    assert uncertainty == 0.1


@pytest.mark.parametrize("most", [4e-3, 8e-3])
def test_stamps_of_arrival_are_refused_with_the_period_that_reads_the_log_without_them(
    most: float,
) -> None:
    period, rng = 20e-3, np.random.default_rng(3)
    arrival = period * np.arange(N) + rng.uniform(-most, most, N)
    stamped = log(arrival)
    with refuses("uneven-time", says=r"sample_period in run\.toml \(the mean step is") as refused:
        read_record(stamped)
    told = re.search(r"mean step is ([\d.]+) s", str(refused.value))
    assert told is not None
    columns = {name: values for name, values in stamped.items() if name != "time"}
    record = read_record(columns, sample_period=float(told[1]))
    assert record.period == pytest.approx(period, rel=1e-3)
