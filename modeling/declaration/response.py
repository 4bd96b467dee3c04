"""From the command to the force: a first-order lag and a delay, of commands that are held."""

import math
from dataclasses import dataclass

from axisid.modeling.quantities import number
from axisid.support.errors import ModelError
from axisid.support.user_values import quoted

#: Where a recorded control may have been taken, first what it is by default.
LOGGED = ("command", "applied", "current")
_WHOLE = 1e-6  # of a sample: what a delay may be off whole samples by its rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """How a drive follows commands that are held from sample to sample.

    Attributes
    ----------
    lag : float
        Time constant, s; 0 for none.
    whole : int
        Whole samples of the delay.
    share : float
        What the delay is more, of a sample: from 0 to below 1.
    period : float
        For which a command is held, s.
    """

    lag: float
    whole: int
    share: float
    period: float

    @classmethod
    def of(cls, lag: float, delay: float, period: float) -> "Response":
        """Of a lag and a delay, s, for samples of a period, s."""
        samples = delay / period
        whole = math.floor(samples + _WHOLE)
        share = samples - whole
        share = share if share > _WHOLE else 0.0
        return cls(lag=lag, whole=whole, share=share, period=period)

    @property
    def is_held(self) -> bool:
        """Whether the force stays the same from a sample to the next."""
        return not (self.lag or self.share)

    @property
    def late(self) -> int:
        """Samples before the one whose command acts at a sample, without a lag."""
        return self.whole + (self.share > 0)

    @property
    def remembered(self) -> tuple[str, ...]:
        """What it keeps from a sample to the next, by name.

        The forces of the commands before, the newest first, and what has come of them.
        """
        count = self.whole + (not self.is_held)
        pending = tuple(f"force_of_command{i + 1}" for i in range(count))
        return (*pending, "force_now") if self.lag else pending


def checked_time(value: float, what: str) -> float:
    """A time that is not negative, s.

    Raises
    ------
    ModelError
        It is, or it is no finite number.
    """
    time = number(value, what)
    if time < 0:
        raise ModelError(
            f"{what} is {quoted(value)} s; give a time of 0 or more: a force follows its command.",
            code="drive-time",
        )
    return time


def check_logged(logged: object, lag: float, delay: float) -> None:
    """Refuse a place of the recorded control that lag and delay do not tell from another.

    Raises
    ------
    ModelError
        There is no such place, or what it lies behind is not declared.
    """
    if logged not in LOGGED:
        raise ModelError(
            f"logged is {quoted(logged)}; give {', '.join(LOGGED[:-1])} or {LOGGED[-1]}: where the "
            "recorded control was taken.",
            code="drive-logged",
        )
    if logged == "applied" and not delay:
        raise ModelError(
            "logged='applied' is what acts after the drive's delay, and no delay is declared; "
            "declare delay=..., or logged='command'.",
            code="drive-logged",
        )
    if logged == "current" and not lag:
        raise ModelError(
            "logged='current' is what is there after the drive's lag, and no lag is declared; "
            "declare lag=..., or logged='command'.",
            code="drive-logged",
        )
