"""A record under a filter: settings that make sense, what is left open, filtered once."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Parameter,
    Prefilter,
    Record,
    Signal,
    UsageError,
    build,
    identify,
    newton,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.commands.options.estimator_options import Filtering
from axisid.elements import Drive
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord, about_samples
from axisid.modeling.quantities import expression
from tests.axes.recorded import PERIOD_S, recorded_axis, recorded_values
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
    with pytest.raises(UsageError, match=r"give|choose from"):
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
def test_time_in_another_unit_is_asked_about_before_the_filter(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    record = replace(twin, time=factor * twin.time, sample_period=None)
    told = f"every {1e-3 * factor:.4g} s, .* runs every 0.001 s"
    with refuses("units", says=f"{told}: is time's unit right.*As it stands, the"):
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
