"""What may be assumed of residuals, by the name that users give."""

from collections.abc import Callable
from dataclasses import dataclass

from axisid.estimation.regression import Covariance, Hac, Published, Robust


@dataclass(frozen=True, slots=True)
class ResidualModel:
    """What is assumed of residuals.

    Attributes
    ----------
    label : str
        In tables.
    allows_autocorrelation : bool
        Whether residuals that follow one another may be correlated.
    covariance : callable
        What follows for the estimate, for given lags (None lets the data choose).
    """

    label: str
    allows_autocorrelation: bool
    covariance: Callable[[int | None], Covariance]


#: Residuals that are autocorrelated; of any variance; alike and independent.
COVARIANCES: dict[str, ResidualModel] = {
    "hac": ResidualModel("HAC", True, Hac),
    "robust": ResidualModel("robust", False, lambda _: Robust()),
    "iid": ResidualModel("i.i.d.", False, lambda _: Published()),
}
