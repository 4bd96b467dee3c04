"""What a filter leaves open follows the record's rate, in Python as from the command line."""

from pathlib import Path

import numpy as np
import pytest

from axisid import Prefilter, Record, build, fit, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.commands.options.estimator_options import Filtering
from axisid.estimation import FilteredRecord
from tests.axes.servo import TRUTH, servo, servo_log, servo_record
from tests.refusals import refuses


@pytest.mark.parametrize(
    ("rate", "cutoff", "decimate"),
    [(100, 20.0, 10), (250, 50.0, 10), (300, 60.0, 10), (1000, 60.0, 10), (4000, 60.0, 27)],
)
def test_the_default_filter_serves_every_rate(rate: int, cutoff: float, decimate: int) -> None:
    found = Prefilter().at_rate_of(1 / rate)
    assert (found.cutoff, found.decimate) == (pytest.approx(cutoff), decimate)
    assert found == Prefilter.suited(1 / rate) == Filtering().prefilter(1 / rate)


@pytest.mark.parametrize("cutoff", [5.0, 10.0, 45.0, 180.0])
def test_a_cutoff_alone_chooses_the_decimation_that_the_command_line_does(
    emps2015: GeneratedAxis, twin: Record, cutoff: float
) -> None:
    by_command = Filtering(cutoff=cutoff).prefilter(twin.period)
    result = identify(emps2015, twin, Prefilter(cutoff=cutoff), ["idm-ls"])
    assert result.prefilter.decimate == by_command.decimate
    assert result.requested == by_command
    bound = FilteredRecord.bind(emps2015, twin, Prefilter(cutoff=cutoff))
    assert bound.prefilter == result.prefilter


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
    with refuses("too-few-rows", says=r"axisid fit.*fit\(axis, record\)"):
        identify(joint, record)
    fitted = fit(joint, record)
    for name, truth in TRUTH.items():
        if name != "o":
            assert fitted[name].value == pytest.approx(truth, rel=0.02)
