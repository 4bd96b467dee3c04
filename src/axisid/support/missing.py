"""The one way to say that something cannot be told: in place of it, with the reason."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Missing:
    """What stands in place of something that could not be measured, drawn or computed.

    Attributes
    ----------
    reason : str
        Why, as the end of a sentence: ``"the axis declares no control law"``.
    """

    reason: str

    def __str__(self) -> str:
        return self.reason
