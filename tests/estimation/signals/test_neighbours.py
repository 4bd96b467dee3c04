"""Rows that follow each other in time, and those that do not."""

from dataclasses import replace

import numpy as np
from hypothesis import given, strategies as st

from axisid import Prefilter, Record, identify, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.signals import FilteredRecord, Neighbours

places = st.sets(st.integers(0, 60), min_size=1).map(sorted)


def listed(order: Neighbours, lag: int) -> list[tuple[int, int]]:
    rows = np.arange(len(order))
    late, early = order.pairs(lag)
    return list(zip(rows[late].tolist(), rows[early].tolist(), strict=True))


@given(places, st.integers(0, 70))
def test_pairs_are_rows_a_lag_apart(numbers: list[int], lag: int) -> None:
    order = Neighbours(np.array(numbers))
    expected = [
        (i, j)
        for i, late in enumerate(numbers)
        for j, early in enumerate(numbers)
        if late - early == lag
    ]
    assert listed(order, lag) == expected


@given(st.lists(places, min_size=1, max_size=4))
def test_rows_of_two_pieces_are_never_a_lag_apart(pieces: list[list[int]]) -> None:
    joined = Neighbours.joined([Neighbours(np.array(piece)) for piece in pieces])
    owner = np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces])
    for lag in range(len(joined)):
        late, early = joined.pairs(lag)
        assert np.array_equal(owner[late], owner[early])
    own = sum(len(listed(Neighbours(np.array(piece)), 1)) for piece in pieces)
    assert len(listed(joined, 1)) == own


@given(places)
def test_stretches_hold_every_row_once(numbers: list[int]) -> None:
    order, values = Neighbours(np.array(numbers)), np.array(numbers, dtype=float)
    pieces = order.split(values)
    assert np.concatenate(pieces).tolist() == numbers
    assert [len(piece) for piece in pieces] == order.lengths.tolist()
    assert all(np.all(np.diff(piece) == 1) for piece in pieces)
    assert order.whole == (len(pieces) == 1)


def test_rows_left_out_of_a_record_part_their_neighbours(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    data = FilteredRecord.bind(emps2015, twin, Prefilter())
    steps = np.diff(data.row_numbers)
    assert np.array_equal(data.neighbours.breaks, np.flatnonzero(steps > 10) + 1)
    assert np.array_equal(np.diff(data.neighbours.places), steps / 10)
    kept = FilteredRecord.bind(emps2015, twin, Prefilter(reversals="keep"))
    assert kept.neighbours.whole


def test_rows_of_shifted_segments_are_still_a_row_period_apart(emps2015: GeneratedAxis) -> None:
    """Without a cut the last row of one segment may be a sample before the next one's first."""
    record = twin_record(emps2015, seed=1)
    segments = ((0, 2000), (2000, len(record)))
    prefilter = Prefilter(cutoff=60.0, decimate=4, drop=(0, 0), reversals="keep")
    result = identify(emps2015, replace(record, segments=segments), prefilter, methods="idm-ls")
    estimate = result["idm-ls"]
    step = result.prefilter.decimate * record.period
    assert np.diff(estimate.rows).min() * record.period < step
    assert estimate.row_period == step
