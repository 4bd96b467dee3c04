"""Twins of experiments: their trajectories, their noise, and twins that cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Axis, build, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.simulation import twin_plan
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move, back_and_forth
from tests.axes.bodies import body
from tests.refusals import refuses

PERIOD = 1e-3


def test_an_axis_without_an_experiment_has_no_twin() -> None:
    with refuses("twin", says="experiment"):
        twin_record(body())


def test_a_trajectory_rests_as_long_as_each_move_dwells() -> None:
    there = Move(0.05, 0.1, 1.0)
    q = trajectory(back_and_forth(speeds=(0.1,), acceleration=1.0, seconds=0.5, dwell=0.25), PERIOD)
    moving, resting = round(there.duration / PERIOD), round(0.25 / PERIOD)
    np.testing.assert_allclose(q[: moving + 1], trajectory((there,), PERIOD), atol=1e-15)
    np.testing.assert_allclose(q[moving : moving + resting + 1], 0.05, atol=1e-15)
    assert q[moving + resting + 2] < 0.05
    assert len(q) == 2 * (moving + resting) + 1


def test_trajectory_keeps_its_speed_and_acceleration() -> None:
    moves = (Move(0.1, 0.2, 2.0), Move(-0.001, 0.2, 2.0), Move(0.0, 1.0, 1.0), Move(0.3, 0.5, 1.0))
    q = trajectory(moves, PERIOD)
    assert q[0] == 0
    assert q[-1] == pytest.approx(0.399, abs=1e-6)
    assert np.abs(np.diff(q)).max() / PERIOD == pytest.approx(0.5, rel=1e-6)
    assert np.abs(np.diff(q, 2)).max() / PERIOD**2 <= 2.0 + 1e-6


def test_twin_is_reproducible_and_its_seed_matters(emps2015: GeneratedAxis) -> None:
    first, again = twin_record(emps2015), twin_record(emps2015)
    assert np.array_equal(first.position, again.position)
    assert not np.array_equal(first.position, twin_record(emps2015, seed=7).position)
    quiet = twin_record(emps2015, position_noise=0.0)
    assert np.std(first.position - quiet.position) == pytest.approx(3.8e-6, rel=0.3)


def loaded(counterbalance: float) -> Axis:
    """A vertical axis whose drive holds 22.6 kN, with a load of so much less."""
    axis = load_axis("vertical_screw")
    experiment = axis.experiment
    truth = {**experiment.truth, "Fb": counterbalance}
    return replace(axis, experiment=replace(experiment, truth=truth))


def test_a_twin_whose_drive_cannot_hold_its_load_is_refused_with_numbers() -> None:
    holds = 22619.467 - 180.0 * 9.80665  # beside the weight, without friction, which holds 160 N
    twin_plan(build(loaded(-holds - 100.0), native=False))
    for beyond in (-holds - 200.0, 25000.0):
        with refuses("twin", says=rf"at its limit of 30 A it gives -2.* Fb = {beyond:g} N"):
            twin_plan(build(loaded(beyond), native=False))
