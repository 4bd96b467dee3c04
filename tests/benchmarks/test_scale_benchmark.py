"""The benchmark of fleets, in small: what is killed and corrupt costs nothing else."""

import pytest
import scale
import streams


@pytest.mark.slow
def test_a_fleet_with_corrupt_logs_and_a_killed_worker_is_complete() -> None:
    figures = scale.fleet_figures(9, 1)
    assert (figures["fleet_results"], figures["fleet_reasons"]) == (6, 3)
    assert figures["fleet_logs_per_s_per_core"] > 0


@pytest.mark.slow
def test_a_log_in_blocks_has_its_speed_and_its_memory() -> None:
    figures = streams.figures(20_000)
    assert figures["stream_samples"] == 20_000
    assert figures["stream_msamples_per_s"] > 0
    assert 50 < figures["peak_mb_stream"] < 2000


@pytest.mark.slow
def test_a_log_is_read_and_judged_as_a_whole() -> None:
    (row,) = streams.measured([2_000], streams.WHOLE)
    assert row["samples"] == 2_000
    assert row["M"] == pytest.approx(95.0, rel=0.1)
