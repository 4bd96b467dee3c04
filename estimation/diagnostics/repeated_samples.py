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

# rows, each once in either record and equally far apart
_MIN_COMMON_ROWS = 25
# of the column's largest: one number in other digits or units; files have six or more
_MAX_WRITTEN_APART = 1e-6

NAME = "repeated records"

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

    def told(self, names: Sequence[str]) -> str:
        """Which samples these are, in words."""
        (i, j), (first, second) = self.records, self.times
        if self.is_whole:
            return f"{names[i]} and {names[j]} have the same samples"
        return (
            f"{names[i]} and {names[j]} have {int(self.samples[0].sum())} samples in common, from "
            f"{first[0]:.6g} to {first[1]:.6g} s of the first and from {second[0]:.6g} to "
            f"{second[1]:.6g} s of the second"
        )


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
    times, names = mean_times(records, found), record_labels(records)
    return Check(
        name=NAME,
        status="fail" if times > MAX_REPEATED_SAMPLES.value else "note",
        figure=times,
        threshold=MAX_REPEATED_SAMPLES.value,
        source="how often a sample is among the records, on average: variances are too small by as "
        "much",
        meaning=f"{'; '.join(each.told(names) for each in found)}; deviations are up to "
        f"{times**0.5:.3g} times too small: give each sample once",
    )


def mean_times(records: Sequence[Record], found: Sequence[Overlap]) -> float:
    """How often a sample is among the records, on average over all that are given."""
    counts = [np.ones(len(record)) for record in records]
    for each in found:
        for record, chosen in zip(each.records, each.samples, strict=True):
            counts[record] += chosen
    return float(np.mean(np.concatenate(counts)))


def _overlap(pair: tuple[int, int], one: Record, other: Record) -> Overlap | None:
    records, written = (one, other), [each.sampled or each for each in (one, other)]
    rows = _measured(*written)
    if rows is None:
        return None
    (values, places), (others, there) = map(_once, rows)
    _, i, j = np.intersect1d(values, others, assume_unique=True, return_indices=True)
    apart = there[j] - places[i]
    found = [np.zeros(len(each), dtype=bool) for each in rows]
    distances, counts = np.unique(apart, return_counts=True)
    for distance in distances[counts >= _MIN_COMMON_ROWS]:
        a, b = max(0, -distance), max(0, distance)
        n = min(len(rows[0]) - a, len(rows[1]) - b)
        off = np.abs(rows[0][a : a + n] - rows[1][b : b + n])
        same = np.all(off <= _MAX_WRITTEN_APART * np.abs(rows[0]).max(axis=0), axis=1)
        matched = places[i][apart == distance] - a
        # Rows that two runs of one motion have alike by chance have others between.
        if np.mean(same[matched.min() : matched.max() + 1]) >= MIN_COMMON_SAMPLES.value:
            found[0][a : a + n] |= same
            found[1][b : b + n] |= same
    first, second = (
        each if rows is record else np.interp(record.time, rows.time, each) == 1
        for record, rows, each in zip(records, written, found, strict=True)
    )
    if not (first.any() and second.any()):
        return None
    (a, b), (c, d) = one.time[first][[0, -1]], other.time[second][[0, -1]]
    times = (float(a), float(b)), (float(c), float(d))
    return Overlap(records=pair, samples=(first, second), times=times)


def _measured(*records: Record) -> list[NDArray[np.float32]] | None:
    """What both records measured of the motion and of the drive, by row; None without either.

    A reference is the same whenever it is run, and a position in few steps may be.
    """
    columns = [record.channels() for record in records]
    roles = [*records[0].motion, "control", "force"]
    both = [role for role in roles if all(role in each for each in columns)]
    if not {"control", "force"} & {*both} or len(both) < 2:
        return None
    with np.errstate(all="ignore"):
        rows = [np.column_stack([each[role] for role in both]) for each in columns]
        return [each.astype(np.float32) + np.float32(0) for each in rows]  # -0 is 0


def _once(rows: NDArray[np.float32]) -> tuple[NDArray[np.void], NDArray[np.intp]]:
    """Rows that occur once, as their bytes, and where."""
    values = np.ascontiguousarray(rows).view(f"V{rows[0].nbytes}")[:, 0]
    found, places, counts = np.unique(values, return_index=True, return_counts=True)
    return found[counts == 1], places[counts == 1]
