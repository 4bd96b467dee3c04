"""Statistics that say whether instruments can be believed, and whether they are needed.

First-stage F and Shea's partial R squared; least squares against instruments by Durbin-Wu-Hausman
in regression form.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc, stdtr

from .arrays import Array
from .covariance import Covariance
from .linear import factor, least_squares


@dataclass(frozen=True, slots=True, kw_only=True)
class Strength:
    """How strongly the instruments move one column of the regressor.

    Attributes
    ----------
    r_squared : float
        Of the column's regression on the instruments.
    shea : float
        The same beyond what the other columns' regressions explain.
    f : float
        F statistic of the regression; infinite where it is exact.
    """

    r_squared: float
    shea: float
    f: float


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTests:
    """Instruments against the regressor.

    Attributes
    ----------
    columns : tuple of Strength
    condition_number : float
        Of ``Z'X`` for unit columns.
    """

    columns: tuple[Strength, ...]
    condition_number: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Endogeneity:
    """Durbin-Wu-Hausman in regression form.

    Attributes
    ----------
    statistic, p_value : float
        Wald statistic over its degrees of freedom, F distributed; never negative.
    by_parameter : tuple of float
        p-value of each column's residual from its instruments; NaN where instruments give the
        column exactly.
    """

    statistic: float
    p_value: float
    by_parameter: tuple[float, ...]


def instrument_tests(X: Array, Z: Array) -> InstrumentTests:
    """First stage of every column, as in linearmodels' diagnostics.

    Parameters
    ----------
    X, Z : (n, k) arrays
        Regressor and instruments, both of full column rank.
    """
    n, k = X.shape
    basis = np.linalg.qr(Z)[0]
    fitted = basis @ (basis.T @ X)
    scale = np.linalg.norm(X, axis=0)
    plain = np.diag(np.linalg.inv((X / scale).T @ (X / scale)))
    projected = np.diag(np.linalg.inv((fitted / scale).T @ (fitted / scale)))
    explained, left = np.sum(fitted**2, axis=0), np.sum((X - fitted) ** 2, axis=0)
    strengths = []
    for j in range(k):
        f = np.inf if left[j] == 0 else explained[j] / k / (left[j] / (n - k))
        strengths.append(
            Strength(
                r_squared=float(explained[j] / (explained[j] + left[j])),
                shea=float(plain[j] / projected[j]),
                f=float(f),
            )
        )
    product = (Z / np.linalg.norm(Z, axis=0)).T @ (X / scale)
    return InstrumentTests(
        columns=tuple(strengths), condition_number=float(np.linalg.cond(product))
    )


def endogeneity(y: Array, X: Array, Z: Array, covariance: Covariance) -> Endogeneity:
    """Test whether the regressor's residuals from the instruments help to explain y.

    Parameters
    ----------
    y : (n,) array
    X, Z : (n, k) arrays
    covariance : Covariance
        Of the augmented regression.
    """
    k = X.shape[1]
    basis = np.linalg.qr(Z)[0]
    unexplained = X - basis @ (basis.T @ X)
    noisy = np.linalg.norm(unexplained, axis=0) > 1e-9 * np.linalg.norm(X, axis=0)
    if not np.any(noisy):
        return Endogeneity(statistic=0.0, p_value=1.0, by_parameter=(np.nan,) * k)
    augmented = np.column_stack([X, unexplained[:, noisy]])
    solution = least_squares(y, factor(augmented, [str(i) for i in range(augmented.shape[1])]))
    extra, block = solution.theta[k:], covariance.matrix(solution)[k:, k:]
    tested, dof = len(extra), len(y) - augmented.shape[1]
    wald = float(extra @ np.linalg.solve(block, extra)) / tested
    single = 2 * stdtr(dof, -np.abs(extra) / np.sqrt(np.diag(block)))
    by_parameter = np.full(k, np.nan)
    by_parameter[noisy] = single
    return Endogeneity(
        statistic=wald,
        p_value=float(fdtrc(tested, dof, wald)),
        by_parameter=tuple(map(float, by_parameter)),
    )
