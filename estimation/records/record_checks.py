"""What is no record: columns, spans and times that no axis could have been sampled as."""

from collections.abc import Mapping
from operator import index

import numpy as np
from numpy.typing import ArrayLike

from axisid.estimation.thresholds import LARGEST_VALUE, MIN_RECORD_SAMPLES
from axisid.support.arrays import Array, frozen
from axisid.support.errors import DataError, UsageError, quoted, real_array

from .repairs import Span


def checked_column(source: str, role: str, values: ArrayLike) -> Array:
    """A column as a frozen array of finite numbers, (N,)."""
    column = frozen(real_array(values, f"{source}: the {role}", DataError))
    if column.ndim != 1:
        raise DataError(
            f"{source}: the {role} has the shape {column.shape}; give one row of numbers.",
            code="record",
        )
    largest = LARGEST_VALUE.value
    bad = np.flatnonzero(~(np.abs(column) <= largest))
    if bad.size:
        raise DataError(
            f"{source}: the {role} is {column[bad[0]]:g} in data row {bad[0] + 1} ({bad.size} in "
            f"all), and no signal is that, or larger than {largest:g}. Remove such rows or repair "
            "the log.",
            code="not-finite",
        )
    return column


def checked_spans(source: str, name: str, spans: object) -> tuple[Span, ...]:
    """Pairs of whole numbers."""
    try:
        return tuple((index(start), index(stop)) for start, stop in spans)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"{source}: the {name} are {quoted(spans)}; give pairs of rows, the first and the one "
            "after the last."
        ) from error


def check_lengths(source: str, channels: Mapping[str, Array]) -> None:
    """Refuse columns of several lengths, or of less than a record has."""
    lengths = {role: len(values) for role, values in channels.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
        raise DataError(
            f"{source}: the columns differ in length: {listed}; give a value of each at each time.",
            code="record",
        )
    fewest = MIN_RECORD_SAMPLES.value
    if lengths["time"] < fewest:
        raise DataError(
            f"{source}: a record needs {fewest} rows or more, not {lengths['time']}.",
            code="too-short",
        )


def check_spans(
    source: str, time: Array, segments: tuple[Span, ...], masked: tuple[Span, ...]
) -> None:
    """Refuse segments that do not follow one another, and masked samples that there are not."""
    fewest, samples = MIN_RECORD_SAMPLES.value, len(time)
    ends = [0, *(end for span in segments for end in span), samples]
    whole = not segments or ends[::2] == ends[1::2]
    for start, stop in segments:
        if whole and start < stop < start + fewest:
            raise DataError(
                f"{source}: the part from {time[start]:.6g} to {time[stop - 1]:.6g} s has "
                f"{stop - start} of its rows, and needs {fewest} or more; give a longer window, or "
                "leave it out.",
                code="too-short",
            )
    lasting = all(stop > start for start, stop in segments)
    inside = all(0 <= start < stop <= samples for start, stop in masked)
    if not (whole and lasting and inside):
        raise DataError(
            f"{source}: the segments {segments} and masked rows {masked} are no parts of {samples} "
            f"rows; segments follow one another, with {fewest} rows or more each.",
            code="record",
        )


def check_vary(source: str, columns: Mapping[str, Array]) -> None:
    """Refuse a column of one value."""
    for role, values in columns.items():
        if values.min() == values.max():
            raise DataError(
                f"{source}: the {role} is {values[0]:g} in every row, so it says nothing "
                f"about the axis. Check the {role} column, or record a motion.",
                code="not-shown",
            )
