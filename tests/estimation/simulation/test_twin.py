"""Twins that cannot be."""

from dataclasses import replace

import pytest

from axisid import Axis, ModelError, build, load_axis, twin_record
from axisid.estimation.simulation import twin_plan


def loaded(counterbalance: float) -> Axis:
    """A vertical axis whose drive holds 22.6 kN, with a load of so much less."""
    axis = load_axis("vertical_screw")
    experiment = axis.experiment
    truth = {**experiment.truth, "Fb": counterbalance}
    return replace(axis, experiment=replace(experiment, truth=truth))


@pytest.mark.parametrize("counterbalance", [-25000.0, 25000.0])
def test_a_twin_whose_drive_cannot_hold_its_load_is_refused_with_numbers(
    counterbalance: float,
) -> None:
    with pytest.raises(ModelError, match="at its limit of 30 A it gives -2") as told:
        twin_record(build(loaded(counterbalance), native=False))
    assert told.value.code == "twin-not-held"
    assert f"Fb = {counterbalance:g} N" in str(told.value)


def test_a_load_that_friction_helps_to_hold_has_a_twin() -> None:
    holds = 22619.467 - 180.0 * 9.80665  # beside the weight, without friction
    twin_plan(build(loaded(-holds - 100.0), native=False))  # friction holds 160 N
    with pytest.raises(ModelError, match="cannot hold its load"):
        twin_plan(build(loaded(-holds - 200.0), native=False))
