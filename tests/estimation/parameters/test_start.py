"""Where loops start, found with the parameters of the model."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, fit, simulate, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.studies import validate_fit
from axisid.support.arrays import Array
from tests.estimation.fitting.fits import TRUTH, off

BEGIN = 300  # where the axis is moving


def _moving(axis: GeneratedAxis, seed: int, noise: float = 3.8e-6) -> tuple[Record, Array]:
    """A record that begins in motion, with the position and the velocity there."""
    whole = twin_record(axis)
    white = noise * np.random.default_rng(seed).standard_normal(len(whole))
    loop = simulate(axis, [*TRUTH.values()], whole.reference, whole.period, position_noise=white)
    rows = slice(BEGIN, None)
    record = Record(
        time=whole.time[rows],
        position=loop.measured_position[rows],
        reference=whole.reference[rows],
        control=loop.control[rows],
    )
    return record, np.array([loop.position[BEGIN], loop.velocity[BEGIN]])


def test_a_start_in_motion_is_found_with_the_parameters(emps2015: GeneratedAxis) -> None:
    record, begun = _moving(emps2015, 1)
    found = fit(emps2015, record, free="start")
    assert found.names == (*TRUTH, "start_position", "start_velocity")
    assert [found[name].unit for name in found.names[3:]] == ["m", "m/s"]
    truth = {**TRUTH, "start_position": begun[0], "start_velocity": begun[1]}
    assert np.abs(off(found, truth)).max() < 3
    assert found["start_position"].deviation < 3.8e-6
    assert abs(begun[1]) > 50 * found["start_velocity"].deviation
    assert found.believed
    assert "start_velocity" in found.summary()
    # It is a little less than what the start of the record leaves.
    assert found.error < fit(emps2015, record).error


def test_each_record_has_a_start_of_its_own(emps2015: GeneratedAxis, twin: Record) -> None:
    record, begun = _moving(emps2015, 2)
    bounds = {"start_position": (0, 1)}
    found = fit(emps2015, [twin, record], free="start", bounds=bounds)
    names = [f"start_{what}_{i}" for i in (1, 2) for what in ("position", "velocity")]
    assert [*found.names[3:]] == names
    assert found.local["start_velocity"] == ("start_velocity_1", "start_velocity_2")
    assert found.bounds["start_position_2"] == (0.0, 1.0)
    assert abs(found["start_position_2"].value - begun[0]) < 4e-6
    assert abs(found["start_velocity_2"].value - begun[1]) < 3 * found["start_velocity_2"].deviation
    cut = replace(twin, segments=((0, 3000), (3000, len(twin))))
    pieces = fit(emps2015, cut, free="start", fixed={"start_velocity_1": 0.0})
    assert [*pieces.names[3:]] == names
    assert pieces.fixed == {"start_velocity_1": 0.0}
    # A record that is held against it starts where it is.
    assert validate_fit(found, record).percent == pytest.approx(
        found.of_records[1].percent, rel=0.02
    )
