"""Blocks that are held out: as NumPy has them by hand."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter
from axisid.estimation.model_selection.held_out import (
    Regression,
    contiguous_blocks,
    held_out_equation,
)
from axisid.estimation.signals import RowTimes, SampledFilter


def test_blocks_cover_all_rows_once_and_keep_their_gap() -> None:
    blocks = contiguous_blocks(503, 12, 4)
    assert len(blocks) == 10
    assert np.concatenate([b.held_out for b in blocks]).tolist() == list(range(503))
    for block in blocks:
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


@pytest.mark.parametrize("has_instruments", [False, True])
def test_each_block_is_predicted_by_the_others(
    rng: np.random.Generator, has_instruments: bool
) -> None:
    Z = rng.normal(size=(200, 2))
    X = Z + 0.3 * rng.normal(size=(200, 2)) * has_instruments
    y = X @ [2.0, -1.0] + 0.1 * rng.normal(size=200)
    rows = Regression(
        left=y,
        regressor=X,
        instruments=Z if has_instruments else None,
        names=("a", "b"),
        neighbours=RowTimes.consecutive(200),
    )
    blocks = contiguous_blocks(200, 5, 2)
    found = held_out_equation(rows, blocks, float(np.linalg.norm(y)))
    expected = []
    for block in blocks:
        some = block.training
        theta = np.linalg.solve(Z[some].T @ X[some], Z[some].T @ y[some])
        expected.append(np.sum((y - X @ theta)[block.held_out] ** 2))
    assert found.squares == pytest.approx(expected)
    wanted = 100 * np.sqrt(sum(expected)) / np.linalg.norm(y)
    assert found.error_percent == pytest.approx(wanted)
    apart = np.arange(10.0)
    mean, error = replace(found, squares=found.squares + apart).excess(found)
    assert (mean, error) == pytest.approx((4.5, np.std(apart, ddof=1) / 10**0.5))
