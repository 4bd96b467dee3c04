"""Ticks of matplotlib's axes: three or more, written as numbers are read."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import Formatter, MaxNLocator

from axisid.presentation.formulas import power_of_ten, true_minus

_FEWEST = 3
_DECADES = 6  # about as many ticks
_THREE, _SIX = (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)  # of a decade
_ROUNDING = 1e-9
_PLAIN = (1e-2, 1e5)  # between them numbers are written without a power of ten


def set_ticks(axis: Axis, *, log: bool = False, whole: bool = False) -> None:
    """Give an axis ticks for the range that it shows.

    Parameters
    ----------
    axis : matplotlib.axis.Axis
        Its limits are final.
    log : bool
        Whether it is logarithmic.
    whole : bool
        Whether it counts.
    """
    if log:
        ticks = log_ticks(*sorted(axis.get_view_interval()))
        axis.set_ticks(ticks, [number_text(tick) for tick in ticks])
        axis.set_ticks([], minor=True)
        return
    fewest = 1 if whole else _FEWEST
    axis.set_major_locator(
        MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10], integer=whole, min_n_ticks=fewest)
    )
    axis.set_major_formatter(Thousands())


def log_ticks(first: float, last: float) -> list[float]:
    """Round numbers on a logarithmic scale: decades, or more of each where those are few."""
    low, high = int(np.floor(np.log10(first))), int(np.ceil(np.log10(last)))
    every = max(1, round((high - low) / _DECADES))
    for step, multiples in (*((e, (1.0,)) for e in range(every, 0, -1)), (1, _THREE), (1, _SIX)):
        decades = range(step * (low // step), high + 1, step)
        ticks = [m * 10.0**d for d in decades for m in multiples]
        inside = [t for t in ticks if first * (1 - _ROUNDING) <= t <= last * (1 + _ROUNDING)]
        if len(inside) >= _FEWEST:
            return inside
    even = MaxNLocator(5, min_n_ticks=_FEWEST).tick_values(first, last)
    return [float(tick) for tick in even if first <= tick <= last and tick > 0]


def number_text(value: float) -> str:
    """A tick's number: plain, or with a power of ten where that is shorter."""
    if value == 0 or _PLAIN[0] <= abs(value) < _PLAIN[1]:
        return true_minus(f"{value:.12g}")
    mantissa, exponent = f"{value:.6e}".split("e")
    factor = true_minus(f"{float(mantissa):g}")
    return power_of_ten(int(exponent), "" if factor == "1" else factor)


class Thousands(Formatter):
    """Plain numbers; of very large or small ones a power of 1000 is taken out."""

    def __init__(self) -> None:
        self._power, self._digits = 0, 0

    def __call__(self, x: float, pos: int | None = None) -> str:  # noqa: ARG002
        """Text of one tick."""
        text = f"{x / 10.0**self._power:.{self._digits}f}"
        return true_minus(text) if float(text) else text.replace("-", "")

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        """Texts of all ticks, with the same digits."""
        largest = max(map(abs, values), default=0.0)
        exponent = int(np.floor(np.log10(largest) + 1e-9)) if largest else 0
        self._power = 3 * (exponent // 3) if not -2 <= exponent <= 4 else 0
        scaled = np.asarray(values, dtype=float) / 10.0**self._power
        self._digits = next((d for d in range(12) if _same(scaled, d)), 12)
        return [self(value) for value in values]

    def get_offset(self) -> str:
        """The power that was taken out."""
        return f"\u00d7 {power_of_ten(self._power)}" if self._power else ""


def _same(values: np.ndarray, digits: int) -> bool:
    return bool(np.allclose(np.round(values, digits), values, rtol=1e-9, atol=1e-9))
