"""The force of held commands: after a lag and a delay, and of a drive that follows the motion."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Axis, Prefilter, Record, build, twin_record
from axisid.elements import Drive
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.signals.drive_response import lagged_force
from benchmarks.motor_joint import OHMS, TRUTH, Motor, integrated, joint, on_voltage

PERIOD, FINE = 1e-3, 4000


def by_fine_steps(forces: np.ndarray, lag: float, delay: float) -> tuple[np.ndarray, np.ndarray]:
    """Force at the samples and its means, of a filter in small steps; at rest before."""
    step = PERIOD / FINE
    time = step * (np.arange(FINE * len(forces)) + 0.5) - delay
    command = forces[np.clip(np.floor(time / PERIOD).astype(int), 0, len(forces) - 1)]
    if not lag:
        force = command
    else:
        stays, force, now = np.exp(-step / lag), np.empty_like(command), forces[0]
        for i, target in enumerate(command):
            force[i] = target + (now - target) * (1 - stays) * lag / step  # its mean in a step
            now = target + (now - target) * stays
    by_sample = force.reshape(len(forces), FINE)
    return by_sample[:, 0], by_sample.mean(axis=1)


@pytest.mark.parametrize(
    ("lag", "delay"), [(1e-3, 0.0), (2e-4, 3.5e-4), (0.0, 2.25e-3), (5e-3, 1e-3)]
)
def test_mean_and_samples_are_those_of_small_steps(lag: float, delay: float) -> None:
    forces = np.random.default_rng(3).normal(size=20)
    response = Drive(gain=1.0, lag=lag, delay=delay).response(PERIOD)
    found = lagged_force(forces, response)
    at_samples, mean = by_fine_steps(forces, lag, delay)
    assert np.allclose(found.mean, mean, rtol=0, atol=1e-9)
    assert np.allclose(found.at_samples, at_samples, rtol=0, atol=1e-2)
    # What acts at a sample is recorded there: its end is not known yet at the last.
    recorded = np.concatenate([np.repeat(forces[:1], response.late), forces])[: len(forces)]
    applied = lagged_force(recorded, response, logged="applied")
    assert np.allclose(applied.mean[:-1], found.mean[:-1], rtol=0, atol=1e-12)


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
