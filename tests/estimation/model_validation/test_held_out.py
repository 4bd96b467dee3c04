"""Blocks that are held out, and nested models: both as NumPy and statsmodels have them by hand."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm

from axisid import Prefilter
from axisid.estimation.model_validation.candidate import (
    criteria,
    nested_tests,
    nesting,
    wald_test,
)
from axisid.estimation.model_validation.held_out import (
    Regression,
    contiguous_blocks,
    held_out_equation,
)
from axisid.estimation.regression import hotelling_p_value
from axisid.estimation.regression.covariance import Classical, Hac
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


N = 300
#: Of statsmodels' HAC covariance.
ROBUST = {
    "cov_type": "HAC",
    "cov_kwds": {"maxlags": 6, "use_correction": True},
    "use_t": True,
}


def regression(X: np.ndarray, left: np.ndarray) -> Regression:
    return Regression(
        left=left,
        regressor=X,
        instruments=None,
        names=tuple(f"p{i}" for i in range(X.shape[1])),
        neighbours=RowTimes.consecutive(len(left)),
    )


@pytest.fixture
def data(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Columns of unlike sizes, and a response with autocorrelated residuals."""
    X = rng.normal(size=(N, 4)) * [1e3, 1.0, 1e-4, 10.0]
    shocks, e = rng.normal(size=N), np.zeros(N)
    for i in range(1, N):
        e[i] = 0.6 * e[i - 1] + shocks[i]
    return X, X @ [1e-3, 0.5, 500.0, 0.01] + e


def test_criteria_and_f_are_those_of_statsmodels(data: tuple[np.ndarray, np.ndarray]) -> None:
    """The Wald statistic is F by the covariance of least squares."""
    X, y = data
    full = sm.OLS(y, X).fit()
    found = criteria(regression(X, y))
    wanted = (full.llf, full.aic, full.bic)
    assert (found.log_likelihood, found.aic, found.bic) == pytest.approx(wanted, rel=1e-10)
    f, p, _ = full.compare_f_test(sm.OLS(y, X[:, :2]).fit())
    how = nesting(regression(X[:, :2], y), regression(X, y))
    assert wald_test(regression(X, y).solved(), how, Classical()) == pytest.approx((f, p))


def test_robust_wald_is_that_of_statsmodels(data: tuple[np.ndarray, np.ndarray]) -> None:
    X, y = data
    robust = sm.OLS(y, X).fit(**ROBUST)
    cases = {
        "a column left out": (X[:, :3], [[0, 0, 0, 1]]),
        "two left out": (X[:, [0, 2]], [[0, 1, 0, 0], [0, 0, 0, 1]]),
        "two columns with one weight": (
            np.column_stack([X[:, 0], X[:, 1] + X[:, 2], X[:, 3]]),
            [[0, 1, -1, 0]],
        ),
    }
    larger = regression(X, y).solved()
    # statsmodels takes the regression for the freedom, of which lags leave fewer.
    freedom = float(Hac(6).applied(larger).freedom.min())
    assert freedom < N - 4
    for small, restriction in cases.values():
        how = nesting(regression(small, y), regression(X, y))
        expected, q = robust.f_test(np.array(restriction, dtype=float)), len(restriction)
        statistic, p = wald_test(larger, how, Hac(6))
        assert statistic == pytest.approx(float(expected.fvalue), rel=1e-6)
        assert p == pytest.approx(hotelling_p_value(q * statistic, q, freedom))
        assert p >= float(expected.pvalue)


def test_a_known_part_must_be_spanned_too(data: tuple[np.ndarray, np.ndarray]) -> None:
    """A model with a known coefficient is nested in the one that estimates it."""
    X, y = data
    fixed = regression(X[:, :3], y - 0.02 * X[:, 3])
    how = nesting(fixed, regression(X, y))
    assert how[1] == pytest.approx([0, 0, 0, 0.02], abs=1e-9)
    robust = sm.OLS(y, X).fit(**ROBUST)
    expected = robust.t_test((np.array([[0.0, 0, 0, 1]]), np.array([0.02])))
    statistic, _ = wald_test(regression(X, y).solved(), how, Hac(6))
    assert statistic == pytest.approx(float(expected.tvalue.item()) ** 2, rel=1e-6)
    almost = X[:, :2] * [1, 1 + 1e-6] + [0, 1e-6]
    for columns, left in ((X[:, :3], y - np.sin(np.arange(N))), (almost, y)):
        assert nesting(regression(columns, left), regression(X, y)) is None


def test_only_next_richer_models_are_tested_and_equal_ones_are_told(
    data: tuple[np.ndarray, np.ndarray],
) -> None:
    X, y = data
    models = {
        "one": regression(X[:, :1], y),
        "two": regression(X[:, :2], y),
        "mixed": regression(np.column_stack([X[:, 0] + 50 * X[:, 1], X[:, 1]]), y),
        "other": regression(X[:, 2:3], y),
        "all": regression(X, y),
    }
    tests, same = nested_tests(models)
    assert same == (("two", "mixed"),)
    assert {(t.smaller, t.larger, t.restrictions) for t in tests} == {
        ("one", "two", 1),
        ("one", "mixed", 1),
        ("two", "all", 2),
        ("mixed", "all", 2),
        ("other", "all", 3),
    }
