"""An estimated number: with its unit, its deviations and its interval."""

from dataclasses import dataclass

from scipy.special import stdtrit

from axisid.support.errors import UsageError

_LEVEL = 0.95

#: What the covariances are called in tables.
COVARIANCE_LABELS = {"hac": "HAC", "robust": "robust", "iid": "i.i.d."}


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A number that leaves the program: with unit, standard deviations and interval.

    Attributes
    ----------
    value : float
    unit : str
    sd : float
        For independent residuals, as in the published tables.
    sd_robust, sd_hac : float
        For residuals of any variance; for autocorrelated ones too.
    interval : (float, float)
        95 %, about `corrected`, from `deviation` and Student's distribution with n - k degrees of
        freedom.
    sd_gain : float
        What the declared deviation of the drive gain adds, in no other figure.
    filter_bias : float or None
        What the prefilter alone moves the value by, found on the loop that is simulated with the
        estimate. The value contains it, the interval does not. None where it was not found.
    chosen : {"hac", "robust", "iid"}
        The covariance that `deviation` and `interval` are of.
    """

    value: float
    unit: str
    sd: float
    sd_robust: float
    sd_hac: float
    interval: tuple[float, float]
    sd_gain: float = 0.0
    filter_bias: float | None = None
    chosen: str = "hac"

    def __str__(self) -> str:
        low, high = self.interval
        return (
            f"{self.value:.6g} +- {self.deviation:.2g} {self.unit}, "
            f"95 %: {low:.6g} to {high:.6g} {self.unit}"
        )

    @property
    def deviation(self) -> float:
        """Standard deviation under the covariance that was chosen."""
        return {"hac": self.sd_hac, "robust": self.sd_robust, "iid": self.sd}[self.chosen]

    @property
    def corrected(self) -> float:
        """The value less the filter's own bias, where that is known."""
        return self.value - (self.filter_bias or 0.0)

    @property
    def relative_sd_percent(self) -> float:
        """``100 sd / |value|``; infinite for a value of 0."""
        return 100.0 * self.sd / abs(self.value) if self.value else float("inf")

    @property
    def relative_deviation_percent(self) -> float:
        """``100 deviation / |value|``; infinite for a value of 0."""
        return 100.0 * self.deviation / abs(self.value) if self.value else float("inf")


class Named(dict[str, Value]):
    """Values by name; a name that is not among them is told with those that are."""

    def __missing__(self, name: str) -> Value:
        raise UsageError(f"there is no {name!r}; choose from {', '.join(self)}.")


def student_interval(centre: float, deviation: float, dof: int) -> tuple[float, float]:
    """The 95 % interval about an estimate, by Student's distribution."""
    reach = float(stdtrit(dof, (1 + _LEVEL) / 2)) * deviation
    return centre - reach, centre + reach
