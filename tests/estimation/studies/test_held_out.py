"""Blocks that are held out: they cover the rows once, and their gap is the filters' memory."""

import numpy as np
import pytest

from axisid import Prefilter
from axisid.estimation.signals import RowTimes, SampledFilter
from axisid.estimation.studies.held_out import (
    HeldOut,
    Regression,
    contiguous_blocks,
    held_out_equation,
)


def test_blocks_cover_all_rows_once_and_keep_their_gap() -> None:
    blocks = contiguous_blocks(503, 12, 4)
    assert len(blocks) == 10
    assert np.concatenate([b.held_out for b in blocks]).tolist() == list(range(503))
    for block in blocks:
        assert np.all(np.diff(block.held_out) == 1)
        distance = np.abs(block.training[:, None] - block.held_out[None, :]).min(axis=1)
        assert distance.min() == 13
        far = set(range(503)) - set(block.training.tolist())
        assert far == set(range(max(block.held_out[0] - 12, 0), min(block.held_out[-1] + 13, 503)))


@pytest.mark.parametrize(("cutoff", "decimate"), [(60.0, 10), (100.0, 4), (40.0, 1)])
def test_gap_is_the_reach_of_one_sample(cutoff: float, decimate: int) -> None:
    """One position moves no row further off by more than 1e-2 of what it moves the nearest."""
    f = SampledFilter(Prefilter(cutoff=cutoff, decimate=decimate), 1e-3)
    position = np.zeros(4001)
    position[2000] = 1.0
    q, _, ddq = f.motion(position)
    for signal in (q, ddq):
        moved = np.abs(f.reduce(signal))
        distance = np.abs(f.rows(len(position)) - 2000) / decimate
        beyond = moved[distance > f.memory]
        assert beyond.max() < 1e-2 * moved.max()
        # No more than it takes: at a third of it the response is still there.
        assert moved[distance > f.memory / 3].max() > 1e-4 * moved.max()


def test_each_block_is_predicted_by_the_others(rng: np.random.Generator) -> None:
    X = rng.normal(size=(200, 2))
    y = X @ [2.0, -1.0] + 0.1 * rng.normal(size=200)
    following = RowTimes.consecutive(200)
    rows = Regression(left=y, regressor=X, instruments=None, names=("a", "b"), neighbours=following)
    blocks = contiguous_blocks(200, 5, 2)
    found, thetas = held_out_equation(rows, blocks, float(np.linalg.norm(y)))
    expected = []
    for block, theta in zip(blocks, thetas, strict=True):
        direct = np.linalg.lstsq(X[block.training], y[block.training], rcond=None)[0]
        assert theta == pytest.approx(direct)
        expected.append(np.sum((y - X @ direct)[block.held_out] ** 2))
    assert found.squares == pytest.approx(expected)
    wanted = 100 * np.sqrt(sum(expected)) / np.linalg.norm(y)
    assert found.error_percent == pytest.approx(wanted)


def test_instruments_are_held_out_with_their_rows(rng: np.random.Generator) -> None:
    Z = rng.normal(size=(200, 1))
    X = Z + 0.3 * rng.normal(size=(200, 1))
    following = RowTimes.consecutive(200)
    rows = Regression(
        left=3 * X[:, 0], regressor=X, instruments=Z, names=("a",), neighbours=following
    )
    found, thetas = held_out_equation(rows, contiguous_blocks(200, 5, 1), 1.0)
    assert thetas == pytest.approx([3.0] * 10)
    assert found.error_percent < 1e-9


def test_excess_is_a_mean_over_blocks_with_its_standard_error() -> None:
    one = HeldOut(squares=np.array([2.0, 4.0, 6.0, 8.0]), signal=1.0)
    other = HeldOut(squares=np.array([1.0, 2.0, 6.0, 7.0]), signal=1.0)
    mean, error = one.excess(other)
    assert mean == pytest.approx(1.0)
    assert error == pytest.approx(np.std([1, 2, 0, 1], ddof=1) / 2)
