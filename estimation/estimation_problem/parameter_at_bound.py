"""A parameter that is fixed at its bound."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterAtBound:
    """A parameter fixed at its bound, with its estimate without the bound.

    Attributes
    ----------
    name, unit : str
        Name and unit of the parameter.
    bound : float
        Value of the bound, SI.
    is_lower : bool
        True for the lower bound.
    free : float
        Estimate without the bound, with other parameters fixed at their bounds, minus its bias if
        that is known.
    deviation : float
        Standard error of `free`, by the chosen covariance.
    reach : float
        Other end of the one-sided 95 % interval that begins at the bound; the bound itself if the
        interval is empty.
    """

    name: str
    unit: str
    bound: float
    is_lower: bool
    free: float
    deviation: float
    reach: float

    @property
    def distance(self) -> float:
        """Distance of the free estimate beyond the bound, in standard errors; 0 if inside."""
        beyond = (self.bound - self.free) if self.is_lower else (self.free - self.bound)
        return max(0.0, beyond / self.deviation) if self.deviation > 0 else 0.0
