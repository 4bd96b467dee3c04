"""Search for samples that several records have in common: a record given twice, or an overlap.

Two files of one recorder may contain the same samples with different times: rows 1 to 10000 of a
log, and rows 5000 to 15000. Times are therefore ignored. Rows of measured columns that occur once
in a record are searched in the other record. An axis at rest repeats its rows, so rests of two
records are not counted as common samples. Numbers are compared as 32-bit floats. For resampled
records, the rows before resampling are compared where the record keeps them, as it does for columns
of one clock.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.findings import Finding
from axisid.estimation.records import Record, record_labels
from axisid.estimation.thresholds import MAX_REPEATED_SAMPLES, MIN_COMMON_SAMPLES
from axisid.estimation.verdict_checks import Check

_MIN_COMMON_ROWS = 25  # least number of rows that occur once in each of two records


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonSamples:
    """Samples that two records have in common.

    Attributes
    ----------
    names : (str, str)
        Names of the records.
    samples : int
        Number of common samples.
    spans : ((float, float), (float, float))
        Times of the first and the last common sample in each record, s.
    """

    names: tuple[str, str]
    samples: int
    spans: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatedSamples(Finding):
    """Samples that several records have in common.

    Attributes
    ----------
    pairs : tuple of CommonSamples
        Common samples of each pair of records that has any.
    repetitions : float
        Mean number of records that contain a sample; variances are too small by this factor.
    """

    pairs: tuple[CommonSamples, ...]
    repetitions: float


def common_samples(one: Record, other: Record) -> tuple[NDArray[np.bool_], ...] | None:
    """Return masks of the samples of each record that are in the other, (N,) and (M,).

    Rows that occur once in each of the two records are matched. The records overlap between the
    first and the last matched row only if, in one of them, nearly all rows of this range that occur
    once are matched. The common samples are then those of the range that also occur in the other
    record. None where there are no common samples.
    """
    # Rows as they were recorded, before any resampling.
    written = [each.sampled or each for each in (one, other)]
    rows = _measured(*written)
    if rows is None:
        return None
    # A number for each distinct row, and how often it occurs in each record.
    _, number = np.unique(np.concatenate(rows), return_inverse=True)
    numbers = np.split(number, [len(rows[0])])
    counts = [np.bincount(own, minlength=len(number)) for own in numbers]
    matched = (counts[0] == 1) & (counts[1] == 1)
    if matched.sum() < _MIN_COMMON_ROWS:
        return None
    # In each record: the share of matched rows in the range, and a mask of the common rows.
    shares, common = list[float](), list[NDArray[np.bool_]]()
    for own, count, others in zip(numbers, counts, counts[::-1], strict=True):
        first, last = np.flatnonzero(matched[own])[[0, -1]]
        # Rows that two runs of one motion share by chance have different rows between them.
        shares.append(matched.sum() / np.sum(count[own[first : last + 1]] == 1))
        common.append(others[own] > 0)
        if not np.array_equal(numbers[0], numbers[1]):  # equal rows include rests at the ends
            common[-1][:first] = common[-1][last + 1 :] = False
    if max(shares) < MIN_COMMON_SAMPLES.value:
        return None
    # A sample of a resampled record is common if it lies between common rows.
    return tuple(
        np.interp(record.time, own.time, rows) == 1
        for record, own, rows in zip((one, other), written, common, strict=True)
    )


def repeated_check(records: Sequence[Record]) -> Check | None:
    """Return the check for samples that several records have in common; None without any."""
    # For each sample, the number of records that contain it.
    counts, names = [np.ones(len(record)) for record in records], record_labels(records)
    pairs = list[CommonSamples]()
    for i, j in combinations(range(len(records)), 2):
        common = common_samples(records[i], records[j])
        if common is None:
            continue
        counts[i] += common[0]
        counts[j] += common[1]
        spans = [_time_span(records[k], each) for k, each in zip((i, j), common, strict=True)]
        pairs.append(
            CommonSamples(
                names=(names[i], names[j]),
                samples=int(common[0].sum()),
                spans=(spans[0], spans[1]),
            )
        )
    if not pairs:
        return None
    times = float(np.mean(np.concatenate(counts)))
    return Check(
        name="repeated records",
        status="fail" if times > MAX_REPEATED_SAMPLES.value else "note",
        figure=times,
        threshold=MAX_REPEATED_SAMPLES.value,
        source="mean number of records that contain a sample. Variances are too small by this "
        "factor. At the threshold, standard errors are 1 % too small",
        finding=RepeatedSamples(pairs=tuple(pairs), repetitions=times),
    )


def _time_span(record: Record, chosen: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the times of the first and the last sample of a mask, (N,), s."""
    first, last = record.time[chosen][[0, -1]]
    return float(first), float(last)


@np.errstate(all="ignore")
def _measured(*records: Record) -> list[NDArray[np.void]] | None:
    """Return the rows of the columns that both records measured, as bytes, (N,) for each record.

    The columns are those of motion, control and force. None unless these are at least two columns
    with a control or a force: a position with few steps alone may be the same in two runs. A
    reference is not compared, because it is the same in every run.
    """
    columns = [record.channels() for record in records]
    both = [
        role
        for role in (*records[0].motion, "control", "force")
        if all(role in each for each in columns)
    ]
    if not {"control", "force"} & {*both} or len(both) < 2:
        return None
    rows = [np.column_stack([each[role] for role in both]) for each in columns]
    single = [each.astype(np.float32, order="C") + np.float32(0) for each in rows]  # -0 is 0
    return [each.view(f"V{each.itemsize * len(both)}")[:, 0] for each in single]
