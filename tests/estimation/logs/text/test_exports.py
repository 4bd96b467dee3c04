"""Text of TwinCAT Scope and LabVIEW, built as manuals and real exports have it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs
from axisid.estimation.logs.text.reader import read_text
from tests.files import text_file
from tests.refusals import refuses

N = 60
TIME = np.arange(N, dtype=float)  # ms
ACTUAL = 1e3 * np.sin(TIME / 7)
TARGET = 1e3 * np.cos(TIME / 7)
START = 132959733843760000  # units of 100 ns since 1601


def export(
    channels: Sequence[tuple[str, str, np.ndarray, int]],
    *,
    separator: str = "\t",
    comma: bool = True,
    shared: bool = False,
    full: bool = False,
    end: bool = False,
) -> str:
    """Text of an export.

    Parameters
    ----------
    channels
        Name, unit, values and sample time in ms of each.
    shared
        One time column for neighbours of one sample time (Timelines: For each sampletime).
    full
        Time stamps since 1601.
    """
    heads = {
        label: []
        for label in ("Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "ScaleFactor")
    } | {"Offset": [], "Unit": []}
    columns: list[list[str]] = []
    last = -1
    for name, unit, values, step in channels:
        if not shared or step != last:
            for label, cells in heads.items():
                cells.append(label)
            stamps = [START + 10_000 * step * k for k in range(len(values))]
            columns.append([str(t) if full else str(step * k) for k, t in enumerate(stamps)])
        last = step
        for cells, cell in zip(
            heads.values(), (name, "", "REAL64", str(step), "1", "0", unit), strict=True
        ):
            cells.append(cell)
        columns.append([f"{v:.17g}".replace(".", "," if comma else ".") for v in values])
    rows = max(len(column) for column in columns)
    body = [separator.join(c[k] if k < len(c) else "" for c in columns) for k in range(rows)]
    lines = [
        separator.join(["Name", "Scope Project"]),
        separator.join(["File", r"D:\logs\scope.csv"]),
        separator.join(["Starttime of export", str(START), "Montag, 2. Mai 2022", "15:56:24.376"]),
        separator.join(
            ["Endtime of export", str(START + 10_000 * (N - 1)), "Montag", "15:56:25.375"]
        ),
        "",
        "",
        *(separator.join(cells) for cells in heads.values()),
        "",
        *body,
        *(["EOF"] if end else []),
    ]
    return "\r\n".join(lines) + "\r\n"


COLUMNS = {"position": "Axis.ActPos", "reference": "Axis.SetPos"}
CHANNELS = [
    ("Axis.ActPos", "mm (Length)", ACTUAL, 1),
    ("Axis.SetPos", "mm (Length)", TARGET, 1),
]


@pytest.mark.parametrize("separator", ["\t", ";"])
@pytest.mark.parametrize("comma", [True, False])
@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("full", [True, False])
def test_time_values_and_units_are_those_of_the_export(
    tmp_path: Path, separator: str, comma: bool, shared: bool, full: bool
) -> None:
    text = export(CHANNELS, separator=separator, comma=comma, shared=shared, full=full, end=True)
    record = read_record(text_file(tmp_path / "scope.csv", text), columns=COLUMNS)
    assert record.time == pytest.approx(1e-3 * TIME, abs=1e-12)
    assert record.position == pytest.approx(1e-3 * ACTUAL, rel=1e-15)
    assert record.reference == pytest.approx(1e-3 * TARGET, rel=1e-15)
    assert "position: mm -> m" in record.provenance.assumed
    named = "tab" if separator == "\t" else "semicolon"
    (note,) = (note for note in record.provenance.assumed if "TwinCAT Scope" in note)
    assert note.endswith(f"separator {named}, decimal {'comma' if comma else 'point'}")


def without(text: str, *labels: str) -> str:
    """An export without some rows of its heads."""
    return "".join(line for line in text.splitlines(True) if line.split("\t")[0] not in labels)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize(
    "left_out",
    [
        ("SymbolComment", "Data-Type", "SampleTime[ms]", "ScaleFactor", "Offset", "Unit"),
        ("SymbolComment", "SampleTime[ms]", "ScaleFactor", "Offset", "File"),
        ("SampleTime[ms]", "File", "Starttime of export", "Endtime of export"),
    ],
)
def test_heads_may_have_few_rows(tmp_path: Path, left_out: tuple[str, ...], shared: bool) -> None:
    text = without(export(CHANNELS, shared=shared), *left_out)
    columns = {role: f"{name}:mm" for role, name in COLUMNS.items()}
    record = read_record(text_file(tmp_path / "scope.csv", text), columns=columns)
    assert record.time == pytest.approx(1e-3 * TIME, abs=1e-12)
    assert record.position == pytest.approx(1e-3 * ACTUAL, rel=1e-15)


def test_other_text_that_begins_with_a_name_is_none() -> None:
    content = "Name;bench\nSampleTime;0.001\nt;pos\n" + "\n".join(f"{k};{k}" for k in range(9))
    assert list(read_text("log.csv", content.encode()).columns) == ["t", "pos"]
    alone = "Name\n" + "\n".join(map(str, range(9)))
    assert list(read_text("log.csv", alone.encode()).columns) == ["Name"]


def test_rows_filled_with_the_previous_value_are_left_out_and_counted(tmp_path: Path) -> None:
    slow = np.repeat(TARGET[::5], 5)
    text = export([CHANNELS[0], ("Axis.SetPos", "mm (Length)", slow, 1)])
    first = text.index("\r\n0\t") + 2
    rows = [line.split("\t") for line in text[first:].splitlines()]
    filled = [[*row[:2], str(5 * (k // 5)), row[3]] for k, row in enumerate(rows)]
    file = text_file(
        tmp_path / "scope.csv", text[:first] + "\n".join("\t".join(row) for row in filled)
    )
    record = read_record(file, columns=COLUMNS, repairs=Repairs(resample="auto"))
    assert record.reference == pytest.approx(1e-3 * TARGET[:56], abs=1e-2)
    told = "Axis.SetPos: 48 repetitions of the last time and value are left out"
    assert told in record.provenance.assumed


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda text: text[: text.index("0\t0\t") - 2], "log-text"),
        (lambda text: text.replace("\r\n5\t", "\r\nx5\t"), "log-text"),
        (lambda text: text.replace("\r\n5\t", "\r\n5\t1\t1\t1\t1\t"), "log-text"),
        (
            lambda text: text.replace("Axis.SetPos", "Axis.ActPos"),
            "columns",
        ),
    ],
)
def test_damaged_exports_are_explained(tmp_path: Path, change, code: str) -> None:  # type: ignore[no-untyped-def]
    with refuses(code):
        read_record(text_file(tmp_path / "scope.csv", change(export(CHANNELS))), columns=COLUMNS)


VI_COLUMNS = {"time": "X_Value", "position": "pos", "control": "cur"}

VI_HEADS = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
X_Columns\tOne
Date\t2026/02/01
Time\t12:00:00,1234567
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t50\t50\t
Time\t12:00:00,1234567\t12:00:00,1234567\t
Y_Unit_Label\tmm\tVolts\t
X0\t0,0E+0\t0,0E+0\t
Delta_X\t1,0E-3\t1,0E-3\t
***End_of_Header***\t\t\t
"""


def lvm(file: Path, first: str = "", end: str = "", name: str = "\tComment") -> Path:
    """A file whose first row ends in `first`, every other in `end`."""
    rows = [
        f"{1e-3 * t:.6f}\t{q:.9f}\t{k % 7}".replace(".", ",") + (end if k else first)
        for k, (t, q) in enumerate(zip(TIME[:50], ACTUAL[:50], strict=True))
    ]
    file.write_text("\n".join([f"{VI_HEADS}X_Value\tpos\tcur{name}", *rows]) + "\n")
    return file


@pytest.mark.parametrize(
    ("first", "end", "name"),
    [
        ("", "", "\tComment"),
        ("\t", "\t", "\tComment"),
        ("\tstart; 7", "", "\tComment"),
        ("\tstart", "\t", "\tComment"),
        ("", "", ""),
    ],
)
def test_comments_are_passed_over_and_units_are_those_of_the_head(
    tmp_path: Path, first: str, end: str, name: str
) -> None:
    record = read_record(lvm(tmp_path / "log.lvm", first, end, name), columns=VI_COLUMNS)
    assert record.time == pytest.approx(1e-3 * TIME[:50], abs=1e-12)
    assert record.position == pytest.approx(1e-3 * ACTUAL[:50], abs=1e-12)
    assert "position: mm -> m" in record.provenance.assumed


def test_file_without_samples_is_refused(tmp_path: Path) -> None:
    file = text_file(tmp_path / "log.lvm", VI_HEADS)
    with refuses("log-text"):
        read_record(file)
