"""Spikes are told with their row, time and size; right signals have none."""

import numpy as np
import pytest

from axisid import Record, identify, read_record, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Repairs
from axisid.estimation.records.clipping import spikes


@pytest.mark.parametrize("noise", [None, 0.0])
def test_right_signals_have_no_spikes(library_axis: GeneratedAxis, noise: float | None) -> None:
    record = twin_record(library_axis, position_noise=noise, seed=5)
    for values in (record.position, np.asarray(record.control)):
        for quantum in (0.0, 1e-5, float(np.abs(values).max()) / 2048):
            assert spikes(quantum * np.round(values / quantum) if quantum else values) == []


def test_real_records_have_no_spikes(emps_record: Record) -> None:
    assert spikes(emps_record.position) == spikes(np.asarray(emps_record.control)) == []


def test_bounces_steps_and_kinks_are_no_spikes() -> None:
    time = np.linspace(0, 1, 2000)
    for signal in (np.abs(time - 0.5), np.sign(time - 0.5), np.maximum(time - 0.5, 0)):
        assert spikes(signal) == []
    resting = np.zeros(2000)
    resting[1000:1010] = np.hanning(10)
    assert spikes(resting) == []


@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("size", [-0.02, 0.001])
def test_spikes_are_found_with_their_size(twin: Record, width: int, size: float) -> None:
    spoilt = twin.position.copy()
    for row in (900, 4130):
        spoilt[row : row + width] += size
    found = spikes(spoilt)
    assert {row // 10 for row, _ in found} == {90, 413}
    assert all(found_size == pytest.approx(size, rel=0.1) for _, found_size in found)


def test_spikes_are_told_with_row_time_and_a_way_out(emps2015: GeneratedAxis, twin: Record) -> None:
    columns = {role: values.copy() for role, values in twin.channels().items()}
    columns["position"][[500, 1500, 2500, 4130]] += [0.001, 0.002, 0.003, 0.004]
    (note,) = read_record(columns, emps2015).provenance.doubts
    told = note
    assert told.startswith("the position leaves its course for a moment, by +0.00")
    assert "m in data row 4131 at 4.13 s, by +0.00" in told
    assert "and 1 more times" in told
    assert told.endswith('resample="auto"')
    columns["position"][[500, 1500, 2500, 4130]] = np.nan
    mended = read_record(columns, emps2015, repairs=Repairs(resample="auto"))
    assert mended.provenance.doubts == ()
    found = identify(emps2015, mended, methods=["idm-ls"])["idm-ls"].physical
    right = identify(emps2015, twin, methods=["idm-ls"])["idm-ls"].physical
    assert found == pytest.approx(right, rel=2e-3)


@pytest.mark.slow
def test_a_spike_is_named_with_its_signal_sample_and_size_and_nothing_else_is(
    emps: GeneratedAxis,
) -> None:
    twin = twin_record(emps, seed=1)
    spoilt = twin.position.copy()
    spoilt[4130] += 0.001
    record = Record(time=twin.time, position=spoilt, control=twin.control)
    result = identify(emps, record, methods=["idm-ls"])
    (check,) = (c for c in result.verdict if c.name == "outliers")
    assert check.status == "fail"
    size = check.meaning.removeprefix("the position leaves its course by ").split()[0]
    assert float(size) == pytest.approx(0.001, rel=0.1)
    assert "at sample 4131, 4.13 s after the first" in check.meaning
    assert [c.name for c in result.verdict if c.status == "fail"] == ["outliers"]
