"""What columns make of errors that follow one another is what the whole matrix makes of them."""

import numpy as np
import pytest
from scipy.linalg import toeplitz

from axisid.estimation.told_by_outputs.autoregression import by_durbin


@pytest.mark.parametrize("rows", [0, 1, 2, 3, 50, 501])
def test_the_covariance_of_columns_is_that_of_the_whole_matrix(rows: int) -> None:
    random = np.random.default_rng(5)
    errors = np.convolve(random.normal(size=2000), [1.0, 0.8, 0.3])[:2000]
    products = [errors[: len(errors) - k] @ errors[k:] for k in range(20)]
    model = by_durbin(np.array(products) / len(errors), len(errors))
    assert model.order
    columns = random.normal(size=(rows, 3))
    whole = toeplitz(model.covariances_to(rows))
    found = model.coloured(columns)
    np.testing.assert_allclose(
        found, columns.T @ whole @ columns, rtol=0, atol=1e-11 * np.abs(found).max(initial=0.0)
    )
