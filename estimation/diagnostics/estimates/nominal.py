"""Parameters against the nominal values that they were declared with, as a remark."""

from collections.abc import Iterable

import numpy as np

from axisid.estimation.checks import Check
from axisid.modeling.quantities import Parameter

_MAX_FROM_NOMINAL = 5.0  # times the nominal value, of the whole interval

NOMINAL_VALUES = "nominal values"


def nominal_check(
    found: Iterable[tuple[Parameter, float, tuple[float, float]]],
) -> Check | None:
    """Remark values that are another order of size than declared; None where none is.

    A column in another unit makes such values, which nothing else tells where no law is simulated.
    Of parameters that may have either sign, such as an offset, any size is as declared.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each with its value and its interval, all of which is as far.
    """
    most, far = _MAX_FROM_NOMINAL, dict[Parameter, float]()
    for parameter, value, interval in found:
        if parameter.lower >= 0 < parameter.nominal:
            ratio, *ends = np.array([value, *interval]) / parameter.nominal
            if min(ratio, *ends) > most or max(ratio, *ends) < 1 / most:
                far[parameter] = float(ratio)
    if not far:
        return None
    listed = ", ".join(
        f"{p.name} = {ratio * p.nominal:.4g} {p.unit} is {ratio:.2g} times its nominal "
        f"{p.nominal:.4g}"
        for p, ratio in far.items()
    )
    return Check(
        name=NOMINAL_VALUES,
        status="note",
        figure=next(iter(far.values())),
        threshold=most,
        source="chosen: units are apart by 6.28, 9.81, 57.3 or powers of ten",
        meaning=f"{listed}: check the units of the record's columns and the drive's gain, or "
        "declare another nominal value",
    )
