"""A log read in blocks gives what the whole log gives, in a memory that does not grow with it."""

import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from axisid import (
    Parameter,
    Prefilter,
    Record,
    build,
    friction_ladder,
    identify,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.records.blocks import LogBlocks
from axisid.estimation.streaming import StreamedEstimate, identify_stream
from tests.refusals import refuses


def in_blocks(record: Record, rows: int) -> list[dict[str, np.ndarray]]:
    columns = {r: v for r, v in record.channels().items() if r in ("time", "position", "control")}
    return [
        {role: values[k : k + rows] for role, values in columns.items()}
        for k in range(0, len(record), rows)
    ]


def check_same(
    streamed: StreamedEstimate,
    axis: GeneratedAxis,
    record: Record,
    filter_: Prefilter | None = None,
) -> None:
    # A stream simulates nothing, so that its reversals are those of the measured motion.
    result = identify(axis, replace(record, reference=None), filter_, ["idm-ls"])
    whole = result["idm-ls"]
    assert streamed.prefilter.reversals == result.prefilter.reversals
    assert streamed.excluded_samples == result.data.sampling.excluded_samples
    assert streamed.rows == len(whole.y)
    assert streamed.physical == pytest.approx(whole.physical, rel=1e-10, abs=0)
    for name, covariance in whole.covariances.items():
        scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
        found = streamed.covariances[name] / scale
        assert found == pytest.approx(covariance / scale, rel=0, abs=1e-10)
    assert f"{streamed.lags} lags" in whole.covariance_names["hac"]
    assert streamed.equation_error_percent == pytest.approx(whole.equation_error_percent, rel=1e-10)
    assert streamed.condition_number == pytest.approx(whole.condition_number, rel=1e-8)


@pytest.mark.slow
@settings(max_examples=6)
@given(
    rows=st.sampled_from([37, 700, 2048, 7801, 10_000]),
    cutoff=st.sampled_from([25.0, 60.0, 200.0]),
    decimate=st.sampled_from([1, 4, 10]),
    decimation=st.sampled_from(["matlab", "scipy"]),
    drop=st.sampled_from([None, (0, 0), (49, 3)]),
    hold=st.sampled_from(["raw", "zoh", None]),
    reversals=st.sampled_from(["keep", "leave-out", None]),
)
def test_blocks_of_any_size_give_the_estimate_of_the_whole_record(
    emps2015: GeneratedAxis,
    twin: Record,
    rows: int,
    cutoff: float,
    decimate: int,
    decimation: str,
    drop: tuple[int, int] | None,
    hold: str | None,
    reversals: str | None,
) -> None:
    filter_ = Prefilter(
        cutoff=cutoff,
        decimate=decimate,
        decimation=decimation,  # type: ignore[arg-type]
        drop=drop,
        hold=hold,  # type: ignore[arg-type]
        reversals=reversals,  # type: ignore[arg-type]
    )
    streamed = identify_stream(emps2015, in_blocks(twin, rows), filter_)
    check_same(streamed, emps2015, replace(twin, sample_period=None), filter_)


def test_real_record_in_blocks(emps: GeneratedAxis, emps_record: Record) -> None:
    streamed = identify_stream(emps, in_blocks(emps_record, 5000), sample_period=1e-3)
    check_same(streamed, emps, emps_record)


class Endless:
    """A log of any length, made as it is read: nothing of it stays in memory."""

    def __init__(self, samples: int, rows: int) -> None:
        self.samples, self.rows = samples, rows

    def __iter__(self) -> Iterator[dict[str, np.ndarray]]:
        for start in range(0, self.samples, self.rows):
            k = np.arange(start, min(start + self.rows, self.samples))
            t = 1e-3 * k
            q = 0.1 * np.sin(7 * t) + 0.02 * np.sin(31 * t)
            yield {"time": t, "position": q, "control": np.cos(7 * t) + np.sin(3 * t)}


@pytest.mark.slow
def test_memory_does_not_grow_with_the_log(emps2015: GeneratedAxis) -> None:
    peaks = {}
    for samples in (50_000, 400_000):
        tracemalloc.start()
        result = identify_stream(emps2015, Endless(samples, 10_000))
        peaks[samples] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert result.samples == samples
    assert peaks[400_000] < 1.1 * peaks[50_000]
    # Three columns of the whole log alone would take 9.6 MB.
    assert peaks[400_000] < 9.6e6


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_files_are_read_in_blocks(
    tmp_path: Path, emps2015: GeneratedAxis, twin: Record, ending: str
) -> None:
    columns = {
        "t [ms]": 1e3 * twin.time,
        "pos [mm]": 1e3 * twin.position,
        "volts": np.array(twin.control),
    }
    file = tmp_path / f"log{ending}"
    if ending == ".csv":
        rows = zip(*columns.values(), strict=True)
        lines = [";".join(f"{x:.17g}".replace(".", ",") for x in row) for row in rows]
        file.write_text("\n".join([";".join(columns), *lines]))
    else:
        pa = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(pa.table(columns), file)
    blocks = LogBlocks(
        file=file,
        axis=emps2015.axis,
        columns={"time": "t", "position": "pos", "control": "volts"},
        rows=1000,
    )
    provenance = blocks.provenance()
    assert "position: mm -> m" in provenance.assumed
    streamed = identify_stream(emps2015, blocks, provenance=provenance)
    result = identify(emps2015, replace(twin, reference=None), methods=["idm-ls"])
    assert streamed.physical == pytest.approx(result["idm-ls"].physical, rel=1e-8)
    assert streamed.excluded_samples == result.data.sampling.excluded_samples
    assert "read in blocks" in str(streamed)


def test_reversals_bias_friction_where_they_are_kept(emps2015: GeneratedAxis, twin: Record) -> None:
    truth = twin.provenance.truth["Fc"]
    by_default, kept = (
        identify_stream(emps2015, in_blocks(twin, 2000), Prefilter(cutoff=40.0, reversals=r))
        for r in (None, "keep")
    )
    assert abs(by_default.physical[2] - truth) < 0.5 * abs(kept.physical[2] - truth)
    assert f"Reversals are left out, {by_default.excluded_samples} samples" in str(by_default)
    assert "Reversals are kept, where the low-pass rounds friction" in " ".join(str(kept).split())
    assert repr(kept).startswith("idm-ls in blocks: M = ")
    with refuses("no-such-value", says="'m'; choose from M, Fv, Fc"):
        kept.parameters["m"]


def test_values_beyond_their_bounds_are_told(emps2015: GeneratedAxis, twin: Record) -> None:
    assert twin.control is not None
    flipped = replace(twin, control=-twin.control)
    streamed = identify_stream(emps2015, in_blocks(flipped, 2000))
    assert "FAIL   bounds: M = -" in str(streamed)
    assert "check the signs and units" in streamed.to_dict()["beyond_bounds"]
    assert identify_stream(emps2015, in_blocks(twin, 2000)).to_dict()["beyond_bounds"] is None


def test_log_that_would_need_repairs_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    blocks = in_blocks(twin, 1000)
    with refuses("uneven-time", says=r"3001 is 1\.001"):
        identify_stream(emps2015, [*blocks[:3], *blocks[4:]])
    spoilt = dict(blocks[2], position=np.where(np.arange(1000) == 7, np.nan, 0.0))
    with refuses("empty-cells", says="position is nan in data row 2008"):
        identify_stream(emps2015, [*blocks[:2], spoilt, *blocks[3:]])
    with refuses("no-time"):
        identify_stream(emps2015, [{r: b[r] for r in ("position", "control")} for b in blocks])
    with refuses("no-force"):
        identify_stream(emps2015, [{r: b[r] for r in ("time", "position")} for b in blocks])


@pytest.mark.parametrize("rows", [1000, 10_000])
def test_log_that_is_refused_whole_is_refused_in_blocks(
    emps2015: GeneratedAxis, twin: Record, rows: int
) -> None:
    def blocks(**changes: np.ndarray) -> list[dict[str, np.ndarray]]:
        columns = {"time": twin.time, "position": twin.position, "control": twin.control} | changes
        return [{r: v[k : k + rows] for r, v in columns.items()} for k in range(0, len(twin), rows)]

    steps = np.where(np.arange(len(twin)) < 0.6 * len(twin), 1e-3, 1.4e-3)
    slower = np.cumsum(steps)
    told = r"time steps are uneven: 0\.001 s in the middle, 0\.001\d+ s in the mean"
    with refuses("uneven-time", says=told):
        replace(twin, time=slower, sample_period=None)
    with refuses("uneven-time", says=told) as refused:
        identify_stream(emps2015, blocks(time=slower))
    assert refused.value.code == "uneven-time"
    assert "call identify in place of identify_stream" in str(refused.value.remedy)
    with refuses("other-sample-period", says=r"0\.0011 s, but the time column steps by 0\.001"):
        identify_stream(emps2015, blocks(), sample_period=1.1e-3)
    for role in ("control", "position"):
        with refuses("constant-column", says=f"the {role} is 1 in every row"):
            identify_stream(emps2015, blocks(**{role: np.ones(len(twin))}))


def test_what_cannot_be_streamed_is_refused(
    tmp_path: Path, emps2015: GeneratedAxis, twin: Record
) -> None:
    with refuses("not-in-blocks"):
        list(LogBlocks(file=tmp_path / "log.npz"))
    with refuses("log-not-read", says="No such file"):
        list(LogBlocks(file=tmp_path / "log.csv"))
    with refuses("short-segment", says="record has 100"):
        identify_stream(emps2015, [{r: v[:100] for r, v in in_blocks(twin, 500)[0].items()}])


def test_axis_that_is_not_linear_is_refused() -> None:
    rung = friction_ladder(load_axis("emps2015"), stribeck=0.02)
    base = next(iter(rung.values()))
    v = Parameter("v", "m/s", nominal=0.02, lower=1e-3)
    level = Parameter("Fs", "N")
    peak = level * sympy.exp(-((base.coordinate.velocity / v.symbol) ** 2))
    axis = replace(
        base, parameters=(*base.parameters, v, level), force=base.force + peak, control=None
    )
    axis = replace(axis, experiment=None)
    with refuses("nonlinear-in-blocks"):
        identify_stream(build(axis), [])


def test_names_of_the_library_are_those_of_the_whole(emps2015: GeneratedAxis) -> None:
    result = identify_stream(load_axis("emps2015"), Endless(5000, 1000))
    assert list(result.to_dict()["parameters"]) == [p.name for p in emps2015.parameters]


@pytest.mark.slow
def test_time_stamps_count_on_from_block_to_block(
    tmp_path: Path, emps2015: GeneratedAxis, twin: Record
) -> None:
    stamps = np.datetime64("2026-02-03T23:59:57") + (1e3 * twin.time).round().astype(
        "timedelta64[ms]"
    )
    rows = zip(stamps, twin.position, np.array(twin.control), strict=True)
    lines = [f"{t},{q!r},{u!r}" for t, q, u in ((t, float(q), float(u)) for t, q, u in rows)]
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["time,position,control", *lines]))
    streamed = identify_stream(emps2015, LogBlocks(file=file, axis=emps2015.axis, rows=1000))
    assert streamed.samples == len(twin)
    assert streamed.period == pytest.approx(1e-3, rel=1e-9)


def test_jitter_that_is_taken_as_even_is_told(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator
) -> None:
    even = identify_stream(emps2015, in_blocks(twin, 1000))
    assert even.provenance.doubts == ()
    uneven = twin.time + 0.05 * twin.period * rng.uniform(-1, 1, len(twin))
    blocks = [
        dict(block, time=uneven[1000 * k : 1000 * k + len(block["time"])])
        for k, block in enumerate(in_blocks(twin, 1000))
    ]
    (told,) = identify_stream(emps2015, blocks).provenance.doubts
    assert "taken as even" in told.text


def all_in_blocks(record: Record, rows: int) -> list[dict[str, np.ndarray]]:
    return [
        {role: values[k : k + rows] for role, values in record.channels().items()}
        for k in range(0, len(record), rows)
    ]


def check_same_instruments(
    streamed: StreamedEstimate, axis: GeneratedAxis, record: Record, filter_: Prefilter | None
) -> None:
    result = identify(axis, record, filter_, ["idm-iv"])
    whole = result["idm-iv"]
    assert streamed.prefilter.reversals == result.prefilter.reversals
    assert streamed.excluded_samples == result.data.sampling.excluded_samples
    assert streamed.rows == len(whole.y)
    assert streamed.physical == pytest.approx(whole.physical, rel=1e-9, abs=0)
    assert streamed.started == whole.started
    assert len(streamed.iterates) == len(whole.iterates)
    for own, other in zip(streamed.iterates, whole.iterates, strict=True):
        assert own.physical == pytest.approx(other.physical, rel=1e-9)
    assert streamed.simulation_error_percent == pytest.approx(
        whole.simulation_error_percent, rel=1e-9
    )
    assert streamed.equation_error_percent == pytest.approx(whole.equation_error_percent, rel=1e-9)
    for name, covariance in whole.covariances.items():
        scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
        assert streamed.covariances[name] / scale == pytest.approx(covariance / scale, abs=1e-8)


@pytest.mark.parametrize(
    ("rows", "filter_"),
    [
        (3001, None),
        pytest.param(
            9_999,
            Prefilter(cutoff=40.0, decimate=1, reversals="keep"),
            marks=pytest.mark.slow,
        ),
        pytest.param(2500, Prefilter(drop=(49, 3), decimation="scipy"), marks=pytest.mark.slow),
    ],
)
def test_instruments_of_blocks_are_those_of_the_whole_record(
    emps2015: GeneratedAxis, twin: Record, rows: int, filter_: Prefilter | None
) -> None:
    streamed = identify_stream(emps2015, all_in_blocks(twin, rows), filter_, method="idm-iv")
    check_same_instruments(streamed, emps2015, replace(twin, sample_period=None), filter_)
    assert "simulation error" in str(streamed)
    assert "instruments, control law" not in str(streamed)


@pytest.mark.slow
@pytest.mark.parametrize("place", ["control", "reference"])
def test_test_signal_enters_the_loop_of_blocks_as_that_of_the_whole(
    emps: GeneratedAxis, place: str, tmp_path: Path, rng: np.random.Generator
) -> None:
    pa = pytest.importorskip("pyarrow")
    time = 1e-3 * np.arange(6000)
    reference = 0.05 * (1 - np.cos(3 * time)) + 0.02 * (1 - np.cos(5 * time))
    added = 0.05 * np.sin(40 * time) if place == "control" else 1e-4 * np.sin(60 * time)
    loop = simulate(
        emps,
        [95.0, 203.0, 20.0, -3.0],
        reference + added if place == "reference" else reference,
        1e-3,
        injected=added if place == "control" else None,
        position_noise=1e-6 * rng.standard_normal(len(time)),
    )
    record = Record(
        time=time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
        injected=added,
        injected_at=place,
    )
    file, columns = tmp_path / "log.parquet", record.channels()
    pytest.importorskip("pyarrow.parquet").write_table(pa.table(columns), file)
    named = {role: role for role in columns}
    blocks = LogBlocks(file=file, axis=emps, columns=named, rows=2500, injected_at=place)
    whole = identify(emps, record, methods=["idm-iv"])["idm-iv"]
    streamed = identify_stream(emps, blocks, method="idm-iv")
    assert streamed.physical == pytest.approx(whole.physical, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["valve", "servo_joint", "crank"])
def test_instruments_of_blocks_for_drives_that_lag_and_axes_with_kinks(name: str) -> None:
    axis = build(load_axis(name))
    record = twin_record(axis, seed=1)
    whole = identify(axis, record, methods=["idm-iv"])["idm-iv"]
    streamed = identify_stream(
        axis, all_in_blocks(record, 4999), method="idm-iv", sample_period=record.sample_period
    )
    assert streamed.physical == pytest.approx(whole.physical, rel=1e-9)


def test_instruments_that_blocks_cannot_have_are_refused(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    blocks = all_in_blocks(twin, 5000)
    with refuses("no-reference"):
        identify_stream(emps2015, in_blocks(twin, 5000), method="idm-iv")
    with refuses("method-in-blocks", says="choose from idm-ls, idm-iv"):
        identify_stream(emps2015, blocks, method="ddm-iv")
    slower = [{role: v[::2] for role, v in block.items()} for block in blocks]
    with refuses("loop-clocks-in-blocks", says="at the samples of its law"):
        identify_stream(emps2015, slower, Prefilter(cutoff=40.0), method="idm-iv")
