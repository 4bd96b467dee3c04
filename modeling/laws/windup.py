"""Integrals of control laws, and what keeps them from running away at the drive's limit.

Anti-windup sees `LIMITED_OUTPUT`, the law's own output within the drive's limit.
"""

from collections.abc import Mapping

import sympy

from axisid.modeling.declaration import ControlLaw, Memory, gain
from axisid.modeling.quantities import BALANCED, LIMITED_OUTPUT, PERIOD
from axisid.support.errors import ModelError

from .arguments import Amount, amount, chosen, in_range, positive_among
from .velocity import joined

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


def with_integral(
    name: str,
    *,
    period: float,
    output: sympy.Expr,
    gains: Mapping[str, float],
    memory: tuple[Memory, ...],
    error: sympy.Expr,
    time: sympy.Expr,
    anti_windup: str,
    tracking_time: float | None = None,
) -> ControlLaw:
    """A ready law, with the memory of the integral that stands in its output, if one does.

    Parameters
    ----------
    name, period, output, gains, memory
        The law's, as far as they are not the integral's.
    error : expression
        What is integrated.
    time : expression
        The law's own integral time.
    anti_windup : str
        One of `ANTI_WINDUP`.
    tracking_time : float, optional
        Of back-calculation, s; the law's own integral time by default.

    Raises
    ------
    ModelError
        There is anti-windup and no integral, or a tracking time that nothing has use for.
    """
    slope, given = sympy.diff(output, gain("integral")), tracking_time is not None
    if not slope and (anti_windup != "none" or given):
        raise ModelError(
            f"the law has no integral that could wind up, but anti_windup is {anti_windup!r}; "
            "leave anti_windup and tracking_time out, or give the integral's gain.",
            code="law",
        )
    chosen(anti_windup, "anti_windup", ANTI_WINDUP)
    if tracking_time is not None:
        if anti_windup != "back_calculation":
            raise ModelError(
                f"the tracking time is {tracking_time!r}, but anti_windup is {anti_windup!r}; "
                "leave it out, or give anti_windup='back_calculation'.",
                code="law",
            )
        gains = {
            **gains,
            "tracking_time": in_range(tracking_time, "the tracking time", positive=True),
        }
    if slope:
        tracking = 1 / (slope * (gain("tracking_time") if given else time))
        held = integral(error, output, anti_windup=anti_windup, tracking=tracking)
        memory = joined(memory, (held,))
    return ControlLaw(
        name=name,
        period=period,
        output=output,
        gains=gains,
        memory=memory,
        positive=positive_among(gains),
    )
