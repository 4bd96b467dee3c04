"""What columns make of errors that follow one another is what the whole matrix makes of them."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from axisid.estimation.regression import autoregression_of
from axisid.estimation.regression.coloured_errors import by_whittle


@pytest.mark.parametrize("rows", [0, 1, 2, 3, 50, 501])
def test_the_covariance_of_columns_is_that_of_the_whole_matrix(rows: int) -> None:
    random = np.random.default_rng(5)
    errors = np.convolve(random.normal(size=2000), [1.0, 0.8, 0.3])[:2000]
    products = [errors[: len(errors) - k] @ errors[k:] for k in range(20)]
    covariances = np.array(products)[:, None, None] / len(errors)
    model = by_whittle(covariances, len(errors))
    assert model.order
    columns = random.normal(size=(rows, 3))
    whole = toeplitz(model.covariances_to(rows)[:, 0, 0])
    found = model.coloured(columns)
    np.testing.assert_allclose(
        found, columns.T @ whole @ columns, rtol=0, atol=1e-11 * np.abs(found).max(initial=0.0)
    )


def test_how_sure_a_variance_of_one_output_is_follows_from_its_errors() -> None:
    column = np.random.default_rng(0).normal(size=300)
    variances, claimed = [], []
    for seed in range(150):
        e = lfilter([1.0], [1.0, -1.2, 0.5], np.random.default_rng(seed).normal(size=3000))
        model = autoregression_of([e], 1e-3)
        variances.append(model.coloured(column[:, None])[0, 0])
        claimed.append(model.uncertainty([column], 3000))
    scatter = np.var(variances, ddof=1) / np.mean(variances) ** 2
    assert np.mean(claimed) == pytest.approx(scatter, rel=0.3)
