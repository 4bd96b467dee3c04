"""Exports of TwinCAT Scope, built as its manual and its real exports have them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from axisid import DataError, Repairs, read_record

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
        separator.join(["Endtime of export", str(START + 10_000_000), "Montag", "15:56:25.375"]),
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


def log(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "scope.csv"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize("separator", ["\t", ";"])
@pytest.mark.parametrize("comma", [True, False])
@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("full", [True, False])
def test_time_values_and_units_are_those_of_the_export(
    tmp_path: Path, separator: str, comma: bool, shared: bool, full: bool
) -> None:
    text = export(CHANNELS, separator=separator, comma=comma, shared=shared, full=full, end=True)
    record = read_record(log(tmp_path, text), columns=COLUMNS)
    assert record.time == pytest.approx(1e-3 * TIME, abs=1e-12)
    assert record.position == pytest.approx(1e-3 * ACTUAL, rel=1e-15)
    assert record.reference == pytest.approx(1e-3 * TARGET, rel=1e-15)
    assert "position: mm -> m" in record.provenance.assumed
    named = "tab" if separator == "\t" else "semicolon"
    (note,) = (note for note in record.provenance.assumed if "TwinCAT Scope" in note)
    assert note.endswith(f"separator {named}, decimal {'comma' if comma else 'point'}")


def test_encoding_of_an_export_is_told(tmp_path: Path) -> None:
    file = tmp_path / "scope.csv"
    file.write_text(export(CHANNELS), encoding="utf-16")
    record = read_record(file, columns=COLUMNS)
    assert "encoding utf-16" in record.provenance.assumed


def test_channels_of_other_rates_are_resampled_on_request_only(tmp_path: Path) -> None:
    text = export([CHANNELS[0], ("Axis.SetPos", "mm (Length)", TARGET[::5], 5)])
    file = log(tmp_path, text)
    with pytest.raises(DataError, match=r"position 60, reference 12.*--resample auto"):
        read_record(file, columns=COLUMNS)
    record = read_record(file, columns=COLUMNS, repairs=Repairs(resample="auto"))
    assert record.period == pytest.approx(1e-3)
    assert len(record) == 56  # up to the last sample of the slower channel
    assert record.reference == pytest.approx(1e-3 * TARGET[:56], abs=1e-2)
    assert record.provenance.repairs[0].count == 56


def test_unit_none_is_no_unit_and_a_scale_factor_is_told(tmp_path: Path) -> None:
    text = export([("Axis.ActPos", "(None)", ACTUAL, 1)]).replace(
        "ScaleFactor\t1", "ScaleFactor\t-1"
    )
    record = read_record(log(tmp_path, text), columns={"position": "Axis.ActPos:mm"})
    assert record.position == pytest.approx(1e-3 * ACTUAL)
    assert any("scale factor and offset" in note for note in record.provenance.assumed)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text[: text.index("0\t0\t") - 2], "no samples below its heads"),
        (lambda text: text.replace("\r\n5\t", "\r\nx5\t"), "line 20: 'x5' is not a number"),
        (lambda text: text.replace("\r\n5\t", "\r\n5\t1\t1\t1\t1\t"), "line 20: more than the 4"),
        (
            lambda text: text.replace("Axis.SetPos", "Axis.ActPos"),
            "'Axis.ActPos' for the position.*one name",
        ),
    ],
)
def test_damaged_exports_are_explained(tmp_path: Path, change, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(DataError, match=message):
        read_record(log(tmp_path, change(export(CHANNELS))), columns=COLUMNS)
