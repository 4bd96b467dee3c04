"""Whether samples are among several records more than once: a record given twice, or an overlap.

Two files of one recorder may hold the same samples, with times of their own: rows 1 to 10000 of a
log, and rows 5000 to 15000. Times are therefore not looked at. Rows of what was measured that occur
once in either record are looked for in both; where many of them are equally far apart, the samples
there are compared one by one. An axis at rest repeats its rows, so that two records that both rest
have nothing in common. Numbers are compared as 32-bit floats, since files
may write them with other digits, or in other units. Of records that were resampled the rows before
are compared, where they are kept: those of columns of one clock.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check
from axisid.estimation.records import Record, record_labels
from axisid.estimation.thresholds import MAX_REPEATED_SAMPLES, MIN_COMMON_SAMPLES
from axisid.support.arrays import Array

# rows, each once in either record and equally far apart
_MIN_COMMON_ROWS = 25
# of the column's largest: one number in other digits or units; files have six or more
_MAX_WRITTEN_APART = 1e-6

NAME = "repeated records"

_Places = NDArray[np.intp]
_Chosen = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlap:
    """Samples that two records have in common.

    Attributes
    ----------
    records : (int, int)
        Which two.
    samples : ((N,) array of bool, (M,) array of bool)
        Which of the one, and which of the other.
    times : ((float, float), (float, float))
        First and last of them, s, as each record's own time counts.
    """

    records: tuple[int, int]
    samples: tuple[_Chosen, _Chosen]
    times: tuple[tuple[float, float], tuple[float, float]]

    @property
    def is_whole(self) -> bool:
        """Whether both records are these samples."""
        return all(bool(chosen.all()) for chosen in self.samples)


def overlaps(records: Sequence[Record]) -> tuple[Overlap, ...]:
    """What every two of the records have in common, in their order."""
    pairs = combinations(range(len(records)), 2)
    found = (_overlap((i, j), records[i], records[j]) for i, j in pairs)
    return tuple(each for each in found if each is not None)


def repeated_check(records: Sequence[Record]) -> Check | None:
    """Whether samples are given more than once, which says nothing new; None where none are."""
    found = overlaps(records)
    if not found:
        return None
    times = mean_times(records, found)
    return Check(
        name=NAME,
        status="fail" if times > MAX_REPEATED_SAMPLES.value else "note",
        figure=times,
        threshold=MAX_REPEATED_SAMPLES.value,
        source="how often a sample is among the records, on average: variances are too small by as "
        "much",
        meaning=f"{_told(found, record_labels(records))}; deviations are up to {times**0.5:.3g} "
        "times too small: give each sample once",
    )


def mean_times(records: Sequence[Record], found: Sequence[Overlap]) -> float:
    """How often a sample is among the records, on average over all that are given."""
    counts = [np.ones(len(record)) for record in records]
    for each in found:
        for record, chosen in zip(each.records, each.samples, strict=True):
            counts[record] += chosen
    return float(np.mean(np.concatenate(counts)))


def _overlap(pair: tuple[int, int], one: Record, other: Record) -> Overlap | None:
    records = one, other
    written = one.sampled or one, other.sampled or other
    columns = _measured(*written)
    if not columns:
        return None
    found = np.zeros(len(written[0]), dtype=bool), np.zeros(len(written[1]), dtype=bool)
    places, others = _equal_rows(columns)
    distances, counts = np.unique(others - places, return_counts=True)
    for distance in distances[counts >= _MIN_COMMON_ROWS]:
        start, stop = _stretch(columns, places[others - places == distance], int(distance))
        found[0][start:stop] = True
        found[1][start + distance : stop + distance] = True
    first_chosen, second_chosen = (
        each if rows is record else np.interp(record.time, rows.time, each) == 1
        for record, rows, each in zip(records, written, found, strict=True)
    )
    if not (first_chosen.any() and second_chosen.any()):
        return None
    chosen = first_chosen, second_chosen
    ends = [np.flatnonzero(each)[[0, -1]] for each in chosen]
    (a, b), (c, d) = (r.time[end] for r, end in zip(records, ends, strict=True))
    return Overlap(records=pair, samples=chosen, times=((float(a), float(b)), (float(c), float(d))))


def _measured(one: Record, other: Record) -> list[tuple[Array, Array]]:
    """What both records measured of the motion and of the drive; empty without either.

    A reference is the same whenever it is run, and a position in few steps may be.
    """
    roles = [*one.motion, "control", "force"]
    both = [role for role in roles if role in one.channels() and role in other.channels()]
    if not {"control", "force"} & {*both} or len(both) < 2:
        return []
    return [(one.channels()[role], other.channels()[role]) for role in both]


def _equal_rows(columns: Sequence[tuple[Array, Array]]) -> tuple[_Places, _Places]:
    """Where rows are that occur once in either record, in the one and in the other."""
    with np.errstate(all="ignore"):
        sides = (np.column_stack(side).astype(np.float32) for side in zip(*columns, strict=True))
        (one, places), (other, others) = (_once(rows + np.float32(0)) for rows in sides)  # -0 is 0
    _, i, j = np.intersect1d(one, other, assume_unique=True, return_indices=True)
    return places[i], others[j]


def _once(rows: NDArray[np.float32]) -> tuple[NDArray[np.void], _Places]:
    """Rows that occur once, as their bytes, and where."""
    values = np.ascontiguousarray(rows).view(f"V{rows[0].nbytes}")[:, 0]
    found, places, counts = np.unique(values, return_index=True, return_counts=True)
    return found[counts == 1], places[counts == 1]


def _stretch(
    columns: Sequence[tuple[Array, Array]], places: _Places, distance: int
) -> tuple[int, int]:
    """First sample of the one record that both have, and the one after the last; (0, 0) if none.

    Rows that two runs of one motion have alike by chance have others between.
    """
    a, b = max(0, -distance), max(0, distance)
    n = min(len(columns[0][0]) - a, len(columns[0][1]) - b)
    same = np.ones(n, dtype=bool)
    for x, y in columns:
        size = float(np.max(np.abs(x)))
        same &= np.abs(x[a : a + n] - y[b : b + n]) <= _MAX_WRITTEN_APART * size
    first, last = int(places.min()) - a, int(places.max()) - a + 1
    if np.mean(same[first:last]) < MIN_COMMON_SAMPLES.value:
        return 0, 0
    before, after = np.flatnonzero(~same[:first]), np.flatnonzero(~same[last:])
    start = int(before[-1]) + 1 if before.size else 0
    return a + start, a + last + int(after[0]) if after.size else a + n


def _told(found: Sequence[Overlap], names: Sequence[str]) -> str:
    said = []
    for each in found:
        (i, j), (of_one, of_other) = each.records, each.times
        if each.is_whole:
            said.append(f"{names[i]} and {names[j]} have the same samples")
            continue
        said.append(
            f"{names[i]} and {names[j]} have {int(each.samples[0].sum())} samples in common, from "
            f"{of_one[0]:.6g} to {of_one[1]:.6g} s of the first and from {of_other[0]:.6g} to "
            f"{of_other[1]:.6g} s of the second"
        )
    return "; ".join(said)
