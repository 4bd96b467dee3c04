"""A recorded test signal: where it enters, its unit, and that it is treated as other columns."""

from dataclasses import replace

import numpy as np

from axisid import Record, load_axis, read_record
from axisid.estimation import Repairs
from tests.refusals import refuses

TIME = 1e-3 * np.arange(400)
LOG = {
    "time": TIME,
    "position": np.sin(8 * TIME),
    "reference": np.sin(8 * TIME),
    "control": np.cos(8 * TIME),
    "exc": 0.1 * np.sin(60 * TIME),
}
NAMED = {"injected": "exc"}


def test_it_is_added_to_what_is_said() -> None:
    at_control = read_record(LOG, columns=NAMED, injected_at="control")
    assert at_control.injected_at == "control"
    np.testing.assert_array_equal(at_control.added_control, LOG["exc"])
    np.testing.assert_array_equal(at_control.commanded, LOG["reference"])
    at_reference = read_record(LOG, columns=NAMED, injected_at="reference")
    assert at_reference.added_control is None
    np.testing.assert_array_equal(at_reference.commanded, LOG["reference"] + LOG["exc"])
    assert "'exc' was added to the reference" in at_reference.provenance.assumed


def test_its_unit_is_that_of_what_it_is_added_to() -> None:
    axis = load_axis("emps2015")
    at_reference = read_record(LOG, axis, columns={"injected": "exc:mm"}, injected_at="reference")
    np.testing.assert_allclose(at_reference.injected, 1e-3 * LOG["exc"])
    at_control = read_record(LOG, axis, columns={"injected": "exc:mV"}, injected_at="control")
    np.testing.assert_allclose(at_control.injected, 1e-3 * LOG["exc"])
    with refuses("units", says="injected of axis 'emps2015' is measured in V"):
        read_record(LOG, axis, columns={"injected": "exc:mm"}, injected_at="control")


def test_a_place_without_a_column_and_a_column_without_a_place_are_refused() -> None:
    with refuses("test-signal", says='add injected_at = "control" or'):
        read_record(LOG, columns=NAMED)
    with refuses("test-signal"):
        read_record(LOG, injected_at="control")
    with refuses("test-signal", says='added to .force.; give injected_at = "control"'):
        read_record(LOG, columns=NAMED, injected_at="force")
    with refuses("test-signal", says="None"):
        Record(time=TIME, position=LOG["position"], injected=LOG["exc"])


def test_a_column_that_only_bears_the_roles_name_is_left_out_and_told() -> None:
    log = {**LOG, "injected": LOG["exc"]}
    record = read_record(log)
    assert record.injected is None
    assert "'injected' is left out" in str(record.provenance.assumed)
    assert read_record(log, injected_at="control").injected is not None


def test_the_axis_may_say_both_and_its_log_may_lack_the_column() -> None:
    declared = {"injected": "exc", "position": "position"}
    axis = replace(load_axis("emps2015"), columns=declared, injected_at="control")
    assert read_record(LOG, axis).injected_at == "control"
    assert read_record(LOG, axis, injected_at="reference").injected_at == "reference"
    without = read_record({name: v for name, v in LOG.items() if name != "exc"}, axis)
    assert without.injected is None
    assert "no test signal is reckoned with" in str(without.provenance.assumed)
    with refuses("test-signal", says="'force'"):
        replace(axis, injected_at="force")


def test_a_reference_at_rest_is_no_fault_where_a_test_signal_moves_the_axis() -> None:
    still = {**LOG, "reference": np.zeros(400)}
    with refuses("not-shown", says="reference is 0"):
        read_record(still)
    assert read_record(still, columns=NAMED, injected_at="control").injected is not None


def test_it_is_resampled_as_what_it_is_added_to() -> None:
    fine = Repairs(resample=2000.0)
    lines = read_record(LOG, repairs=fine, columns=NAMED, injected_at="control")
    np.testing.assert_allclose(lines.injected, np.interp(lines.time, TIME, LOG["exc"]))
    smooth = read_record(LOG, repairs=fine, columns=NAMED, injected_at="reference")
    np.testing.assert_allclose(smooth.injected, 0.1 * np.sin(60 * smooth.time), atol=1e-6)
