"""What may be assumed of residuals, by the name that users give."""

from collections.abc import Callable

from axisid.estimation.regression import Covariance, Hac, Published, Robust

#: Covariances for given lags (None lets the data choose): of autocorrelated residuals, of any
#: variance, alike and independent.
COVARIANCES: dict[str, Callable[[int | None], Covariance]] = {
    "hac": Hac,
    "robust": lambda _: Robust(),
    "iid": lambda _: Published(),
}
