"""Errors of several outputs: their autoregression, and what it makes of columns."""

import numpy as np
import pytest

from axisid.estimation.regression import Autoregression, autoregression_of
from axisid.support.arrays import Array

_FIRST = np.array([[0.5, 0.3], [-0.2, 0.6]])
_SECOND = np.array([[-0.2, 0.1], [0.05, -0.3]])
_NOISE = np.array([[1.0, 0.4], [0.4, 2.0]])


def _errors(samples: int, seed: int) -> Array:
    """Rows of a sample neighbours, (2 n,)."""
    noise = np.random.default_rng(seed).multivariate_normal([0, 0], _NOISE, size=samples + 100)
    e = np.zeros_like(noise)
    for t in range(2, len(e)):
        e[t] = _FIRST @ e[t - 1] + _SECOND @ e[t - 2] + noise[t]
    return e[100:].ravel()


def _found(pieces: list[Array]) -> Autoregression:
    return autoregression_of(pieces, 1e-3, None, 2)


def test_the_coefficients_and_the_noise_are_found() -> None:
    e = _errors(20_000, 0)
    found = _found([e[:15_000], e[15_000:]])
    assert 2 <= found.order <= 3
    np.testing.assert_allclose(found.coefficients[1], -_FIRST, atol=0.03)
    np.testing.assert_allclose(found.coefficients[2], -_SECOND, atol=0.03)
    np.testing.assert_allclose(found.variance, _NOISE, atol=0.06)


def test_columns_make_of_errors_what_their_covariances_say() -> None:
    """By the sums over all pairs of samples."""
    found, columns = _found([_errors(20_000, 0)]), np.random.default_rng(1).normal(size=(80, 2))
    columns = columns.cumsum(axis=0)
    lags = [*found.covariances]
    for _ in range(40):
        lags.append(-sum(a @ c for a, c in zip(found.coefficients[1:], lags[::-1], strict=False)))
    whole = np.block(
        [[lags[i - j] if i >= j else lags[j - i].T for j in range(40)] for i in range(40)]
    )
    np.testing.assert_allclose(found.coloured(columns), columns.T @ whole @ columns, rtol=1e-9)


@pytest.mark.parametrize("other", [0.0, 1.0, -3.0])
def test_an_output_that_is_a_function_of_another_tells_nothing_more(other: float) -> None:
    e = _errors(4_000, 4)[::2].copy()
    both = _found([np.column_stack([e, other * e]).ravel()])
    column = np.random.default_rng(5).normal(size=(200, 1))
    wide = np.hstack([column, np.zeros_like(column)]).reshape(-1, 1)
    alone = autoregression_of([e], 1e-3).coloured(column)
    np.testing.assert_allclose(both.coloured(wide), alone, rtol=0.1)


def test_masked_samples_are_no_errors() -> None:
    e = _errors(20_000, 6)
    there = np.ones(len(e), dtype=bool)
    there[4_000:6_000] = there[9_000:12_000] = False
    found = autoregression_of([np.where(there, e, 0.0)], 1e-3, [there], 2)
    np.testing.assert_allclose(found.variance, _NOISE, atol=0.1)


def test_lags_are_as_long_in_time_for_several_outputs_as_for_one() -> None:
    """At 10 kHz, of errors that come back after 20 and after 38 ms."""
    noise = np.random.default_rng(3).standard_normal((30_000, 2))
    e = np.zeros_like(noise)
    for t in range(380, len(e)):
        e[t] = 0.5 * e[t - 200] + 0.3 * e[t - 380] + noise[t]
    both = autoregression_of([e.ravel()], 1e-4, None, 2)
    alone = autoregression_of([np.ascontiguousarray(e[:, 0])], 1e-4)
    assert both.order == pytest.approx(380, abs=5)
    assert alone.order == pytest.approx(380, abs=5)
