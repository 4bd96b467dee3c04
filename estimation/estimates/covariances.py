"""What may be assumed of residuals, from the rows of `axisid.estimation.choices`."""

from collections.abc import Callable
from dataclasses import dataclass
from pkgutil import resolve_name

from axisid.estimation.choices import COVARIANCE_ROWS, CovarianceRow
from axisid.estimation.regression import Covariance


@dataclass(frozen=True, slots=True)
class ResidualModel:
    """What is assumed of residuals, and what follows for an estimate."""

    row: CovarianceRow
    made: Callable[..., Covariance]

    @classmethod
    def of(cls, row: CovarianceRow) -> "ResidualModel":
        """Return what a row names."""
        return cls(row, resolve_name(row.covariance))

    @property
    def label(self) -> str:
        """In tables."""
        return self.row.label

    @property
    def allows_autocorrelation(self) -> bool:
        """Whether residuals that follow one another may be correlated."""
        return self.row.allows_autocorrelation

    def covariance(self, lags: int | None) -> Covariance:
        """The covariance of an estimate; None for lags lets the data choose."""
        return self.made(lags) if self.row.takes_lags else self.made()


#: By name: residuals that are autocorrelated; of any variance; alike and independent.
COVARIANCES: dict[str, ResidualModel] = {row.name: ResidualModel.of(row) for row in COVARIANCE_ROWS}
