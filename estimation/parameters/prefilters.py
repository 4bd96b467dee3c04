"""Filters for records of different periods: one cut-off, and rows as far apart in all of them."""

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from axisid.estimation.records import is_same_period
from axisid.estimation.signals import Prefilter, matching_decimation
from axisid.support.errors import UsageError
from axisid.support.remedy import Remedy, Setting

_MOST_ROWS_APART = 1000  # samples of the fastest record between rows
_FARTHER = 1.2  # than was asked for, from which rows are rather nearer than that
_FINEST = 50  # of a ratio of periods, its largest denominator


def prefilters_of(asked: Prefilter, designed: float, periods: Sequence[float]) -> list[Prefilter]:
    """The filter for each record, its decimation chosen so that rows are as far apart in all.

    Parameters
    ----------
    asked : Prefilter
        As it is for a record of the period `designed`.
    designed : float
        s
    periods : sequence of float
        Of the records, s.

    Raises
    ------
    UsageError
        The periods have no common multiple that rows can be apart by.
    """
    if all(is_same_period(period, designed) for period in periods):
        return [asked] * len(periods)
    ratios = [Fraction(period / designed).limit_denominator(_FINEST) for period in periods]
    whole = [
        ratio > 0 and is_same_period(float(ratio) * designed, period)
        for ratio, period in zip(ratios, periods, strict=True)
    ]
    if not all(whole):
        raise _apart(periods)
    step = math.lcm(*(ratio.numerator for ratio in ratios))
    least = Fraction(step, math.gcd(*(ratio.denominator for ratio in ratios)))
    apart = _multiple(least, asked.decimate, matching_decimation(asked.cutoff, designed))
    every = [apart / ratio for ratio in ratios]
    if any(one.denominator != 1 or one > _MOST_ROWS_APART for one in every):
        raise _apart(periods)
    return [
        replace(asked.at_period(designed, period), decimate=int(one))
        for period, one in zip(periods, every, strict=True)
    ]


def _multiple(least: Fraction, decimate: int, lowest: int) -> Fraction:
    """Rows apart about as far as was asked for, and no finer than the cut-off allows."""
    above = least * max(1, math.ceil(Fraction(decimate) / least))
    below = above - least
    return below if above > _FARTHER * decimate and below >= min(lowest, decimate) else above


def _apart(periods: Sequence[float]) -> UsageError:
    listed = ", ".join(f"{period:.6g}" for period in periods)
    return UsageError(
        f"the records are sampled every {listed} s, which have no common multiple for rows to be "
        "apart by; ",
        Remedy.of("resample them to one rate with ", Setting("resample", "HZ"), "."),
        code="no-common-period",
    )
