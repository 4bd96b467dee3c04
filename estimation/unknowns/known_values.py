"""Known values of each of several records, by name of a parameter or a gain.

Examples are a payload, an angle, a temperature or a gain of the law: a number, or a number with its
standard deviation, for each record in order.
"""

import math
from collections.abc import Iterable, Mapping, Sequence

from axisid.support.checks import by_name, is_real
from axisid.support.errors import UsageError
from axisid.support.wording import quoted

#: A value, or a value with its standard deviation.
KnownValue = float | tuple[float, float]


#: Value and standard deviation in each record, SI, by name of a declared parameter or a gain of the
#: control law; the standard deviation of an exact value is 0.
KnownValues = Mapping[str, tuple[tuple[float, float], ...]]


def known_of(told: Mapping[str, Sequence[KnownValue]] | None, records: int) -> KnownValues:
    """Return the known values of each record with their standard deviations, by name.

    Parameters
    ----------
    told : mapping of str to sequence of KnownValue, or None
        Known values as the user gave them; None for none.
    records : int
        Number of records.

    Raises
    ------
    UsageError
        The number of values is not that of records, or a value is no number or pair of numbers.
    """
    counted = "is 1 record" if records == 1 else f"are {records} records"
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for name, given in by_name(told, "known values").items():
        if isinstance(given, str) or not isinstance(given, Iterable):
            raise UsageError(
                f"the known values of {name!r} are {quoted(given)}. Give a list with one entry for "
                "each record: a number, or a number and its standard deviation.",
                code="parameters",
            )
        entries = tuple(_pair(name, entry) for entry in given)
        if len(entries) != records:
            raise UsageError(
                f"{name!r} has {len(entries)} known value{'s' * (len(entries) != 1)}, but there "
                f"{counted}. Give one value for each record, in the order of the records.",
                code="parameters",
            )
        found[name] = entries
    return found


def _pair(name: str, entry: object) -> tuple[float, float]:
    """Return a known value and its standard deviation, which is 0 for a single number.

    An entry that is no finite number or pair of numbers is refused; `name` is for the message.
    """
    pair = tuple(entry) if isinstance(entry, (tuple, list)) else (entry, 0.0)
    is_finite = len(pair) == 2 and all(is_real(x) and math.isfinite(x) for x in pair)
    if not is_finite or pair[1] < 0:
        raise UsageError(
            f"a known value of {name!r} is {quoted(entry)}. Give a finite number, or a finite "
            "number and its standard deviation, 0 or more.",
            code="parameters",
        )
    return float(pair[0]), float(pair[1])
