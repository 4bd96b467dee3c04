"""What may be assumed of residuals, from the rows of `axisid.estimation.choices`."""

from collections.abc import Callable
from pkgutil import resolve_name

from axisid.estimation.choices import COVARIANCE_ROWS, CovarianceRow
from axisid.estimation.regression import Covariance

#: By name: residuals that are autocorrelated; of any variance; alike and independent.
COVARIANCES: dict[str, CovarianceRow] = {row.name: row for row in COVARIANCE_ROWS}


def covariance_of(name: str, lags: int | None) -> Covariance:
    """The covariance of an estimate that is so called; None for lags lets the data choose."""
    row = COVARIANCES[name]
    made: Callable[..., Covariance] = resolve_name(row.covariance)
    return made(lags) if row.takes_lags else made()
