"""Shared parts of ready laws: measured velocity, and integrals with anti-windup.

Anti-windup compares `UNLIMITED_OUTPUT`, the law's own output, with `LIMITED_OUTPUT`, the output
clipped at the drive's limit.
"""

from collections.abc import Callable, Mapping

import sympy

from axisid.modeling.quantities import (
    BALANCED,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    UNLIMITED_OUTPUT,
    Amount,
    expression,
)
from axisid.support.checks import refuse
from axisid.support.errors import ModelError

from .control import ControlLaw, Memory, gain
from .control_blocks import (
    Block,
    amount,
    chosen,
    difference,
    in_range,
    low_pass,
    pll_velocity,
    reference_acceleration,
    reference_velocity,
)


def formed_velocity(
    how: str = "difference", filter_time: float = 0.0, bandwidth: float = 0.0
) -> tuple[Block, dict[str, float]]:
    """Return the block that forms the measured velocity, and its gains by name.

    Parameters
    ----------
    how : str
        ``difference`` of two encoder positions, ``averaged`` over two such differences, ``pll``
        (see `pll_velocity`), or ``ideal``, the velocity of an ideal sensor, which no log contains.
    filter_time : float
        Time constant of a low-pass of the formed velocity, s; 0 for none.
    bandwidth : float
        Bandwidth of the phase-locked loop, rad/s.
    """
    chosen(how, "the velocity of a law", _FORMED)
    in_range(filter_time, "the time constant velocity_filter")
    in_range(bandwidth, "the bandwidth pll_bandwidth", positive=how == "pll")
    if bandwidth and how != "pll":
        raise ModelError(
            f"pll_bandwidth is {bandwidth!r}, but velocity is {how!r}. Omit pll_bandwidth, or give "
            "velocity='pll'.",
            code="law",
        )
    formed = smoothed(_FORMED[how](), filter_time, "velocity_filter", "velocity1")
    return formed, without_zeros({"pll_bandwidth": bandwidth, "velocity_filter": filter_time})


def smoothed(block: Block, filter_time: float, name: str, memory: str) -> Block:
    """Return a block followed by a low-pass; the block itself if the time constant is 0.

    Parameters
    ----------
    block : Block
    filter_time : float
        The time constant, s.
    name : str
        Name of the law's gain for the time constant.
    memory : str
        Name of the low-pass's memory.
    """
    if not filter_time:
        return block
    smooth = low_pass(block.value, time_constant=gain(name), name=memory)
    return Block(smooth.value, (*block.memory, *smooth.memory))


_Q1 = Memory("q1", following=MEASURED_POSITION, start=MEASURED_POSITION)
_Q2 = Memory("q2", following=_Q1.symbol, start=MEASURED_POSITION)
#: Blocks that form the velocity, by name, the default first.
_FORMED: Mapping[str, Callable[[], Block]] = {
    "difference": lambda: difference(MEASURED_POSITION, name="q1", start=MEASURED_POSITION),
    "averaged": lambda: Block((MEASURED_POSITION - _Q2.symbol) / (2 * PERIOD), (_Q1, _Q2)),
    "pll": lambda: pll_velocity(bandwidth=gain("pll_bandwidth")),
    "ideal": lambda: Block(MEASURED_VELOCITY),
}


def commanded(rate: str, recorded: Amount | None) -> Block:
    """Return the velocity or the acceleration of the reference as a block.

    Parameters
    ----------
    rate : str
        ``velocity`` or ``acceleration``.
    recorded : Amount or None
        The recorded velocity or acceleration; None for differences of the reference.
    """
    if recorded is None:
        return reference_velocity() if rate == "velocity" else reference_acceleration()
    return Block(expression(recorded, f"the reference's {rate}"))


def joined(*parts: tuple[Memory, ...]) -> tuple[Memory, ...]:
    """Return the memories of several blocks as one tuple, each name once."""
    return tuple({memory.name: memory for part in parts for memory in part}.values())


def without_zeros(gains: dict[str, float]) -> dict[str, float]:
    """Return the gains that are not 0, so that a law has no term without effect."""
    return {name: value for name, value in gains.items() if value}


#: Behaviour of an integral at the drive's limit, the default first.
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
    """Return an integral of an error, ``I[k+1] = I[k] + T e[k]``, with anti-windup.

    Parameters
    ----------
    error : expression
        e, the integrand.
    output : expression
        u, the law's output, which contains the integral by its name.
    name : str
        Name of the integral, a memory of the law.
    anti_windup : str
        ``none``; ``clamping``: the integral stands still while the output is beyond the drive's
        limit and the error would drive the output further beyond; ``back_calculation``:
        ``I[k+1] = I[k] + T (e[k] + (u_limited[k] - u[k]) g)``.
    tracking : expression
        g of back-calculation: factor of ``u_limited - u`` in the integrand, in the unit of the
        error over the unit of the control.
    start : expression
        Value of the integral at the first sample; by default the value that balances the load.

    References
    ----------
    [AstromHagglund2006]_, section 3.5.
    """
    chosen(anti_windup, "anti_windup", ANTI_WINDUP)
    symbol = sympy.Symbol(name, real=True)
    following = symbol + PERIOD * error
    if anti_windup == "clamping":
        # A gain may be negative, for an axis whose positions are counted in the opposite direction;
        # the slope of an output with kinks is assumed to be positive.
        slope = sympy.diff(output, symbol)
        driven = error if slope.has(sympy.Heaviside, sympy.Derivative) else slope * error
        # Two comparisons instead of the sign of a difference: a fused multiply-add would give the
        # difference of equal outputs a rounding error on some machines. The comparisons are in
        # SymPy's canonical form, so that a pickled law is equal to the original.
        outward = sympy.Or(
            sympy.And(LIMITED_OUTPUT < UNLIMITED_OUTPUT, driven > 0),
            sympy.And(LIMITED_OUTPUT > UNLIMITED_OUTPUT, driven < 0),
        )
        following = sympy.Piecewise((symbol, outward), (following, True), evaluate=False)
    elif anti_windup == "back_calculation":
        missing = LIMITED_OUTPUT - UNLIMITED_OUTPUT
        following = following + PERIOD * amount(tracking, "the tracking gain") * missing
    return Memory(name, following=following, start=start)


#: Gains of ready laws that must be above 0: with a time or a limit of 0, the law would be another
#: law, or would not exist.
_POSITIVE = (
    "tn",
    "ti",
    "tracking_time",
    "speed_limit",
    "filter_time",
    "velocity_filter",
    "pll_bandwidth",
)


def ready_law(
    name: str,
    *,
    period: float,
    output: sympy.Expr,
    gains: Mapping[str, float],
    memory: tuple[Memory, ...],
    error: sympy.Expr = sympy.S.Zero,
    time: sympy.Expr = sympy.S.One,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """Return a control law; an integral in its output gets its memory here.

    Parameters
    ----------
    name, period, output, gains
        As in `ControlLaw`; the integral in the output is ``gain("integral")``.
    memory
        The law's memories except that of the integral.
    error : expression
        The integrand.
    time : expression
        The law's integral time, used for back-calculation by default.
    anti_windup : str
        One of `ANTI_WINDUP`.
    tracking_time : float, optional
        Time constant of back-calculation, s; the law's own integral time by default.

    Raises
    ------
    ModelError
        Anti-windup is given without an integral, or a tracking time without back-calculation.
    """
    slope, given = sympy.diff(output, gain("integral")), tracking_time is not None
    refuse(
        ModelError,
        (
            not slope and (anti_windup != "none" or given),
            f"the law has no integral, but anti_windup is {anti_windup!r}. Omit anti_windup and "
            "tracking_time, or give the gain or time of the integral",
        ),
        (
            given and anti_windup != "back_calculation",
            f"tracking_time is {tracking_time!r}, but anti_windup is {anti_windup!r}. Omit "
            "tracking_time, or give anti_windup='back_calculation'",
        ),
        code="law",
    )
    if tracking_time is not None:
        gains = {
            **gains,
            "tracking_time": in_range(tracking_time, "the tracking time", positive=True),
        }
    if slope:
        tracking = 1 / (slope * (gain("tracking_time") if given else time))
        integrated = integral(error, output, anti_windup=anti_windup, tracking=tracking)
        memory = joined(memory, (integrated,))
    return ControlLaw(
        name=name,
        period=period,
        output=output,
        gains=gains,
        memory=memory,
        positive=tuple(name for name in _POSITIVE if name in gains),
    )
