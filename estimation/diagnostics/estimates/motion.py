"""Whether the motion told the parameters apart, as checks."""

from collections.abc import Sequence

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.thresholds import (
    MAX_RELATIVE_DEVIATION,
    MIN_ROWS_PER_PARAMETER,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)

from .excitation import Excitation

_NEGLIGIBLE_SIZE = 0.1  # of a vague parameter, in what force and motion make of its unit


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Every parameter against its own deviation; a vague one with the reason."""
    values = estimate.parameters
    relative = {s.name: _relative_percent(s, values[s.name]) for s in excitation}
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    unclear = [s for s in vague if s not in small]
    return precision_check(
        max(relative.values()),
        [f"{s.name} is not identified by this record, because {s.reason}" for s in unclear],
        [s.name for s in small],
        "force",
        "relative HAC deviation in percent, or the i.i.d. one where it is larger and few "
        "rows tell of the parameter; one whose part of the force is below 1 %, deviation "
        "included, may be as vague as it is, unless it could be as large as the unit allows",
    )


def precision_check(
    worst: float, unclear: Sequence[str], small: Sequence[str], of: str, source: str
) -> Check:
    """The check of parameters against their deviations.

    Parameters
    ----------
    worst : float
        Largest relative deviation, %.
    unclear : sequence of str
        What is said of each parameter that is not known.
    small : sequence of str
        Names of those that are as vague, and matter little.
    of : str
        What these are less than 1 % of.
    source : str
        What the figure is.
    """
    clear = "every parameter stands well above its deviation"
    if small:
        clear = (
            f"{', '.join(small)} cannot be told from zero and is less than 1 % of the {of}; every "
            "other parameter stands well above its deviation"
        )
    return Check(
        name="precision",
        status=passed(not unclear),
        figure=worst if np.isfinite(worst) else None,
        threshold=MAX_RELATIVE_DEVIATION.value,
        source=source,
        meaning="; ".join(unclear) or clear,
    )


def _relative_percent(excitation: Excitation, value: Value) -> float:
    """Relative deviation; in few rows residuals are small since the estimate follows them."""
    few = excitation.rows < MIN_ROWS_PER_PARAMETER.value
    deviation = max(value.deviation, value.sd) if few else value.deviation
    return 100.0 * deviation / abs(value.corrected) if value.corrected else float("inf")


def _is_nothing(excitation: Excitation, value: Value) -> bool:
    """Known to be small, not unknown: no other column and no missing motion hides it.

    A term that acts beyond the rows, or beyond the motion, is small in them whatever it is.
    """
    if excitation.alike or excitation.lacking or not value.value:
        return False
    largest = abs(value.value) + 2 * max(value.deviation, value.sd)
    times = largest / abs(value.value)
    return (
        excitation.share * times < NEGLIGIBLE_FORCE.value
        and excitation.largest_share * times < NEGLIGIBLE_PEAK_FORCE.value
        and largest < _NEGLIGIBLE_SIZE * excitation.natural
    )
