"""A log in blocks is the log read whole: values, names, and what is assumed of it."""

import gzip
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from axisid.codegen import GeneratedAxis
from axisid.estimation import LogBlocks
from axisid.estimation.records.blocks import extent
from tests.refusals import refuses

N = 400
TIME = 1e-3 * np.arange(N)
POSITION = np.sin(30 * TIME)
COLUMNS = {"time": "t", "position": "q"}


def check_agreement(file: Path, columns: dict[str, str], rows: int = 37) -> None:
    """Blocks of a file hold what its record holds."""
    record = read_record(file, columns=columns)
    blocks = LogBlocks(file=file, columns=columns, rows=rows)
    read = list(blocks)
    for role in columns:
        joined = np.concatenate([block[role] for block in read])
        assert joined == pytest.approx(record.channels()[role], rel=1e-12, abs=1e-12)
    assert blocks.provenance().assumed == record.provenance.assumed
    assert blocks.provenance().doubts == record.provenance.doubts


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_names_that_differ_by_the_unit_only_are_told_apart(tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"log{ending}"
    columns = {"t [s]": TIME, "q [mm]": POSITION, "q [m]": 7 * POSITION}
    if ending == ".csv":
        rows = [";".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)]
        file.write_text("\n".join([";".join(columns), *rows]))
    else:
        pa = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(pa.table(columns), file)
    wanted = {"time": "t", "position": "q [mm]"}
    check_agreement(file, wanted)
    (first, *_) = LogBlocks(file=file, columns=wanted)
    assert first["position"] == pytest.approx(1e-3 * POSITION)


def test_an_axis_may_be_declared_or_generated(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["t;q", *rows_of_text()]))
    by_either = [
        LogBlocks(file=file, axis=axis, columns=COLUMNS) for axis in (emps2015, emps2015.axis)
    ]
    generated, declared = (next(iter(blocks)) for blocks in by_either)
    assert by_either[0] == by_either[1]
    assert generated.keys() == declared.keys()
    assert np.array_equal(generated["position"], declared["position"])


def rows_of_text() -> list[str]:
    return [f"{t:.3f};{float(q)!r}" for t, q in zip(TIME, POSITION, strict=True)]


def test_comments_may_stand_where_a_block_begins(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = rows_of_text()
    for k in range(N - N % 37, 0, -37):
        rows.insert(k, "# marker; 7")
    file.write_text("\n".join(["t;q", *rows]))
    check_agreement(file, COLUMNS, rows=1)
    check_agreement(file, COLUMNS, rows=38)


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16-le", "utf-16-be"])
def test_encodings_are_those_of_the_whole_log(tmp_path: Path, encoding: str, mark: str) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes("\n".join([f"{mark}t;q", *rows_of_text()]).encode(encoding))
    check_agreement(file, COLUMNS)


def test_letter_that_tells_the_encoding_may_come_late(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = [f"{row};{'x' * 4000}{'ä' if k > 350 else ''}" for k, row in enumerate(rows_of_text())]
    file.write_text("\n".join(["t;q;state", *rows]), encoding="cp1252")
    check_agreement(file, COLUMNS)
    assert "encoding cp1252" in LogBlocks(file=file, columns=COLUMNS).provenance().assumed


def test_time_stamps_count_from_the_first_of_all_blocks(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = [f"2026-02-01 12:00:0{row}" for row in rows_of_text()]
    file.write_text("\n".join(["t;q", *rows]))
    check_agreement(file, COLUMNS)
    told = LogBlocks(file=file, columns=COLUMNS).provenance().assumed
    assert "t: time stamps counted from the first" in told


def test_gap_is_one_of_the_whole_log_though_the_first_block_is_slower() -> None:
    steps = np.where(np.arange(60_000) < 1000, 1.4e-3, 1e-3)
    steps[50_000] = 1.8e-3  # no gap beside the first block's steps
    time = np.cumsum(steps)
    blocks = [
        {"time": time[k : k + 1000], "position": np.sin(time[k : k + 1000])}
        for k in range(0, len(time), 1000)
    ]
    with refuses("uneven-time", says=r"0\.001 to 0\.0018 s, 0\.001"):
        extent("log", blocks, None)


def test_a_long_table_is_refused_in_blocks_with_what_to_do(tmp_path: Path) -> None:
    file = tmp_path / "long.csv"
    rows = [f"{t:.3f},{name},{t:.3f}" for t in TIME for name in ("position", "control")]
    file.write_text("\n".join(["time,name,value", *rows]))
    with refuses("long-in-blocks", "(time, name, value)") as refused:
        list(LogBlocks(file=file))
    assert "write a column for each signal" in str(refused.value)


def write_matlab(file: Path, columns: dict[str, np.ndarray]) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w", userblock_size=512) as content:
        for name, values in columns.items():
            content.create_dataset(name, data=values[None, :])
    with file.open("r+b") as head:
        head.write(b"MATLAB 7.3 MAT-file".ljust(512))


def write_tdms(file: Path, columns: dict[str, np.ndarray]) -> None:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(file)) as writer:
        for begin in range(0, N, 150):
            channels = [
                nptdms.ChannelObject("g", name, values[begin : begin + 150], {"unit_string": "mm"})
                for name, values in columns.items()
            ]
            writer.write_segment(channels)


def write_mdf(file: Path, columns: dict[str, np.ndarray]) -> None:
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([asammdf.Signal(v, TIME, name=n, unit="mm") for n, v in columns.items()])
        mdf.save(file)


@pytest.mark.parametrize(
    ("name", "write"), [("a.mat", write_matlab), ("a.tdms", write_tdms), ("a.mf4", write_mdf)]
)
def test_formats_whose_rows_can_be_read_in_order_are_read_in_blocks(
    tmp_path: Path, name: str, write: Callable[[Path, dict[str, np.ndarray]], None]
) -> None:
    file, named = tmp_path / name, {"position": "q"}
    write(file, {"q": POSITION, "other": 2 * POSITION})
    whole = read_record(file, columns=named, sample_period=1e-3)
    blocks = LogBlocks(file=file, columns=named, rows=37)
    read = list(blocks)
    assert np.array_equal(np.concatenate([b["position"] for b in read]), whole.position)
    assert max(len(b["position"]) for b in read) == 37
    told = blocks.provenance()
    assert (told.assumed, told.sha256) == (whole.provenance.assumed, whole.provenance.sha256)


def gzipped(text: str) -> bytes:
    return gzip.compress(text.encode())


def zstandardized(text: str) -> bytes:
    return bytes(pytest.importorskip("pyarrow").compress(text.encode(), "zstd", asbytes=True))


@pytest.mark.parametrize(("ending", "pack"), [(".gz", gzipped), (".zst", zstandardized)])
def test_packed_text_is_unpacked_block_by_block(
    tmp_path: Path, ending: str, pack: Callable[[str], bytes]
) -> None:
    file = tmp_path / f"log.csv{ending}"
    file.write_bytes(pack("\n".join(["t;q", *rows_of_text(), ""])))
    check_agreement(file, COLUMNS)
    blocks = LogBlocks(file=file, columns=COLUMNS, rows=50)
    assert len(list(blocks)) == 8
    assert blocks.provenance().sha256 == read_record(file, columns=COLUMNS).provenance.sha256
    lines = tmp_path / f"log.jsonl{ending}"
    lines.write_bytes(pack("\n".join(lines_of_records())))
    check_agreement(lines, {"time": "t", "position": "drive.q"})


def test_a_packed_log_that_is_cut_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.csv.gz"
    file.write_bytes(gzipped("\n".join(["t;q", *rows_of_text()]))[:-100])
    with refuses("damaged-packing"):
        list(LogBlocks(file=file, columns=COLUMNS))


def lines_of_records() -> list[str]:
    each = zip(TIME.tolist(), POSITION.tolist(), strict=True)
    return [json.dumps({"t": t, "drive": {"q": q}, "state": "on"}) for t, q in each]


@pytest.mark.parametrize("rows", [1, 37, 1000])
def test_lines_of_json_are_read_in_blocks(tmp_path: Path, rows: int) -> None:
    file = tmp_path / "log.jsonl"
    file.write_text("\n".join(["", *lines_of_records(), ""]))
    check_agreement(file, {"time": "t", "position": "drive.q"}, rows)


def test_rows_of_json_have_their_names_in_the_first_line_alone(tmp_path: Path) -> None:
    file = tmp_path / "log.ndjson"
    each = zip(TIME.tolist(), POSITION.tolist(), strict=True)
    file.write_text("\n".join(map(json.dumps, [["t", "q [mm]"], *map(list, each)])))
    check_agreement(file, COLUMNS)
    (first, *_) = LogBlocks(file=file, columns=COLUMNS, rows=50)
    assert first["position"] == pytest.approx(1e-3 * POSITION[:49])


def test_stamps_of_json_count_from_the_first_of_all_blocks(tmp_path: Path) -> None:
    file = tmp_path / "log.jsonl"
    each = zip(TIME.tolist(), POSITION.tolist(), strict=True)
    stamped = [{"t": f"2026-02-01T12:00:0{t:.3f}", "q": q} for t, q in each]
    file.write_text("\n".join(map(json.dumps, stamped)))
    check_agreement(file, COLUMNS)


def test_what_a_line_of_json_lacks_is_told_as_of_the_whole_log(tmp_path: Path) -> None:
    file = tmp_path / "log.jsonl"
    lines = lines_of_records()
    for place, line, code in ((150, "{", "no-json"), (150, "x" * 1_000_001, "json-long-line")):
        file.write_text("\n".join([*lines[:place], line, *lines[place:]]))
        with refuses(code):
            list(LogBlocks(file=file, columns={"time": "t", "position": "drive.q"}, rows=100))
    file.write_text("\n".join([*lines[:200], *(['{"t": 1}'] * 200)]))
    blocks = list(LogBlocks(file=file, columns={"time": "t", "position": "drive.q"}, rows=100))
    assert np.isnan(blocks[-1]["position"]).all()


def test_clock_of_the_channels_is_the_time_of_a_block(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    file = tmp_path / "log.mf4"
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([asammdf.Signal(POSITION, TIME, name="q")])
        mdf.append([asammdf.Signal(POSITION, TIME + 1e-4, name="u")])
        mdf.save(file)
    (first, *_) = LogBlocks(file=file, columns={"position": "q"}, rows=100)
    assert np.array_equal(first["time"], TIME[:100])
    with refuses("clocks-in-blocks", says="at times of their own"):
        list(LogBlocks(file=file, columns={"position": "q", "control": "u"}))


def test_what_is_read_whole_only_is_refused_with_the_reason(tmp_path: Path) -> None:
    whole = {
        "a.npz": "one after the other",
        "a.json": "it is one value",
        "a.parquet.gz": "unpack it first",
    }
    for name, why in whole.items():
        with refuses("not-in-blocks", says=why):
            list(LogBlocks(file=tmp_path / name))
    old = tmp_path / "old.mat"
    old.write_bytes(b"MATLAB 5.0 MAT-file".ljust(128) + bytes(64))
    with refuses("matlab-in-blocks", says="packed as a whole"):
        list(LogBlocks(file=old))
    short = tmp_path / "short.mat"
    write_matlab(short, {"t": TIME, "q": POSITION[:-10]})
    with refuses("lengths-in-blocks", says="time 400, position 390"):
        list(LogBlocks(file=short, columns=COLUMNS))
