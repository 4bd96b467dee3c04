"""What each of several records has for itself: what is known of it, and its filter.

Known is a payload, an angle, a temperature, a gain of the law: a number, or a number with its
standard deviation, for each record in their order. Filters for records of different periods have
one cut-off, and rows as far apart in all of them.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from axisid.estimation.records import is_same_period
from axisid.estimation.signals import Prefilter, matching_decimation
from axisid.support.errors import UsageError, by_name, is_real, quoted

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_LIST = re.compile(r"\s*(\w+)\s*=(.*)", re.DOTALL)
_ENTRY = re.compile(rf"\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")

#: A value, or a value with its standard deviation.
KnownValue = float | tuple[float, float]


#: By name, a declared parameter or a gain of the control law, its value in each record, SI, with
#: its standard deviation, 0 where it is exact.
KnownValues = Mapping[str, tuple[tuple[float, float], ...]]


def values_text(values: Sequence[tuple[float, float]]) -> str:
    """Values in words: ``0, 20 +- 0.01``."""
    return ", ".join(f"{value:g}" + f" +- {sd:g}" * (sd > 0) for value, sd in values)


def known_of(told: Mapping[str, Sequence[KnownValue]] | None, records: int) -> KnownValues:
    """What is known of each of so many records, from values by name.

    Raises
    ------
    UsageError
        They are not as many as records, or one is no number or pair of numbers.
    """
    counted = "is 1 record" if records == 1 else f"are {records} records"
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for name, given in by_name(told, "known values").items():
        if isinstance(given, str) or not isinstance(given, Iterable):
            raise UsageError(
                f"what is known of {name!r} is {quoted(given)}; give a list with a number, or a "
                "number and its deviation, for each record.",
                code="parameters",
            )
        entries = tuple(_pair(name, entry) for entry in given)
        if len(entries) != records:
            raise UsageError(
                f"{name!r} has {len(entries)} known value{'s' * (len(entries) != 1)}, and there "
                f"{counted}; give one for each, in their order.",
                code="parameters",
            )
        found[name] = entries
    return found


def read_known(texts: Iterable[str]) -> dict[str, tuple[tuple[float, float], ...]]:
    """Values by record from texts such as ``m_add=0,20+-0.01``.

    Raises
    ------
    UsageError
        A text is something else, or a name is given twice.
    """
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for text in texts:
        match = _LIST.fullmatch(text)
        entries = [_ENTRY.fullmatch(part) for part in match[2].split(",")] if match else [None]
        if match is None or not all(entries):
            wrong = next(
                (f", of which number {i} is no value" for i, e in enumerate(entries, 1) if not e),
                "",
            )
            raise UsageError(
                f"{text!r} says nothing of each record{wrong * (match is not None)}; write "
                "NAME=V1,V2,..., SI, one value for each record in their order, each with its "
                "deviation if it has one: m_add=0,20+-0.01.",
                code="parameters",
            )
        if match[1] in found:
            raise UsageError(
                f"{match[1]!r} is known twice; give all its values once.", code="parameters"
            )
        found[match[1]] = tuple((float(e[1]), float(e[2] or 0.0)) for e in entries if e)
    return found


def _pair(name: str, entry: object) -> tuple[float, float]:
    pair = tuple(entry) if isinstance(entry, (tuple, list)) else (entry, 0.0)
    sound = len(pair) == 2 and all(is_real(x) and math.isfinite(x) for x in pair)
    if not sound or pair[1] < 0:
        raise UsageError(
            f"a known value of {name!r} is {quoted(entry)}; give a finite number, or one and its "
            "standard deviation, 0 or more.",
            code="parameters",
        )
    return float(pair[0]), float(pair[1])


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
    whole = all(
        ratio > 0 and is_same_period(float(ratio) * designed, period)
        for ratio, period in zip(ratios, periods, strict=True)
    )
    decimations = _decimations(asked, designed, ratios) if whole else []
    if not decimations or any(d.denominator != 1 or d > _MOST_ROWS_APART for d in decimations):
        listed = ", ".join(f"{period:.6g}" for period in periods)
        raise UsageError(
            f"the records are sampled every {listed} s, which have no common multiple for "
            "rows to be apart by; check the unit of each record's time (columns time=NAME:UNIT), "
            "or resample them to one rate with resample=HZ.",
            code="parameters",
        )
    return [
        replace(asked.at_period(designed, period), decimate=int(decimation))
        for period, decimation in zip(periods, decimations, strict=True)
    ]


def _decimations(asked: Prefilter, designed: float, ratios: list[Fraction]) -> list[Fraction]:
    """Of records by their periods over the designed one: rows about as far apart as asked for.

    They are no finer than the cut-off allows.
    """
    step = math.lcm(*(ratio.numerator for ratio in ratios))
    least = Fraction(step, math.gcd(*(ratio.denominator for ratio in ratios)))
    above = least * max(1, math.ceil(Fraction(asked.decimate) / least))
    below, finest = above - least, matching_decimation(asked.cutoff, designed)
    nearer = above > _FARTHER * asked.decimate and below >= min(finest, asked.decimate)
    return [(below if nearer else above) / ratio for ratio in ratios]
