"""Whether the last number of a text log was cut off as the logger stopped: its neighbours tell."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.thresholds.logs import (
    MAX_LAST_NUMBER_BEND,
    MIN_NUMBERS_BEFORE_CUT,
    MIN_NUMBERS_BEFORE_ENDED_CUT,
)

#: Rows above the last that are looked at.
NEIGHBOURS = 400
_NUMBER = re.compile(r"[+-]?(?=\.?\d)(?P<whole>\d*)(?P<decimals>\.\d*)?(?P<power>[eE][+-]?\d+)?")


@dataclass(frozen=True, slots=True)
class _WrittenNumber:
    """How a number is written: the characters of its parts, with the mark that begins them."""

    value: float
    whole: int
    decimals: int
    power: int
    mantissa: float
    exponent: int


def cut_number(cells: Sequence[str], ends: Sequence[str], *, ended: bool) -> str:
    """Why the last of a column of numbers looks cut off; empty where it does not.

    It is cut where the lines above end with a sign that its own lacks; where the rows above all
    have as many decimals or as long an exponent, and it has less; and, in a file that breaks off
    within a line, where it has fewer decimals than any of them or is far from them, and digits that
    are missing would explain its value.

    Parameters
    ----------
    cells : sequence of str
        The last cell of each row, with a decimal point.
    ends : sequence of str
        The last character of each row's line.
    ended : bool
        Whether the last line has its end.
    """
    *above, last = map(_written, cells)
    numbers = [number for number in above if number is not None]
    fewest = MIN_NUMBERS_BEFORE_ENDED_CUT if ended else MIN_NUMBERS_BEFORE_CUT
    if last is None or len(numbers) < fewest.value:
        return ""
    if len({*ends[:-1]}) == 1 and not ends[0].isalnum() and ends[-1] != ends[0]:
        return f"the lines above end with {ends[0]!r}"
    if last.power < min(n.power for n in numbers) == max(n.power for n in numbers):
        return "the numbers above it have a longer exponent"
    decimals = min(n.decimals for n in numbers)
    if last.decimals < decimals == max(n.decimals for n in numbers):
        return f"the numbers above it have {decimals - 1} decimals"
    return "" if ended else _by_value(last, numbers)


def _by_value(last: _WrittenNumber, numbers: Sequence[_WrittenNumber]) -> str:
    """Why a number is none that goes on from those above it, where missing digits explain it."""
    powers = [n.power for n in numbers if n.power]
    values = np.array([n.value for n in numbers])
    expected = 2 * values[-1] - values[-2]
    bend = float(np.abs(np.diff(values, 2)).max())
    whole = last.power >= min(powers, default=1)
    if whole or not _explained(last, expected, 2 * bend, numbers):
        return ""
    fewest, digits = min(n.decimals for n in numbers), min(n.whole for n in numbers)
    if last.decimals < fewest:
        return f"every number above it has {fewest - 1} decimals or more"
    if not last.decimals and last.whole < digits:
        return f"every number above it has {digits} digits or more"
    if abs(last.value - expected) > MAX_LAST_NUMBER_BEND.value * bend:
        return f"the numbers above it lead to {expected:.6g}"
    return ""


def _written(cell: str) -> _WrittenNumber | None:
    found = _NUMBER.fullmatch(cell)
    if found is None:
        return None
    whole, decimals, power = (len(found[name] or "") for name in ("whole", "decimals", "power"))
    mantissa = cell[: len(cell) - power]
    return _WrittenNumber(
        value=float(cell),
        whole=whole,
        decimals=decimals,
        power=power,
        mantissa=float(mantissa),
        exponent=int(cell[len(mantissa) + 1 :]) if power else 0,
    )


def _explained(
    last: _WrittenNumber, expected: float, reach: float, numbers: Sequence[_WrittenNumber]
) -> bool:
    """Whether digits that are missing would bring a number to within reach of what is expected."""
    along = abs(expected) if not last.mantissa else float(np.sign(last.mantissa)) * expected
    size, unit = abs(last.mantissa), 10.0 ** -max(last.decimals - 1, 0)
    missing = 0 if last.decimals else max(max(n.whole for n in numbers) - last.whole, 0)
    exponents = {n.exponent for n in numbers if n.power > last.power}
    # A whole number among whole numbers has no decimals that may be missing.
    least_missing = 0 if any(n.decimals for n in numbers) or last.power else 1
    powers = np.array([*range(least_missing, missing + 1), *exponents], dtype=float)
    with np.errstate(all="ignore"):  # what no number holds explains nothing
        scales = 10.0**powers
        least, most = size * scales - reach, (size + unit) * scales + reach
        return bool(np.any((least <= along) & (along <= most)))
