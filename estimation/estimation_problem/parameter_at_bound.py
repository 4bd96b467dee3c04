"""A parameter that is held at its bound."""

from dataclasses import dataclass

from axisid.support.errors import range_text


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterAtBound:
    """A parameter at its bound, and what the records say of it without.

    Attributes
    ----------
    name, unit : str
    bound : float
        Where it is held, SI.
    is_lower : bool
        Whether that is the lower one.
    free : float
        What it is without the bound, others that are held at theirs, less its bias
        where that is known.
    deviation : float
        Of `free`, under the covariance that was chosen.
    reach : float
        The other end of its 95 % interval, which begins at the bound and has one side; the bound
        itself where the records leave no room beside it.
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
        """How far beyond the bound it would be, in deviations; 0 for what would come back."""
        beyond = (self.bound - self.free) if self.is_lower else (self.free - self.bound)
        return max(0.0, beyond / self.deviation) if self.deviation > 0 else 0.0

    @property
    def text(self) -> str:
        """All of it in words."""
        room = (
            "95 %, to one side: "
            + range_text(min(self.bound, self.reach), max(self.bound, self.reach), " to ")
            if self.reach != self.bound
            else "which leaves no room beside the bound"
        )
        return (
            f"{self.name} is held at its bound {self.bound:g} {self.unit}; without it "
            f"{self.free:.4g} +- {self.deviation:.2g}, {room}"
        )
