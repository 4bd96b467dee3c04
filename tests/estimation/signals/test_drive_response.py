"""The force of held commands after a lag and a delay, against sums over fine steps."""

import numpy as np
import pytest

from axisid.estimation.signals.drive_response import acting_along
from axisid.modeling.declaration import Response

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
    response = Response.of(lag, delay, PERIOD)
    found = acting_along(forces, response)
    at_samples, mean = by_fine_steps(forces, lag, delay)
    assert np.allclose(found.mean, mean, rtol=0, atol=1e-9)
    assert np.allclose(found.at_samples, at_samples, rtol=0, atol=1e-2)
    # What acts at a sample is recorded there: its end is not known yet at the last.
    recorded = np.concatenate([np.repeat(forces[:1], response.late), forces])[: len(forces)]
    applied = acting_along(recorded, response, logged="applied")
    assert np.allclose(applied.mean[:-1], found.mean[:-1], rtol=0, atol=1e-12)
