"""Lanes of a record's loops are the loops that are simulated one by one."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, load_axis, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.predictions import LoopPredictions
from axisid.estimation.regression import InverseForm, simulated_loops
from axisid.support.arrays import Array
from tests.axes.lagging import THETA as LAGGING, lagging
from tests.refusals import refuses

THETA = np.array([100.2, 236.9, 24.8])
SETS = np.array([THETA, 1.1 * THETA])


def _predictions(axis: GeneratedAxis, output: str, *records: Record) -> LoopPredictions:
    return LoopPredictions(InverseForm(axis), [axis] * len(records), records, output)


def _alone(axis: GeneratedAxis, record: Record, theta: Array, signal: str) -> Array:
    loops = simulated_loops(axis, record, theta)
    return np.concatenate([getattr(loop, signal) for loop in loops])


@pytest.mark.parametrize("output", ["control", "position"])
def test_lanes_are_loops(emps2015: GeneratedAxis, twin: Record, output: str) -> None:
    found = _predictions(emps2015, output, twin)(SETS)
    for lane, theta in enumerate(SETS):
        own = _alone(emps2015, twin, theta, output) - getattr(twin, output)
        np.testing.assert_allclose(found.errors[:, lane], own, rtol=0, atol=1e-9)


def test_a_law_with_another_clock_is_sampled_as_the_log_is(emps2015: GeneratedAxis) -> None:
    twin = twin_record(emps2015, position_noise=0.0)
    columns = {name: values[::2] for name, values in twin.channels().items()}
    slow = Record(**columns, sample_period=2e-3)
    found = _predictions(emps2015, "control", slow)(SETS)
    for lane, theta in enumerate(SETS):
        own = _alone(emps2015, slow, theta, "control") - slow.control
        np.testing.assert_allclose(found.errors[:, lane], own, rtol=0, atol=1e-9)


def test_a_lane_that_fails_is_named_and_the_others_go_on(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    found = _predictions(emps2015, "control", twin)(np.array([THETA, [-1.0, 200.0, 20.0]]))
    assert [*found.failures] == [1]
    assert np.all(np.isfinite(found.errors[:, 0]))
    assert np.all(np.isnan(found.errors[:, 1]))


def test_an_output_that_was_not_recorded_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    with refuses("no-output", says="no force column"):
        _predictions(emps2015, "force", twin)


def test_slopes_by_the_law_are_those_of_another_law(twin: Record) -> None:
    declared = load_axis("emps2015")
    axis, law = build(declared), declared.control
    predictions = _predictions(axis, "position", twin)
    slopes = predictions.slopes_by_law(THETA)
    assert {*slopes} == {"kp*kv", "kv"}
    here = predictions(THETA[None, :]).errors[:, 0]
    more = replace(law, gains={**law.gains, "kp": 1.0001 * law.gains["kp"]})
    other = _predictions(build(replace(declared, control=more)), "position", twin)
    slope = (other(THETA[None, :]).errors[:, 0] - here) / 1e-4
    assert np.linalg.norm(slopes["kp*kv"] - slope) < 1e-3 * np.linalg.norm(slope)


@pytest.mark.parametrize("logged", ["command", "applied"])
def test_the_steps_of_a_drive_are_not_simulated(logged: str) -> None:
    """They are a staircase of the parameters, on which no search moves."""
    rounding = build(lagging(quantisation=0.05, logged=logged), native=False)
    plain = build(lagging(), native=False)
    record = twin_record(rounding).windowed((None, 0.3))
    found, smooth = (
        _predictions(axis, "control", record)(LAGGING[None, :]).errors for axis in (rounding, plain)
    )
    assert np.array_equal(found, smooth)
    assert np.any(found)
