"""A drive at rest is the commonest state of an axis: it is followed, never refused."""

import numpy as np
import pytest

from axisid import build, load_axis
from axisid.estimation import simulate_batch
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import LIBRARY

SECONDS = 5.0
DRAWS = 3


@pytest.mark.parametrize("name", LIBRARY)
def test_twin_that_rests_for_seconds_is_simulated_near_its_true_parameters(name: str) -> None:
    axis = build(load_axis(name))
    experiment, law = axis.axis.experiment, axis.axis.control
    moves = trajectory(experiment.moves, law.period)
    reference = np.concatenate([moves, np.full(round(SECONDS / law.period), moves[-1])])
    truth = np.array([experiment.truth.get(p.name, p.nominal) for p in axis.axis.parameters])
    rng = np.random.default_rng(LIBRARY.index(name))
    near = truth * (1 + 0.01 * rng.uniform(-1.0, 1.0, (DRAWS, len(truth))))
    rows = np.minimum(np.arange(len(reference)), len(moves) - 1)  # what is recorded rests too
    signals = axis.experiment_signals(law.period * rows)
    batch = simulate_batch(axis, near, reference, law.period, signals=signals)
    assert batch.failures == {}
    assert np.isfinite(batch["position"]).all()
    resting = batch["velocity"][-round(1.0 / law.period) :]
    assert np.abs(resting).max() < 1e-3 * np.abs(batch["velocity"]).max()
