"""The benchmark of fleets, in small: what is killed and corrupt costs nothing else."""

import long_logs
import pytest
import scale


@pytest.mark.slow
def test_a_fleet_with_corrupt_logs_and_a_killed_worker_is_complete() -> None:
    figures = scale.fleet_figures(9, 1)
    assert (figures["fleet_results"], figures["fleet_reasons"]) == (6, 3)
    assert figures["fleet_logs_per_s_per_core"] > 0


@pytest.mark.slow
def test_a_long_log_has_its_speed_and_its_memory() -> None:
    (row,) = long_logs.measured([2_000])
    assert row["seconds"] > 0
    assert 50 < row["peak_mb"] < 2000
    assert row["samples"] == 2_000
    assert row["M"] == pytest.approx(95.0, rel=0.1)
