"""PID in its parallel and its ideal form, with a filtered derivative."""

import sympy

from axisid.modeling.declaration import ControlLaw, Memory, gain
from axisid.modeling.quantities import MEASURED_POSITION, PERIOD, REFERENCE

from .blocks import Amount, Block, added, chosen, in_range
from .parts import with_integral

#: Of what the derivative may be.
DERIVATIVES = ("error", "position")
_ERROR = REFERENCE - MEASURED_POSITION


def pid(
    *,
    kp: float,
    period: float,
    ki: float = 0.0,
    kd: float = 0.0,
    filter_time: float = 0.0,
    derivative_of: str = "error",
    feed_forward: Amount | None = None,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """PID in parallel form.

    ``u = kp e + ki I + kd D + feed_forward`` with ``e = r - q``, ``I[k+1] = I[k] + T e[k]`` and
    ``D[k] = (Tf D[k-1] + e[k] - e[k-1]) / (Tf + T)``, of the position ``-q`` in place of e where
    `derivative_of` says so.

    Parameters
    ----------
    kp : float
        Control over position: N m/rad, V/m.
    period : float
        Sampling period T, s.
    ki : float
        Control over position and time: N m/(rad s).
    kd : float
        Control over velocity: N m s/rad.
    filter_time : float
        Tf, time constant of the derivative's filter, s; 0 for plain differences.
    derivative_of : str
        ``error`` or ``position``.
    feed_forward : Signal or expression, optional
        What is added to the control, in its unit.
    anti_windup : str
        What the integral does at the drive's limit: ``none``; ``clamping``, it stands still where
        it would drive the control further beyond; ``back_calculation``, `ki` I also gets
        ``T (u_limited - u) / tracking_time``.
    tracking_time : float, optional
        Of back-calculation, s; ``kp / ki`` by default.

    Notes
    -----
    moteus: ``kp`` [Nm/turn], ``kd`` [Nm/(turn/s)] and ``ki`` [Nm/(turn s)] over 2 pi are those
    here. TwinCAT's D-T1 has the filter time ``Tv / n``.

    References
    ----------
    [AstromHagglund2006]_, chapter 3, implicit differences; [Pieper2024]_.
    """
    gains = {"kp": kp, **_of_derivative(kd, filter_time), **({"ki": ki} if ki else {})}
    derivative = _derivative(derivative_of, filter_time)
    output = gain("kp") * _ERROR + added(feed_forward)
    output += gain("kd") * derivative.value if kd else 0
    memory = derivative.memory if kd else ()
    output += gain("ki") * gain("integral") if ki else 0
    return with_integral(
        _name(ki, kd),
        period=period,
        output=output,
        gains=gains,
        memory=memory,
        error=_ERROR,
        time=gain("kp") / gain("ki"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )


def pid_ideal(
    *,
    k: float,
    period: float,
    ti: float | None = None,
    td: float = 0.0,
    filter_time: float = 0.0,
    derivative_of: str = "error",
    feed_forward: Amount | None = None,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """PID in ideal form, also called standard or ISA.

    ``u = k (e + I / ti + td D) + feed_forward``, with e, I and D of `pid`.

    Parameters
    ----------
    k : float
        Control over position: N m/rad, V/m.
    period : float
        Sampling period T, s.
    ti : float, optional
        Integral time, s; no integral without it.
    td : float
        Derivative time, s.
    filter_time, derivative_of, feed_forward, anti_windup
        As in `pid`.
    tracking_time : float, optional
        Of back-calculation, s; `ti` by default.

    Notes
    -----
    TwinCAT's PID: ``Kp``, ``Tn``, ``Tv`` and ``Td`` are `k`, `ti`, `td` and `filter_time`.

    References
    ----------
    [AstromHagglund2006]_, equation (3.1).
    """
    gains = {"k": k, **_of_derivative(in_range(td, "the derivative time td"), filter_time, "td")}
    derivative = _derivative(derivative_of, filter_time)
    inner = _ERROR + (gain("td") * derivative.value if td else 0)
    memory = derivative.memory if td else ()
    output = gain("k") * inner + added(feed_forward)
    if ti is not None:
        gains["ti"] = in_range(ti, "the integral time ti", positive=True)
        output += gain("k") * gain("integral") / gain("ti")
    return with_integral(
        f"{_name(0 if ti is None else 1, td)}, ideal form",
        period=period,
        output=output,
        gains=gains,
        memory=memory,
        error=_ERROR,
        time=gain("ti"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )


def _of_derivative(value: float, filter_time: float, name: str = "kd") -> dict[str, float]:
    """The derivative's gain and the time constant of its filter, where there are any."""
    smooth = in_range(filter_time, "the filter time of a derivative")
    if not value:
        return {}
    return {name: value, **({"filter_time": smooth} if smooth else {})}


def _derivative(of: str, filter_time: float) -> Block:
    """Of the error or the position, by implicit differences behind a filter."""
    chosen(of, "derivative_of", DERIVATIVES)
    value = _ERROR if of == "error" else -MEASURED_POSITION
    at_rest = REFERENCE - MEASURED_POSITION if of == "error" else -MEASURED_POSITION
    last = Memory("last", following=value, start=at_rest)
    if not filter_time:
        return Block((value - last.symbol) / PERIOD, (last,))
    time, name = gain("filter_time"), "derivative"
    rate = (time * sympy.Symbol(name, real=True) + value - last.symbol) / (time + PERIOD)
    return Block(rate, (last, Memory(name, following=rate, start=sympy.S.Zero)))


def _name(integral: float, derivative: float) -> str:
    return f"P{'I' if integral else ''}{'D' if derivative else ''}"
