"""What ready laws and blocks are told: numbers in their range, words of a choice, expressions."""

from collections.abc import Collection
from typing import TypeAlias

import sympy

from axisid.modeling.quantities import Symbolic, expression, number
from axisid.support.errors import ModelError, is_among, quoted

#: What a block takes in place of a number, and a law in place of a recorded signal.
Amount: TypeAlias = sympy.Expr | Symbolic | float


#: Numbers of ready laws that are above 0 where they are among the gains: a time or a limit of 0
#: makes another law, or none.
_POSITIVE = (
    "tn",
    "ti",
    "tracking_time",
    "speed_limit",
    "filter_time",
    "velocity_filter",
    "pll_bandwidth",
)


def positive_among(gains: Collection[str]) -> tuple[str, ...]:
    """Which gains of a ready law are above 0 whatever they change to."""
    return tuple(name for name in _POSITIVE if name in gains)


def amount(value: Amount, what: str, *, positive: bool = False) -> sympy.Expr:
    """A number or an expression; a number is 0 or more, or positive.

    Raises
    ------
    ModelError
        It is no number or expression, or out of range.
    """
    found = _finite(value, what)
    if found.is_Number and not (found > 0 if positive else found >= 0):
        said = "a positive number" if positive else "0 or more"
        raise ModelError(f"{what} is {quoted(value)}; give {said}.", code="law")
    return found


def in_range(value: float, what: str, *, positive: bool = False) -> float:
    """The same of what is a number alone."""
    found = number(value, what)
    amount(found, what, positive=positive)
    return found


def chosen(value: str, what: str, among: Collection[str]) -> str:
    """One word of a choice.

    Raises
    ------
    ModelError
        It is another.
    """
    if not is_among(value, among):
        raise ModelError(f"{what} is {quoted(value)}; give one of {', '.join(among)}.", code="law")
    return value


def added(signal: Amount | None) -> sympy.Expr:
    """What is added to a control: a recorded signal or an expression, else nothing."""
    return sympy.S.Zero if signal is None else _finite(signal, "the feed-forward of a law")


def _finite(value: Amount, what: str) -> sympy.Expr:
    """An expression without what is no finite number.

    Raises
    ------
    ModelError
        It has some.
    """
    found = expression(value, what)
    if found.has(sympy.nan, sympy.zoo, sympy.oo, -sympy.oo):
        raise ModelError(
            f"{what} is {found}; give a finite number, a recorded signal or an expression of them.",
            code="law",
        )
    return found
