"""Gains of candidates are those of least squares; the largest of many has its own p-value."""

import numpy as np
import pytest

from axisid.estimation.lacking.candidates import CandidateGrid, Resonances, Steps, supremum_p


def basis_and_residuals(rows: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    basis = np.linalg.qr(rng.normal(size=(rows, 3)))[0]
    noise = rng.normal(size=rows)
    return basis, noise - basis @ (basis.T @ noise)


def gain(columns: np.ndarray, basis: np.ndarray, residuals: np.ndarray) -> float:
    every = np.column_stack([basis, columns])
    left = residuals - every @ np.linalg.lstsq(every, residuals, rcond=None)[0]
    return float(residuals @ residuals - left @ left)


@pytest.mark.parametrize("width", [1, 2])
def test_a_gain_is_what_least_squares_takes_of_the_residuals(width: int) -> None:
    basis, residuals = basis_and_residuals(200)
    each = np.random.default_rng(5).normal(size=(200, 4, width))
    grid = CandidateGrid(kind="place", each=each, places=np.arange(1.0, 5.0))
    expected = [gain(each[:, i], basis, residuals) for i in range(4)]
    assert grid.gains(basis, residuals) == pytest.approx(expected)


def test_a_column_that_the_model_has_gains_nothing() -> None:
    basis, residuals = basis_and_residuals(50)
    own = (basis @ [1.0, 2.0, -1.0])[:, None, None]
    assert CandidateGrid(kind="slope", each=own, places=np.array([np.nan])).gains(
        basis, residuals
    ) == [0.0]


def test_a_change_is_looked_for_at_every_row_but_near_the_ends() -> None:
    basis, residuals = basis_and_residuals(100)
    column = np.random.default_rng(7).normal(size=100)
    steps = Steps(parameter="M", column=column, times=0.01 * np.arange(100))
    gains = steps.gains(basis, residuals)
    assert gains[50] == pytest.approx(gain(steps.columns(50), basis, residuals))
    assert not gains[:5].any()
    assert not gains[-5:].any()


@pytest.mark.parametrize(
    ("square", "level"), [(7.12, 0.10), (8.68, 0.05), (12.16, 0.01)], ids=["10 %", "5 %", "1 %"]
)
def test_the_largest_statistic_has_the_levels_of_andrews(square: float, level: float) -> None:
    from scipy.special import chdtrc

    assert supremum_p(float(chdtrc(1, square)), 0.15) == pytest.approx(level, rel=0.1)


def test_an_antiresonance_is_that_of_the_measured_motion() -> None:
    """The loop's motion swings otherwise, and shows no more than where to look."""
    rng = np.random.default_rng(5)
    shapes = rng.normal(size=(300, 3))
    grid = Resonances(
        kind="resonance",
        each=shapes[:, :, None],
        places=np.array([10.0, 20.0, 40.0]),
        measured=lambda at: (shapes @ np.array([at / 20, 18 / at, at * 0 + 1]))[:, :, None],
    )
    residuals = shapes @ np.array([18 / 20, 1.0, 1.0])
    assert grid.at(1, np.zeros((300, 1)), residuals) == pytest.approx(18.0, rel=0.03)
