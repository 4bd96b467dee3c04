"""A record under a filter: bound once, filtered once, the same as filtering it anew."""

import numpy as np
import pytest

from axisid import Prefilter, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord, about_samples

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
