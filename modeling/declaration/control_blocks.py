"""Blocks of control laws: filters, derivatives and limits, each a value with its memory.

The memories of a block have names that begin with the given name, so that a law may contain several
blocks of the same kind. A number in a block may be a plain number or an expression, such as a gain
of the law, `gain("cutoff")`. The check of the control law can name a gain, but not a plain number.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import sympy

from axisid.modeling.quantities import (
    MEASURED_POSITION,
    PERIOD,
    REFERENCE,
    Amount,
    expression,
    number,
    within,
)
from axisid.support.checks import is_among
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

from .control import Memory


def amount(value: Amount, what: str, *, positive: bool = False) -> sympy.Expr:
    """Return an amount as an expression; refuse a number that is out of range.

    Parameters
    ----------
    value : Amount
        A number or an expression.
    what : str
        Description of the amount, for messages.
    positive : bool
        Whether a number must be above 0; otherwise it may also be 0.

    Raises
    ------
    ModelError
        The amount is neither a number nor an expression, or is out of range.
    """
    found = _finite(value, what)
    if not found.is_Number:
        return found
    is_allowed = found > 0 if positive else found >= 0
    if not is_allowed:
        expected = "a positive number" if positive else "a number of 0 or more"
        raise ModelError(f"{what} is {quoted(value)}. Give {expected}.", code="law")
    return found


def in_range(value: float, what: str, *, positive: bool = False) -> float:
    """Return a number as a float; refuse a number that is out of range, as in `amount`."""
    found = number(value, what)
    amount(found, what, positive=positive)
    return found


def chosen(value: str, what: str, among: Collection[str]) -> str:
    """Return a word that is among permitted words; refuse another word.

    Parameters
    ----------
    value : str
    what : str
        Description of the word, for messages.
    among : collection of str
        Permitted words.

    Raises
    ------
    ModelError
        The word is not permitted.
    """
    if not is_among(value, among):
        raise ModelError(f"{what} is {quoted(value)}. Give one of {', '.join(among)}.", code="law")
    return value


def added(signal: Amount | None) -> sympy.Expr:
    """Return the feed-forward term of a control as an expression; 0 for None."""
    return sympy.S.Zero if signal is None else _finite(signal, "the feed-forward of a law")


def _finite(value: Amount, what: str) -> sympy.Expr:
    """Return an expression whose numbers are all finite.

    Raises
    ------
    ModelError
        A number in it is not finite.
    """
    found = expression(value, what)
    if found.has(sympy.nan, sympy.zoo, sympy.oo, -sympy.oo):
        raise ModelError(
            f"{what} is {found}. Give a finite number, a recorded signal or an expression of them.",
            code="law",
        )
    return found


@dataclass(frozen=True, slots=True)
class Block:
    """A part of a control law.

    Attributes
    ----------
    value : sympy.Expr
        Value of the block at a sample, for the output of a law or for another block.
    memory : tuple of Memory
        Values that the block stores between samples; add them to `ControlLaw.memory`.
    """

    value: sympy.Expr
    memory: tuple[Memory, ...] = ()


def difference(signal: Amount, *, name: str = "last", start: Amount = 0.0) -> Block:
    """Return the rate of change of a signal, ``(x[k] - x[k-1]) / T``, half a sample late.

    Parameters
    ----------
    signal : expression
    name : str
        Name of the block's memory, the signal at the previous sample.
    start : expression
        The signal before the first sample.
    """
    value = _signal(signal)
    last = Memory(name, following=value, start=_start(start))
    return Block((value - last.symbol) / PERIOD, (last,))


def low_pass(
    signal: Amount, *, time_constant: Amount, name: str = "smooth", start: Amount = 0.0
) -> Block:
    """Return a first-order low-pass as drives compute it, by the implicit Euler method.

    ``y[k] = y[k-1] + T / (T + Tf) (x[k] - y[k-1])``, a cut-off of ``1 / (2 pi Tf)`` Hz.

    Parameters
    ----------
    signal : expression
    time_constant : expression
        Tf, s; 0 for no filter.
    name : str
        Name of the block's memory, the filtered signal at the previous sample.
    start : expression
        The filtered signal before the first sample.

    References
    ----------
    `LowPassFilter` of [Skuric2022]_.
    """
    value, constant = _signal(signal), amount(time_constant, "the time constant of a low-pass")
    last = sympy.Symbol(str(name), real=True)
    smooth = last + PERIOD / (PERIOD + constant) * (value - last)
    return Block(smooth, (Memory(name, following=smooth, start=_start(start)),))


def notch(
    signal: Amount,
    *,
    frequency: Amount,
    quality: Amount = 1.0,
    name: str = "notch",
    start: Amount = 0.0,
) -> Block:
    """Return a second-order band-stop filter, which removes a resonance from a torque.

    ``(1 + b) y[k] = x[k] - 2 c x[k-1] + x[k-2] + 2 c y[k-1] - (1 - b) y[k-2]`` with
    ``c = cos(2 pi f T)`` and ``b = tan(pi f T / Q)``. The gain is 0 at f and 1 for a constant
    signal; half the power passes at the edges of a band of width ``f / Q``.

    Parameters
    ----------
    signal : expression
    frequency : expression
        f, Hz, below half the sampling frequency.
    quality : expression
        Q: the frequency over the width of the band.
    name : str
        Beginning of the names of the block's memories, which end in ``_in1``, ``_in2``, ``_out1``
        and ``_out2``.
    start : expression
        The constant signal before the first sample.

    References
    ----------
    [Orfanidis1996]_, section 11.3; `scipy.signal.iirnotch` computes the same numbers.
    """
    value, rest = _signal(signal), _start(start)
    turn = sympy.pi * amount(frequency, "the frequency of a notch") * PERIOD
    edge = sympy.tan(turn / amount(quality, "the quality of a notch", positive=True))
    names = [f"{name}_{what}" for what in ("in1", "in2", "out1", "out2")]
    in1, in2, out1, out2 = (sympy.Symbol(each, real=True) for each in names)
    middle = 2 * sympy.cos(2 * turn)
    out = (value - middle * in1 + in2 + middle * out1 - (1 - edge) * out2) / (1 + edge)
    following = (value, in1, out, out1)
    return Block(out, tuple(map(Memory, names, following, [rest] * len(names))))


def pll_velocity(*, bandwidth: Amount, name: str = "pll") -> Block:
    """Return the velocity of an encoder by a phase-locked loop, critically damped.

    At each sample the position is predicted, ``p = p + T v``, then both are corrected by the
    measured position q: ``p = p + T 2 b (q - p)`` and ``v = v + T b^2 (q - p)``. It follows a ramp
    without an error and lags by about ``2 / b``.

    Parameters
    ----------
    bandwidth : expression
        b, rad/s; the loop is stable with ``b T`` below 0.828.
    name : str
        Beginning of the names of the block's memories, which end in ``_position`` and
        ``_velocity``.

    References
    ----------
    `Encoder::update` of [ODrive2023]_; b is its ``bandwidth``, 1000 rad/s by default.
    """
    b = amount(bandwidth, "the bandwidth of a phase-locked loop")
    position, velocity = (
        sympy.Symbol(f"{name}_{what}", real=True) for what in ("position", "velocity")
    )
    predicted = position + PERIOD * velocity
    error = MEASURED_POSITION - predicted
    corrected = velocity + PERIOD * b**2 * error
    corrected_position = predicted + PERIOD * 2 * b * error
    memory = (
        Memory(position.name, following=corrected_position, start=MEASURED_POSITION),
        Memory(velocity.name, following=corrected, start=sympy.S.Zero),
    )
    return Block(corrected, memory)


def rate_limit(signal: Amount, *, rate: Amount, name: str = "ramp", start: Amount = 0.0) -> Block:
    """Return a signal with a limited rate of change.

    ``y[k] = y[k-1] + clip(x[k] - y[k-1], -r T, r T)``.

    Parameters
    ----------
    signal : expression
    rate : expression
        r, in the signal's unit per second.
    name : str
        Name of the block's memory, the limited signal at the previous sample.
    start : expression
        The limited signal before the first sample.
    """
    value = _signal(signal)
    largest_step = PERIOD * amount(rate, "the rate of a rate limit", positive=True)
    last = sympy.Symbol(str(name), real=True)
    ramp = last + within(value - last, largest_step)
    return Block(ramp, (Memory(name, following=ramp, start=_start(start)),))


def reference_velocity(name: str = "reference1") -> Block:
    """Return the velocity of the reference as a difference, ``(r[k] - r[k-1]) / T``."""
    return difference(REFERENCE, name=name, start=REFERENCE)


def reference_acceleration(names: tuple[str, str] = ("reference1", "reference2")) -> Block:
    """Return the acceleration of the reference, ``(r[k] - 2 r[k-1] + r[k-2]) / T^2``.

    The first memory is the same as that of `reference_velocity`, which a law may contain too.
    """
    first = Memory(names[0], following=REFERENCE, start=REFERENCE)
    second = Memory(names[1], following=first.symbol, start=REFERENCE)
    return Block((REFERENCE - 2 * first.symbol + second.symbol) / PERIOD**2, (first, second))


def _signal(signal: Amount) -> sympy.Expr:
    """Return the signal of a block as an expression."""
    return expression(signal, "the signal of a block")


def _start(start: Amount) -> sympy.Expr:
    """Return the start value of a block as an expression."""
    return expression(start, "the start of a block")


#: The ready-made blocks, by their names in TOML declarations.
BLOCKS: Mapping[str, Callable[..., Block]] = MappingProxyType(
    {
        block.__name__: block
        for block in (
            difference,
            low_pass,
            notch,
            pll_velocity,
            rate_limit,
            reference_velocity,
            reference_acceleration,
        )
    }
)
