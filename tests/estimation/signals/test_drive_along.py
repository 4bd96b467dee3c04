"""Rows of a drive whose force follows the motion, of a record that an integrator apart makes."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Axis, Prefilter, Record, build, twin_record
from axisid.elements import Drive
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord
from benchmarks.motor_joint import OHMS, TRUTH, Motor, integrated, joint, on_voltage

pytestmark = pytest.mark.slow

CASES = {
    "voltage": (Motor(), on_voltage()),
    "gear": (Motor(efficiency=0.7), on_voltage(efficiency=0.7)),
    "inductance": (Motor(lag=5e-4), on_voltage(inductance=5e-4 * OHMS)),
}


def least_squares(axis: Axis, record: Record) -> np.ndarray:
    """Parameters by the rows alone, over the truth."""
    data = FilteredRecord.bind(build(axis, native=False), record, Prefilter(cutoff=60.0))
    rows = InverseForm(data.axis).equations(data.signals).reduced(data)
    theta, *_ = np.linalg.lstsq(rows.regressor, rows.left - rows.intercept, rcond=None)
    return np.asarray(theta / np.array(list(TRUTH.values())))


@pytest.mark.parametrize("name", CASES)
def test_rows_pair_the_motion_with_the_force_that_it_leaves(name: str) -> None:
    motor, drive = CASES[name]
    axis = joint(drive)
    like = twin_record(build(axis, native=False))
    made = integrated(motor, np.asarray(like.reference), np.zeros(len(like)))
    record = replace(like, **made)
    np.testing.assert_allclose(least_squares(axis, record), 1.0, rtol=0, atol=5e-4)
    gain = replace(axis, drive=Drive(gain=drive.gain, limit=drive.limit))
    assert least_squares(gain, record)[2] > 5  # the braking is in the viscous friction
