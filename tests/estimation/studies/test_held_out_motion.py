"""Half of a record predicts the position in the other half, but where noise biases it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, sweep
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.studies.recommendation import held_out_motion


@pytest.mark.slow
def test_a_half_predicts_the_other_as_well_as_its_parameters_are_right(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    axis = build(replace(emps2015.axis, control=None))
    found = sweep(
        axis, replace(twin, reference=None), (25.0, 40.0, 55.0, 120.0), methods=["idm-ls"]
    )
    results = [(each, each["idm-ls"]) for each in found.results]
    errors = held_out_motion(results)
    truth = np.array([*twin.provenance.truth.values()])
    off = [np.abs(estimate.physical / truth - 1).max() for _, estimate in results]
    assert np.argmax(errors) == np.argmax(off) == 3
    assert errors[3] > 10 * min(errors)
    assert "predicts the other's position to" in found.reason
    assert "of 4 cut-offs are left out" in found.reason


def test_nothing_is_told_of_a_position_that_was_not_measured(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    axis = build(replace(emps2015.axis, control=None))
    velocity = np.gradient(twin.position, twin.period)
    alone = Record(time=twin.time, velocity=velocity, control=twin.control)
    found = sweep(axis, alone, (25.0, 40.0, 60.0), methods=["idm-ls"])
    assert all(map(math.isnan, held_out_motion([(r, r["idm-ls"]) for r in found.results])))
    assert "predicts" not in found.reason
