"""A record under a filter: bound once, filtered once, the same as filtering it anew."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import DataError, Prefilter, UsageError, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord, about_samples
from tests.refusals import refuses

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
        force = about_samples(force, [0])
    wanted = (*motion, force, np.sign(motion[1]))
    for name, values in zip(SIGNALS, wanted, strict=True):
        np.testing.assert_array_equal(getattr(data.signals, name), values)
    np.testing.assert_array_equal(
        data.reduce(data.signals.velocity), data.sampling.reduce(motion[1])
    )
    assert len(data.row_numbers) == len(data.weights) == len(data.reduce(data.signals.force))


def test_what_is_bound_stays_as_it_is_when_it_is_bound_again(
    emps2015: GeneratedAxis, record: Record
) -> None:
    data = FilteredRecord.bind(emps2015, record, Prefilter())
    assert data.prefilter.hold == "zoh"
    assert data.prefilter.reversals == "leave-out"
    assert data.excluded == data.sampling.turns(data.motion[1])
    assert FilteredRecord.bind(emps2015, record, data.prefilter).prefilter == data.prefilter


def test_a_filter_that_cannot_serve_the_record_is_refused_when_it_is_bound(
    emps2015: GeneratedAxis, record: Record
) -> None:
    with refuses("prefilter-type"):
        FilteredRecord.bind(emps2015, record, 60.0)  # type: ignore[arg-type]
    with pytest.raises((UsageError, DataError)):
        FilteredRecord.bind(emps2015, record, Prefilter(cutoff=1e6))


def test_another_prefilter_of_the_same_motion_starts_without_what_was_computed(
    emps2015: GeneratedAxis, record: Record
) -> None:
    data = FilteredRecord.bind(emps2015, record, Prefilter())
    rows = len(data.row_numbers)
    coarser = replace(data, prefilter=replace(data.prefilter, decimate=50))
    assert len(coarser.row_numbers) < rows / 4
