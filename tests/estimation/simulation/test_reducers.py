"""Batches that are reduced as they are simulated."""

import tracemalloc
from typing import Any

import numpy as np
import pytest

from axisid import build, load_axis
from axisid.estimation import LaneBlock, simulate_batch
from axisid.estimation.simulation import BatchSimulation, batch as batch_module
from tests.refusals import refuses

PERIOD = 1e-3
TIME = PERIOD * np.arange(400)
REFERENCE = 0.02 * np.sin(2 * np.pi * TIME / 0.4)
LANES = 70
WANTED = ("position", "force")


def run(reduce: Any = None, wanted: tuple[str, ...] = WANTED) -> BatchSimulation:
    """Lanes of which two have no mass."""
    axis, rng = build(load_axis("emps2015")), np.random.default_rng(1)
    sets = axis.nominal * (1 + 0.05 * rng.normal(size=(LANES, len(axis.nominal))))
    sets[[3, 66], 0] = -1.0
    return simulate_batch(axis, sets, REFERENCE, PERIOD, wanted=wanted, reduce=reduce, threads=1)


def last(block: LaneBlock) -> dict[str, np.ndarray]:
    """Of each signal; a row for each lane."""
    return {f"last_{name}": values[-1] for name, values in block.signals.items()}


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory for one block of 32 lanes, so that a batch of 70 has three."""
    monkeypatch.setattr(batch_module, "_KEPT", 1)


@pytest.mark.usefixtures("small_blocks")
def test_what_is_kept_of_blocks_is_that_of_the_whole_each_lane_once_in_order() -> None:
    seen: list[tuple[int, int]] = []

    def noted(block: LaneBlock) -> dict[str, np.ndarray]:
        seen.append((block.first, block.lanes))
        assert block.period == PERIOD
        assert np.array_equal(block.reference, REFERENCE)
        return {**last(block), "ends": block.signals["position"][[0, -1]].T}

    whole, kept = run(), run(noted)
    assert seen == [(0, 32), (32, 32), (64, 6)]
    assert kept.signals == {}
    assert np.array_equal(kept["ends"], whole["position"][[0, -1]].T, equal_nan=True)
    assert np.array_equal(kept["last_force"], whole["force"][-1], equal_nan=True)
    assert list(kept.failures) == np.flatnonzero(np.isnan(kept["last_force"])).tolist() == [3, 66]


def test_memory_does_not_grow_with_the_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_module, "_KEPT", 1)
    axis, peaks = build(load_axis("emps2015")), []
    for lanes in (64, 640):
        sets = np.tile(axis.nominal, (lanes, 1))
        tracemalloc.start()
        simulate_batch(axis, sets, REFERENCE, PERIOD, reduce=last, threads=1)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0]


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("reduce", "wanted"),
    [
        (last, ()),
        (lambda block: block.signals["force"][-1], WANTED),
        (lambda block: {"last": block.signals["force"][-1, :2]}, WANTED),
        (lambda block: {f"of_{block.first}": np.zeros(block.lanes)}, WANTED),
        (lambda block: {"all": np.zeros((block.lanes, block.lanes))}, WANTED),
    ],
)
def test_what_gives_no_numbers_of_lanes_by_name_is_refused(
    reduce: Any, wanted: tuple[str, ...]
) -> None:
    with refuses("simulation-input"):
        run(reduce, wanted)
