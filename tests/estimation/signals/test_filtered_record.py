"""A record under a filter: settings that make sense, what is left open, filtered once.

Rows that follow each other in time, in records with gaps and masked rows.
"""

from dataclasses import replace
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid import (
    Coordinate,
    Parameter,
    Prefilter,
    Record,
    Signal,
    UsageError,
    build,
    newton,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.commands.options.estimation_options import Filtering
from axisid.elements import Drive
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord, RowTimes, SampledFilter, hold_mean
from axisid.modeling.quantities import expression
from tests.axes.recorded import PERIOD_S, recorded_axis, recorded_values
from tests.refusals import refuses
from tests.unjudged import identify

SIGNALS = ("position", "velocity", "acceleration", "force", "direction")


@pytest.fixture(scope="module")
def record(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015.axis)


@pytest.mark.parametrize("reversals", ["keep", "leave-out", None])
@pytest.mark.parametrize("hold", ["raw", "zoh", None])
def test_signals_are_those_of_the_filter_itself(
    emps2015: GeneratedAxis, record: Record, reversals: str, hold: str
) -> None:
    data = FilteredRecord.bind(emps2015, record, Prefilter(reversals=reversals, hold=hold))  # type: ignore[arg-type]
    force = emps2015.axis.drive.gain * record.control
    motion = data.sampling.filter.motion(record.position)
    if data.prefilter.hold == "zoh":
        force = hold_mean(force, [0])
    wanted = (*motion, force, np.sign(motion[1]))
    for name, values in zip(SIGNALS, wanted, strict=True):
        np.testing.assert_array_equal(getattr(data.signals, name), values)
    np.testing.assert_array_equal(
        data.reduce(data.signals.velocity), data.sampling.reduce(motion[1])
    )
    assert (
        len(data.sampling.rows)
        == len(data.sampling.weights)
        == len(data.reduce(data.signals.force))
    )


@pytest.mark.parametrize(
    "settings",
    [
        {"cutoff": 0.0},
        {"cutoff": float("nan")},
        {"order": 0},
        {"order": 99},
        {"decimate": 0},
        {"decimation": "octave"},
        {"hold": "foh"},
        {"drop": (-1, 0)},
    ],
)
def test_senseless_settings_are_refused(settings: dict[str, object]) -> None:
    with pytest.raises(UsageError, match=r"(?i)give|choose from"):
        Prefilter(**settings)  # type: ignore[arg-type]


def test_prefilter_for_another_period_has_the_same_edges() -> None:
    f = Prefilter(cutoff=30.0, decimate=10, drop=(50, 20))
    assert f.at_period(1e-3, 1.001e-3) is f
    faster = f.at_period(1e-3, 5e-4)
    assert (faster.cutoff, faster.decimate, faster.drop) == (30.0, 20, (100, 40))
    assert Prefilter(decimate=3).at_period(1e-3, 1e-2).decimate == 1


@pytest.mark.parametrize(
    ("rate", "cutoff", "decimate"),
    [(100, 20.0, 10), (250, 50.0, 10), (300, 60.0, 10), (1000, 60.0, 10), (4000, 60.0, 27)],
)
def test_the_default_filter_serves_every_rate(rate: int, cutoff: float, decimate: int) -> None:
    found = Prefilter().at_rate_of(1 / rate)
    assert (found.cutoff, found.decimate) == (pytest.approx(cutoff), decimate)
    assert found == Prefilter.suited(1 / rate) == Filtering().prefilter(1 / rate)


@pytest.mark.parametrize("factor", [1e-3, 1e3, 60.0])
def test_time_in_another_unit_is_asked_about_where_no_filter_serves(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    record = replace(twin, time=factor * twin.time, sample_period=None)
    with refuses(
        "too-short" if factor < 1 else "filter", says="[Cc]heck that the time is in seconds"
    ):
        identify(emps2015, record, Prefilter(cutoff=60.0))


def test_filter_that_does_not_suit_the_record_is_the_only_complaint_otherwise(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    for record in (twin, replace(twin, time=7 * twin.time, sample_period=None)):
        with refuses("filter", says=r"^the cutoff 900 Hz is not below"):
            identify(emps2015, record, Prefilter(cutoff=900.0))


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_signal_stands_in_the_rows_as_it_was_recorded(between: str) -> None:
    """A held one by the mean of what is held before and after, as the force is."""
    axis = build(recorded_axis("pressure", between))
    record = twin_record(axis, signals=recorded_values("pressure"))
    data = FilteredRecord.bind(axis, record, Prefilter())
    recorded = record.signals["pressure"]
    expected = hold_mean(recorded, [0]) if between == "held" else recorded
    (found,) = data.signals.recorded
    assert np.array_equal(found, expected)
    rows = InverseForm(axis).equations(data.signals).reduced(data).regressor
    column = [p.name for p in axis.parameters].index("A")
    assert rows[:, column] == pytest.approx(data.reduce(expected), rel=1e-12)


def test_a_product_with_the_motion_is_made_before_the_decimation_filter() -> None:
    q, push = Coordinate("q"), Signal("push", "N")
    mass, arm = Parameter("M", "kg", nominal=1.0), Parameter("a", "1/m^2")
    axis = build(
        newton(
            "product",
            coordinate=q,
            parameters=(mass, arm),
            signals=(push,),
            inertia=mass,
            resistance=(arm * push * expression(q, "q") ** 2,),
            drive=Drive(gain=1.0),
        )
    )
    time = PERIOD_S * np.arange(3000)
    position, values = np.sin(5 * time), 3.0 + np.sign(np.sin(11 * time))
    record = Record(time=time, position=position, control=np.cos(time), signals={"push": values})
    data = FilteredRecord.bind(axis, record, Prefilter(cutoff=60, decimate=10))
    rows = InverseForm(axis).equations(data.signals).reduced(data).regressor
    assert rows[:, 1] == pytest.approx(data.reduce(values * data.motion[0] ** 2), rel=1e-12)


@pytest.mark.slow
def test_the_drive_reads_the_signal_of_the_sample() -> None:
    axis = build(recorded_axis("supply"))
    record = twin_record(axis, signals=recorded_values("supply"))
    data = FilteredRecord.bind(axis, record, Prefilter())
    made = 35.0 * record.control * record.signals["supply"] / 24
    assert data.force == pytest.approx(made, rel=1e-12)
    assert data.signals.force == pytest.approx(hold_mean(made, [0]), rel=1e-12)


FILTER = Prefilter(cutoff=60.0, decimate=5)
CUTS = ((0, 2500), (2700, 2740), (2900, 7000))  # the middle one is too short to filter


def cut(record: Record, start: int, stop: int) -> Record:
    columns = {role: values[start:stop] for role, values in record.channels().items()}
    return replace(record, **columns)  # type: ignore[arg-type]


def test_rows_are_those_of_the_segments_one_by_one(emps2015: GeneratedAxis, twin: Record) -> None:
    pieces = [cut(twin, start, stop) for start, stop in CUTS]
    columns = {
        role: np.concatenate([piece.channels()[role] for piece in pieces])
        for role in twin.channels()
    }
    spans = tuple(pairwise(accumulate(map(len, pieces), initial=0)))
    gapped = replace(twin, **columns, segments=spans)  # type: ignore[arg-type]
    *alone, together = (
        identify(emps2015, record, FILTER, ["idm-ls"])["idm-ls"]
        for record in (pieces[0], pieces[2], gapped)
    )
    y = np.concatenate([e.y for e in alone])
    X = np.concatenate([e.X for e in alone])
    assert np.array_equal(together.y, y)
    assert np.array_equal(together.X, X)
    expected = np.linalg.lstsq(X, y, rcond=None)[0]
    assert together.physical == pytest.approx(expected, rel=1e-9)
    offset = len(pieces[0]) + len(pieces[1])
    rows = np.concatenate([alone[0].rows, alone[1].rows + offset])
    assert np.array_equal(together.rows, rows)


@pytest.mark.parametrize(
    ("samples", "changes", "code", "says"),
    [
        (50, {"segments": ((0, 10), (11, 50))}, "record", ""),
        (50, {"segments": ((0, 49),)}, "record", ""),
        (50, {"segments": ((5, 50),)}, "record", ""),
        (50, {"segments": ((0, 60),)}, "record", ""),
        (
            50,
            {"segments": ((0, 48), (48, 50))},
            "too-short",
            "from 0.048 to 0.049 s has 2 rows",
        ),
        (50, {"segments": ((0, 25), (25, 50))}, "too-short", "record's longest segment has 25"),
        (7801, {"masked": ((0, 7801),)}, "too-short", "0 rows are too few"),
    ],
)
def test_segments_that_are_no_parts_of_the_record_and_too_few_rows_are_refused(
    emps2015: GeneratedAxis,
    twin: Record,
    samples: int,
    changes: dict[str, Any],
    code: str,
    says: str,
) -> None:
    with refuses(code, says=says):
        identify(emps2015, replace(cut(twin, 0, samples), **changes), FILTER)


def test_masked_samples_reach_no_row(emps2015: GeneratedAxis, twin: Record) -> None:
    """What stands in masked samples does not matter, to what the filters' memory leaves."""
    spoilt = np.array(twin.control)
    spoilt[3000:3020] = 10.0  # beyond what the motion needs, as a clipped sensor's
    masked = ((3000, 3020),)
    got, clean, spoilt_fit, whole = (
        identify(emps2015, replace(twin, **changes), FILTER, ["idm-ls"])["idm-ls"]
        for changes in (
            {"control": spoilt, "masked": masked},
            {"masked": masked},
            {"control": spoilt},
            {},
        )
    )
    off = np.abs(got.physical - clean.physical) / np.abs(clean.physical)
    without = np.abs(spoilt_fit.physical - whole.physical) / np.abs(whole.physical)
    assert np.all(off < 1e-4)
    assert np.all(without > 20 * off)
    reach = SampledFilter(FILTER, 1e-3).memory * FILTER.decimate
    inside = (whole.rows >= 3000 - reach) & (whole.rows < 3020 + reach)
    assert np.array_equal(np.setdiff1d(whole.rows, got.rows), whole.rows[inside])


places = st.sets(st.integers(0, 60), min_size=1).map(sorted)


def listed(order: RowTimes, lag: int) -> list[tuple[int, int]]:
    rows = np.arange(len(order))
    late, early = order.pairs(lag)
    return list(zip(rows[late].tolist(), rows[early].tolist(), strict=True))


@given(places, st.integers(0, 70))
def test_pairs_are_rows_a_lag_apart(numbers: list[int], lag: int) -> None:
    order = RowTimes(np.array(numbers))
    expected = [
        (i, j)
        for i, late in enumerate(numbers)
        for j, early in enumerate(numbers)
        if late - early == lag
    ]
    assert listed(order, lag) == expected


@given(st.lists(places, min_size=1, max_size=4))
def test_rows_of_two_pieces_are_never_a_lag_apart(pieces: list[list[int]]) -> None:
    joined = RowTimes.joined([RowTimes(np.array(piece)) for piece in pieces])
    owner = np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces])
    for lag in range(len(joined)):
        late, early = joined.pairs(lag)
        assert np.array_equal(owner[late], owner[early])
    own = sum(len(listed(RowTimes(np.array(piece)), 1)) for piece in pieces)
    assert len(listed(joined, 1)) == own


@given(places)
def test_stretches_hold_every_row_once(numbers: list[int]) -> None:
    order, values = RowTimes(np.array(numbers)), np.array(numbers, dtype=float)
    pieces = order.split(values)
    assert np.concatenate(pieces).tolist() == numbers
    assert [len(piece) for piece in pieces] == order.lengths.tolist()
    assert all(np.all(np.diff(piece) == 1) for piece in pieces)
    assert order.whole == (len(pieces) == 1)


def test_rows_left_out_of_a_record_part_their_neighbours(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    data = FilteredRecord.bind(emps2015, twin, Prefilter())
    steps = np.diff(data.sampling.rows)
    assert np.array_equal(data.sampling.neighbours.breaks, np.flatnonzero(steps > 10) + 1)
    assert np.array_equal(np.diff(data.sampling.neighbours.places), steps / 10)
    kept = FilteredRecord.bind(emps2015, twin, Prefilter(reversals="keep"))
    assert kept.sampling.neighbours.whole


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
