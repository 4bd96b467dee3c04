"""What may be assumed of residuals, by the name that users give."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceRow:
    """A covariance of an estimate, and where it lives.

    Attributes
    ----------
    name : str
        As users give it, ``hac``.
    label : str
        In tables.
    assumes : str
        What residuals may be, for help: ``"autocorrelated"``.
    covariance : str
        ``module:class`` of the `Covariance`.
    allows_autocorrelation : bool
        Whether residuals that follow one another may be correlated.
    takes_lags : bool
        Whether the class takes lags, None letting the data choose; else it takes nothing.
    """

    name: str
    label: str
    assumes: str
    covariance: str
    allows_autocorrelation: bool = False
    takes_lags: bool = False


_REGRESSION = "axisid.estimation.regression"
#: In the order of help and tables, first the one by default.
COVARIANCE_ROWS = (
    CovarianceRow(
        name="hac",
        label="HAC",
        assumes="autocorrelated",
        covariance=f"{_REGRESSION}.covariance:Hac",
        allows_autocorrelation=True,
        takes_lags=True,
    ),
    CovarianceRow(
        name="robust",
        label="robust",
        assumes="of any variance",
        covariance=f"{_REGRESSION}.covariance:Robust",
    ),
    CovarianceRow(
        name="iid",
        label="i.i.d.",
        assumes="alike and independent",
        covariance=f"{_REGRESSION}.covariance:PublishedCovariance",
    ),
)


def covariance_names() -> tuple[str, ...]:
    """Return the names, in the order of help."""
    return tuple(row.name for row in COVARIANCE_ROWS)


def assumptions() -> str:
    """Return what each covariance assumes of residuals, for help."""
    return ", ".join(f"{row.name} {row.assumes}" for row in COVARIANCE_ROWS)


def takes_lags(name: str) -> bool:
    """Return whether a covariance is over a number of lags."""
    return any(row.takes_lags for row in COVARIANCE_ROWS if row.name == name)
