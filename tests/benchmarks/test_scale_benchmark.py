"""The benchmark of fleets, in small: what is killed and corrupt costs nothing else."""

import pytest
import scale


@pytest.mark.slow
def test_a_fleet_with_corrupt_logs_and_a_killed_worker_is_complete() -> None:
    figures = scale.fleet_figures(9, 1)
    assert (figures["fleet_results"], figures["fleet_reasons"]) == (6, 3)
    assert figures["fleet_logs_per_s_per_core"] > 0
