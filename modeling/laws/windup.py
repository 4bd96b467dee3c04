"""Integrals of control laws, and what keeps them from running away at the drive's limit.

Anti-windup sees `LIMITED_OUTPUT`, the law's own output within the drive's limit.
"""

from dataclasses import dataclass

import sympy

from axisid.modeling.declaration import Memory, gain
from axisid.modeling.quantities import BALANCED, LIMITED_OUTPUT, PERIOD
from axisid.support.errors import ModelError

from .arguments import Amount, amount, chosen, in_range

#: What an integral may do at the drive's limit, first what it does by default.
ANTI_WINDUP = ("none", "clamping", "back_calculation")


def integral(
    error: sympy.Expr,
    output: sympy.Expr,
    *,
    name: str = "integral",
    anti_windup: str = "none",
    tracking: Amount = 0.0,
    start: sympy.Expr | float = BALANCED,
) -> Memory:
    """Integral of an error from its last samples, ``I[k+1] = I[k] + T e[k]``, against windup.

    Parameters
    ----------
    error : expression
        e, what is integrated.
    output : expression
        u, the law's output, in which the integral stands by its name.
    name : str
    anti_windup : str
        ``none``; ``clamping``: the integral stands still while the output is beyond the drive's
        limit and the integral of the error would drive it further; ``back_calculation``:
        ``I[k+1] = I[k] + T (e[k] + (u_limited[k] - u[k]) g)``.
    tracking : expression
        g of back-calculation: what the error's integral gets of the missing control, in the unit
        of the error over the control's.
    start : expression
        Its value at the first sample; by default what balances the load there.

    References
    ----------
    [AstromHagglund2006]_, section 3.5.
    """
    chosen(anti_windup, "anti_windup", ANTI_WINDUP)
    symbol = sympy.Symbol(name, real=True)
    following = symbol + PERIOD * error
    if anti_windup == "clamping":
        # A gain may be negative, as that of an axis whose positions are counted the other way is;
        # the slope of an output that has kinks of its own is taken for positive.
        slope = sympy.diff(output, symbol)
        driven = error if slope.has(sympy.Heaviside, sympy.Derivative) else slope * error
        outward = (output - LIMITED_OUTPUT) * driven > 0
        following = sympy.Piecewise((symbol, outward), (following, True), evaluate=False)
    elif anti_windup == "back_calculation":
        missing = LIMITED_OUTPUT - output
        following = following + PERIOD * amount(tracking, "the tracking gain") * missing
    return Memory(name, following=following, start=start)


@dataclass(frozen=True, slots=True, kw_only=True)
class Integral:
    """The integral of a ready law, and what it does at the drive's limit.

    Attributes
    ----------
    error : sympy.Expr
        What is integrated.
    output : sympy.Expr
        The law's; it has no integral where ``integral`` does not stand in it.
    anti_windup : str
        One of `ANTI_WINDUP`.
    time : sympy.Expr
        The law's own integral time.
    tracking_time : float or None
        Of back-calculation, s; None for the law's own integral time.
    """

    error: sympy.Expr
    output: sympy.Expr
    anti_windup: str
    time: sympy.Expr
    tracking_time: float | None = None

    def __post_init__(self) -> None:
        how, time = self.anti_windup, self.tracking_time
        if not self.slope and (how != "none" or time is not None):
            raise ModelError(
                f"the law has no integral that could wind up, but anti_windup is {how!r}; leave "
                "anti_windup and tracking_time out, or give the integral's gain.",
                code="law",
            )
        chosen(how, "anti_windup", ANTI_WINDUP)
        if time is None:
            return
        if how != "back_calculation":
            raise ModelError(
                f"the tracking time is {time!r}, but anti_windup is {how!r}; leave it out, or give "
                "anti_windup='back_calculation'.",
                code="law",
            )
        in_range(time, "the tracking time", positive=True)

    @property
    def slope(self) -> sympy.Expr:
        """What the output gains by the integral; 0 without one."""
        return sympy.diff(self.output, gain("integral"))

    @property
    def gains(self) -> dict[str, float]:
        """The tracking time by its name, where it is given."""
        return {} if self.tracking_time is None else {"tracking_time": self.tracking_time}

    @property
    def memory(self) -> tuple[Memory, ...]:
        """What the law remembers of it; see the function `integral`."""
        if not self.slope:
            return ()
        tracking = 1 / (self.slope * (gain("tracking_time") if self.gains else self.time))
        return (integral(self.error, self.output, anti_windup=self.anti_windup, tracking=tracking),)
