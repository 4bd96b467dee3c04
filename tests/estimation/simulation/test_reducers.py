"""Batches that are reduced as they are simulated."""

import pickle
import tracemalloc

import numpy as np
import pytest

from axisid import UsageError, build, load_axis
from axisid.estimation import BatchSimulation, LaneBlock, simulate_batch
from axisid.estimation.simulation import batch as batch_module
from axisid.estimation.simulation.reducers import checked_reducers
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


EXPECTED = {
    "final": lambda v: v[-1],
    "mean": lambda v: v.mean(axis=0),
    "rms": lambda v: np.sqrt((v**2).mean(axis=0)),
    "peak": lambda v: np.abs(v).max(axis=0),
    "span": lambda v: v.max(axis=0) - v.min(axis=0),
}


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("name", EXPECTED)
def test_named_reducers_of_blocks_are_those_of_the_whole(name: str) -> None:
    whole, kept = run(), run(name, threads=1)
    assert kept.signals == {}
    assert list(kept.reduced) == [f"{name}_{signal}" for signal in WANTED]
    for signal in WANTED:
        expected = EXPECTED[name](whole[signal])
        assert kept[f"{name}_{signal}"] == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert same_for_one_block(name, kept)


def same_for_one_block(name: str, kept: BatchSimulation) -> bool:
    """The same bits with memory for all lanes at once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch_module, "_KEPT", 2**40)
        return run(name) == kept


@pytest.mark.usefixtures("small_blocks")
def test_tracking_errors_are_of_the_position_whether_it_is_wanted_or_not() -> None:
    error = run()["position"] - REFERENCE[:, None]
    kept = run(["max_tracking_error", "rms_tracking_error"], wanted=["force"])
    assert np.array_equal(kept["max_tracking_error"], np.abs(error).max(axis=0))
    assert kept["rms_tracking_error"] == pytest.approx(np.sqrt((error**2).mean(axis=0)))
    assert set(kept.reduced) == {"max_tracking_error", "rms_tracking_error"}


@pytest.mark.usefixtures("small_blocks")
def test_each_lane_has_its_own_reference_noise_and_test_signal() -> None:
    reference = REFERENCE[:, None] * np.linspace(0.5, 1, LANES)
    how = {"reference": reference, "injected": 0.1 * reference / 0.02}
    whole, kept = run(**how), run("max_tracking_error", **how)
    expected = np.abs(whole["position"] - reference).max(axis=0)
    assert np.array_equal(kept["max_tracking_error"], expected)


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

    whole, kept = run(), run([crossings, "final"], threads=1)
    assert seen == [(0, 32), (32, 32), (64, 6)]
    assert np.array_equal(kept["ends"], whole["position"][[0, -1]].T)
    turned = np.signbit(whole["force"])
    assert np.array_equal(kept["crossings"], (turned[1:] != turned[:-1]).sum(axis=0))
    assert np.array_equal(kept["final_force"], whole["force"][-1])


@pytest.mark.usefixtures("small_blocks")
def test_lanes_that_fail_are_not_a_number_and_keep_their_place() -> None:
    axis = build(load_axis("emps2015"))
    sets = np.tile(axis.nominal, (LANES, 1))
    sets[[3, 66], 0] = -1.0
    made = simulate_batch(axis, sets, REFERENCE, PERIOD, wanted=WANTED, reduce=["rms", "final"])
    assert list(made.failures) == [3, 66]
    for values in made.reduced.values():
        assert np.flatnonzero(np.isnan(values)).tolist() == [3, 66]


@pytest.mark.usefixtures("small_blocks")
def test_a_law_at_its_own_clock_is_reduced_at_the_samples_of_the_log() -> None:
    slow = REFERENCE[::4]
    whole = run(reference=slow, period=4 * PERIOD)
    kept = run(["max_tracking_error", "final"], reference=slow, period=4 * PERIOD)
    assert np.array_equal(kept["final_position"], whole["position"][-1])
    error = np.abs(whole["position"] - slow[:, None]).max(axis=0)
    assert np.array_equal(kept["max_tracking_error"], error)


def test_memory_does_not_grow_with_the_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_module, "_KEPT", 1)
    axis, peaks = build(load_axis("emps2015")), []
    for lanes in (64, 640):
        sets = np.tile(axis.nominal, (lanes, 1))
        tracemalloc.start()
        simulate_batch(axis, sets, REFERENCE, PERIOD, reduce="final", threads=1)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0]


def test_a_reduced_batch_comes_back_from_a_pickle() -> None:
    made = run("rms", lanes=3)
    assert pickle.loads(pickle.dumps(made)) == made  # noqa: S301


@pytest.mark.parametrize("wrong", ["median", ["final", "mode"], [], 3, {"a": 1}])
def test_unknown_reducers_are_refused_with_those_that_there_are(wrong: object) -> None:
    with refuses("unknown-reducer", "max_tracking_error"):
        checked_reducers(wrong)  # type: ignore[arg-type]


def test_signals_are_not_reduced_where_none_is_wanted() -> None:
    for reducer in ("mean", lambda block: {"rows": block.parameters}):
        with refuses("reduce-nothing"):
            run(reducer, wanted=(), lanes=3)
    assert [*run("max_tracking_error", wanted=(), lanes=3).reduced] == ["max_tracking_error"]


def test_callables_that_give_no_lanes_by_name_are_refused() -> None:
    with refuses("reduced-names"):
        run(lambda block: block.signals["force"][-1], lanes=3)
    with refuses("reduced-shape"):
        run(lambda block: {"last": block.signals["force"][-1, :2]}, lanes=3)
    with refuses("reduced-twice"):
        run(["final", "final"], lanes=3)


@pytest.mark.usefixtures("small_blocks")
def test_callables_that_give_other_names_or_shapes_of_other_blocks_are_refused() -> None:
    with refuses("reduced-blocks"):
        run(lambda block: {f"of_{block.first}": np.zeros(block.lanes)}, threads=1)
    with refuses("reduced-blocks"):
        run(lambda block: {"all": np.zeros((block.lanes, block.lanes))}, threads=1)


def test_an_error_of_a_callable_is_the_users() -> None:
    def wrong(_: LaneBlock) -> dict[str, np.ndarray]:
        raise UsageError("no such thing")

    with pytest.raises(UsageError, match="no such thing"):
        run(wrong, lanes=3)
