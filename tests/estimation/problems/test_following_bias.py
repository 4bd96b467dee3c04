"""What is taken for the noise of a record that loops follow."""

import numpy as np
import pytest

from axisid import build, load_axis, read_record
from axisid.estimation.methods import bound_record
from axisid.estimation.problems.following_bias import _noises
from axisid.estimation.regression import quiet_loops
from axisid.estimation.signals import Prefilter
from axisid.support.arrays import Array
from benchmarks.machines import Machine, records, white


def _drawn(resolution: float, noise: float) -> tuple[list[Array], Array]:
    """Noises of the position as they are drawn, and that of the record beside its loops."""
    axis = build(load_axis("emps2015"))
    time = 1e-3 * np.arange(4000)
    reference = np.minimum(1.0, time / 0.5) * 0.02 * np.sin(2 * np.pi * time)
    stage = Machine(resolution=resolution, position_noise=white(noise))
    (columns,) = records(stage, reference, 1, 2)
    del columns["reference"]
    data = bound_record(axis, read_record(columns, axis), Prefilter.suited(1e-3))
    loops = quiet_loops(data, axis.nominal)
    found = [each["position"] for each in _noises(data, loops, np.random.default_rng(0))]
    return found, np.concatenate([loop.position for loop in loops])


@pytest.mark.slow
def test_a_quiet_sensor_follows_too() -> None:
    """Where it turns, the motion itself is more than such noise."""
    found, position = _drawn(0.0, 1e-8)
    assert 0 < np.std(found[0]) < 1e-7
    assert np.ptp(position) == pytest.approx(0.04, rel=0.1)


@pytest.mark.slow
def test_white_noise_comes_in_another_order_and_with_either_sign() -> None:
    found, _ = _drawn(0.0, 5e-6)
    assert len(found) == 8
    for one, other in zip(found[::2], found[1::2], strict=True):
        assert one == pytest.approx(-other)
    assert abs(np.corrcoef(found[0], found[2])[0, 1]) < 0.1
    assert np.std(found[0]) == pytest.approx(5e-6, rel=0.1)


@pytest.mark.slow
def test_that_of_an_encoder_is_what_its_steps_make_of_the_motion() -> None:
    step = 2e-5
    found, position = _drawn(step, 0.0)
    zeros = []
    for noise in found:
        assert np.abs(noise).max() <= step / 2 * (1 + 1e-9)
        measured = (position + noise) / step
        zeros.append(float((measured[0] - np.floor(measured[0])) % 1))
        assert measured - measured[0] == pytest.approx(np.round(measured - measured[0]), abs=1e-6)
    assert np.sort(np.diff(np.sort(zeros))) == pytest.approx(np.full(7, 1 / 8), abs=1e-6)
