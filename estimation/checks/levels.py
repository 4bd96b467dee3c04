"""From when on checks tell something: two numbers, which are arguments."""

from dataclasses import dataclass, fields

from axisid.estimation.thresholds import LEAST_SHARE, LEVEL
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real
from axisid.support.user_values import quoted


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """From when on a check tells something of a model.

    Attributes
    ----------
    level : float
        Chance that it does of a right model, over all that it looks for.
    least_share : float
        Part of the force, or of a parameter's value, from which it matters; what is missing does
        too where it moves a parameter by more than its interval.

    Raises
    ------
    UsageError
        One of them is not between 0 and 1.
    """

    level: float = LEVEL.value
    least_share: float = LEAST_SHARE.value

    def __post_init__(self) -> None:
        for each in fields(self):
            given = getattr(self, each.name)
            if not (is_real(given) and 0 < float(given) < 1):
                raise UsageError(
                    f"the {each.name.replace('_', ' ')} is {quoted(given)}; give a number between "
                    f"0 and 1, such as {each.default:g}.",
                    code="level",
                )


DEFAULT_LEVELS = Levels()
