"""Batches that are reduced as they are simulated."""

import tracemalloc

import numpy as np
import pytest

from axisid import build, load_axis
from axisid.estimation import LaneBlock, simulate_batch
from axisid.estimation.simulation import batch as batch_module
from tests.refusals import refuses

PERIOD = 1e-3
TIME = PERIOD * np.arange(400)
REFERENCE = 0.02 * np.sin(2 * np.pi * TIME / 0.4)
LANES = 70
WANTED = ("position", "force")


def run(reduce=None, *, wanted=WANTED, lanes=LANES, reference=REFERENCE, axis="emps2015", **how):
    made = build(load_axis(axis))
    rng = np.random.default_rng(1)
    sets = made.nominal * (1 + 0.05 * rng.normal(size=(lanes, len(made.nominal))))
    noise = 1e-6 * rng.normal(size=(len(reference), lanes))
    given = {"position_noise": noise, "wanted": wanted, "reduce": reduce} | how
    return simulate_batch(made, sets, reference, given.pop("period", PERIOD), **given)


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory for one block of 32 lanes, so that a batch of 70 has three."""
    monkeypatch.setattr(batch_module, "_KEPT", 1)


def rms(block: LaneBlock) -> dict[str, np.ndarray]:
    """Of each signal; a row for each lane, so that a lane is summed alike in whatever company."""
    rows = {name: np.ascontiguousarray(values.T) for name, values in block.signals.items()}
    return {f"rms_{name}": np.sqrt(np.mean(values**2, axis=1)) for name, values in rows.items()}


def last(block: LaneBlock) -> dict[str, np.ndarray]:
    return {f"last_{name}": values[-1] for name, values in block.signals.items()}


@pytest.mark.usefixtures("small_blocks")
def test_what_is_kept_of_blocks_is_that_of_the_whole() -> None:
    whole, kept = run(), run(rms, threads=1)
    assert kept.signals == {}
    assert list(kept.reduced) == [f"rms_{signal}" for signal in WANTED]
    for signal in WANTED:
        expected = np.sqrt((whole[signal] ** 2).mean(axis=0))
        assert kept[f"rms_{signal}"] == pytest.approx(expected, rel=1e-12, abs=1e-15)
    with pytest.MonkeyPatch.context() as patch:  # the same bits with memory for all lanes at once
        patch.setattr(batch_module, "_KEPT", 2**40)
        assert run(rms) == kept


@pytest.mark.usefixtures("small_blocks")
def test_a_callable_sees_every_lane_once_in_order() -> None:
    seen: list[tuple[int, int]] = []

    def crossings(block: LaneBlock) -> dict[str, np.ndarray]:
        seen.append((block.first, block.lanes))
        assert block.period == PERIOD
        assert block.reference is REFERENCE or np.array_equal(block.reference, REFERENCE)
        turned = np.signbit(block.signals["force"])
        ends = block.signals["position"][[0, -1]].T
        return {"crossings": (turned[1:] != turned[:-1]).sum(axis=0), "ends": ends}

    whole, kept = run(), run(crossings, threads=1)
    assert seen == [(0, 32), (32, 32), (64, 6)]
    assert np.array_equal(kept["ends"], whole["position"][[0, -1]].T)
    turned = np.signbit(whole["force"])
    assert np.array_equal(kept["crossings"], (turned[1:] != turned[:-1]).sum(axis=0))


@pytest.mark.usefixtures("small_blocks")
def test_lanes_that_fail_are_not_a_number_and_keep_their_place() -> None:
    axis = build(load_axis("emps2015"))
    sets = np.tile(axis.nominal, (LANES, 1))
    sets[[3, 66], 0] = -1.0
    made = simulate_batch(axis, sets, REFERENCE, PERIOD, wanted=WANTED, reduce=rms)
    assert list(made.failures) == [3, 66]
    for values in made.reduced.values():
        assert np.flatnonzero(np.isnan(values)).tolist() == [3, 66]


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


def test_signals_are_not_reduced_where_none_is_wanted() -> None:
    with refuses("simulation-input"):
        run(rms, wanted=(), lanes=3)


def test_callables_that_give_no_lanes_by_name_are_refused() -> None:
    with refuses("simulation-input"):
        run(lambda block: block.signals["force"][-1], lanes=3)
    with refuses("simulation-input"):
        run(lambda block: {"last": block.signals["force"][-1, :2]}, lanes=3)


@pytest.mark.usefixtures("small_blocks")
def test_callables_that_give_other_names_or_shapes_of_other_blocks_are_refused() -> None:
    with refuses("simulation-input"):
        run(lambda block: {f"of_{block.first}": np.zeros(block.lanes)}, threads=1)
    with refuses("simulation-input"):
        run(lambda block: {"all": np.zeros((block.lanes, block.lanes))}, threads=1)
