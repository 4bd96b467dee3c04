"""TDMS files are read with their waveforms and warnings."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs
from tests.estimation.logs.samples import NAMED, Q, U
from tests.refusals import refuses


def tdms(file: Path, **channels: tuple[Any, dict[str, Any]]) -> Path:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(file)) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("axis", name, *each) for name, each in channels.items()]
        )
    return file


def test_tdms_waveforms_keep_the_time_between_their_starts(tmp_path: Path) -> None:
    start = np.datetime64("2026-02-01T12:00:00", "us")
    first, later = (
        {"wf_increment": 1e-3, "wf_start_time": start + np.timedelta64(delay, "us")}
        for delay in (0, 10_000)
    )
    file = tdms(
        tmp_path / "log.tdms",
        q=(1e3 * Q, {**first, "unit_string": "mm"}),
        u=(U, later),
        v=(U, {"wf_increment": 1e-3}),
    )
    with refuses("time", says="position and the control"):
        read_record(file, columns=NAMED)
    record = read_record(file, columns=NAMED, repairs=Repairs(resample=1000.0))
    assert record.position == pytest.approx(Q[10:], abs=1e-9)
    assert record.control == pytest.approx(U[:-10], abs=1e-9)
    timeless = read_record(file, columns={"position": "q", "control": "v"})
    assert any("no wf_start_time" in note for note in timeless.provenance.assumed)


def test_tdms_that_breaks_off_says_so(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tdms(tmp_path / "log.tdms", q=(Q, {}))
    file.write_bytes(file.read_bytes()[:-80])
    record = read_record(file, columns={"position": "q"}, sample_period=1e-3)
    assert np.array_equal(record.position, Q[:-10])
    assert "less data than expected" in record.provenance.assumed[0]
    assert capfd.readouterr().err == ""
