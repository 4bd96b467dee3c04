"""A value beside its deviation, with the digits that they warrant."""

import math

from axisid.estimation.estimates import Value
from axisid.presentation.blocks import Quantity

_SMALL, _VAGUE = 0.01, 1e4  # percent of the value, of a deviation


def quantity(value: Value) -> Quantity:
    """Value and deviation; then relative deviation and i.i.d. deviation, digits as they warrant."""
    digits = places(value)
    relative = value.relative_deviation_percent
    percent = f"{relative:.2f} %" if relative >= _SMALL else f"{relative:.1g} %"
    percent = percent if relative < _VAGUE else f">{_VAGUE - 1:.0f} %"
    return Quantity(
        f"{value.value:.{digits}f}",
        f"{value.deviation:.{digits}f}",
        (percent, f"{value.sd:.{digits}f}"),
    )


def places(value: Value) -> int:
    """Decimal places that show four digits of the deviation, four at least."""
    if not 0 < value.sd < math.inf:
        return 4
    return min(max(4, 3 - math.floor(math.log10(value.sd))), 12)
