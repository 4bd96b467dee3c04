"""Whether a sampling period is one, and the one of the times that it is said of."""

import math

from axisid.estimation.records.times import RESAMPLE_EVENLY, UNEVEN
from axisid.estimation.thresholds import MAX_MEAN_STEP_DEVIATION
from axisid.support.errors import DataError, UsageError
from axisid.support.real_numbers import is_real
from axisid.support.user_values import quoted

_MAX_STATED_PERIOD_DEVIATION = 0.005  # relative difference of a given period from the time column's


def check_even(source: str, typical: float, mean: float, period: float | None) -> None:
    """Refuse a median and a mean step, s, that are apart, or are not the period that was given."""
    if not abs(mean / typical - 1) < MAX_MEAN_STEP_DEVIATION.value:
        raise DataError(
            f"{source}: the time steps are uneven: {typical:.6g} s in the middle, "
            f"{mean:.6g} s in the mean. ",
            RESAMPLE_EVENLY,
            code=UNEVEN,
        )
    if period is not None:
        check_stated(source, typical, period)


def check_stated(source: str, found: float, stated: float, uncertainty: float = 0.0) -> None:
    """Refuse a sampling period that was given, s, and is not the one of the time column."""
    if not abs(stated / found - 1) < _MAX_STATED_PERIOD_DEVIATION + uncertainty:
        raise DataError(
            f"{source}: the sampling period is given as {stated:g} s, but the time "
            f"column steps by {found:g} s. Correct one of them (time is in seconds).",
            code="other-sample-period",
        )


def check_sample_period(period: object) -> None:
    """Refuse what is no sampling period."""
    if period is not None and not (is_real(period) and 0 < period < math.inf):
        raise UsageError(
            f"the sampling period is {quoted(period)}; give a positive number of seconds.",
            code="bad-sample-period",
        )
