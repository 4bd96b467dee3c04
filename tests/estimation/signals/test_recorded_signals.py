"""Recorded signals in the rows: as recorded, beside the force, products made before the filter."""

import numpy as np
import pytest

from axisid import Coordinate, Parameter, Prefilter, Record, Signal, build, newton, twin_record
from axisid.elements import Drive
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord, about_samples
from axisid.modeling.quantities import expression
from tests.axes.recorded import PERIOD_S, recorded_axis, recorded_values


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_signal_stands_in_the_rows_as_it_was_recorded(between: str) -> None:
    """A held one by the mean of what is held before and after, as the force is."""
    axis = build(recorded_axis("pressure", between))
    record = twin_record(axis, signals=recorded_values("pressure"))
    data = FilteredRecord.bind(axis, record, Prefilter())
    recorded = record.signals["pressure"]
    expected = about_samples(recorded, [0]) if between == "held" else recorded
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


def test_the_drive_reads_the_signal_of_the_sample() -> None:
    axis = build(recorded_axis("supply"))
    record = twin_record(axis, signals=recorded_values("supply"))
    data = FilteredRecord.bind(axis, record, Prefilter())
    made = 35.0 * record.control * record.signals["supply"] / 24
    assert data.force == pytest.approx(made, rel=1e-12)
    assert data.signals.force == pytest.approx(about_samples(made, [0]), rel=1e-12)
