"""A record under a filter: settings that make sense, what is left open, filtered once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import Prefilter, Record, UsageError, build, fit, identify, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.commands.options.estimator_options import Filtering
from axisid.estimation import FilteredRecord
from axisid.estimation.signals import about_samples
from tests.axes.servo import TRUTH, servo, servo_log, servo_record
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


def test_a_log_of_100_hertz_is_identified_unasked(emps2015: GeneratedAxis, twin: Record) -> None:
    rows = slice(0, None, 10)
    columns = {role: values[rows] for role, values in twin.channels().items()}
    slow = Record(**columns, sample_period=0.01)  # type: ignore[arg-type]
    result = identify(emps2015, slow)
    assert result.prefilter.cutoff == pytest.approx(20.0)
    assert result["idm-ls"].parameters["M"].value == pytest.approx(100.0, rel=0.03)


@pytest.mark.slow
def test_log_of_which_the_filter_leaves_too_few_rows_is_led_to_the_fit_that_takes_all(
    tmp_path: Path,
) -> None:
    joint = build(servo())
    log = servo_log(joint, tmp_path / "a.json", lambda t: 0.5 * np.sin(6 * np.pi * t), 0.3)
    record = servo_record(joint, log)
    with refuses("too-short", says=r"axisid fit.*fit\(axis, record\)"):
        identify(joint, record)
    fitted = fit(joint, record)
    for name, truth in TRUTH.items():
        if name != "o":
            assert fitted[name].value == pytest.approx(truth, rel=0.02)


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
