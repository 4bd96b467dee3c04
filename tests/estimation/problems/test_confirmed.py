"""Whether a record has the error that a bias comes of, by its residuals."""

import numpy as np
import pytest

from axisid.estimation.problems import NoiseFree, confirmed, is_not_in
from axisid.estimation.problems.filter_bias import share_in_residuals
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.support.arrays import Array

ROWS = 2000


def error() -> Array:
    """What a filter leaves at reversals."""
    return np.where(np.arange(ROWS) % 50 < 3, 1.0, 0.0)


def quiet(own: Array, halves: Array | None = None) -> NoiseFree:
    return NoiseFree(
        regressor=np.ones((ROWS, 1)),
        theta=np.zeros(1),
        residuals=own,
        bias=np.ones(1),
        has_noise=halves is not None,
        halves=halves,
    )


def left(residuals: Array) -> Solution:
    return least_squares(residuals, factor(np.ones((ROWS, 1)), ["level"]))


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_the_share_is_found_and_less_than_a_half_is_doubted(
    rng: np.random.Generator, share: float
) -> None:
    solution = left(share * error() + 0.1 * rng.normal(size=ROWS))
    told, most = share_in_residuals(quiet(error() - error().mean()), solution, Hac())
    assert told == pytest.approx(share, abs=0.05)
    assert told < most
    found = confirmed(quiet(error() - error().mean()), solution, Hac())
    assert bool(found.doubt) == (share < 0.5)
    assert found.is_in_record == (share > 0.5)
    assert is_not_in(found, solution, Hac()) == (share < 0.5)


@pytest.mark.parametrize(("share", "doubted"), [(0.1, True), (0.8, True), (1.0, False)])
def test_of_loops_with_noise_all_of_it_has_to_be_there(
    rng: np.random.Generator, share: float, doubted: bool
) -> None:
    halves = error() - error().mean() + 0.3 * rng.normal(size=(2, ROWS))
    solution = left(share * error() + 0.1 * rng.normal(size=ROWS))
    told, _ = share_in_residuals(quiet(error(), halves), solution, Hac())
    assert told == pytest.approx(share, abs=0.15), "noise of the draws makes it no smaller"
    assert bool(confirmed(quiet(error(), halves), solution, Hac()).doubt) == doubted


def test_what_noise_smears_is_no_reason_to_doubt(rng: np.random.Generator) -> None:
    found = [
        confirmed(quiet(error(), rng.normal(size=(2, ROWS))), left(rng.normal(size=ROWS)), Hac())
        for _ in range(40)
    ]
    assert np.mean([bool(each.doubt) for each in found]) <= 0.15
