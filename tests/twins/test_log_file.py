"""The log of a twin is read back as it is, by the axis's own names and units."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import build, load_axis, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Chain
from axisid.modeling.declaration import Axis, Column
from axisid.twins import TwinMachines, write_twin
from tests.refusals import refuses

COUNTS, GEAR = 4096, 50


def named(axis: Axis, columns: dict[str, object]) -> GeneratedAxis:
    return build(replace(axis, columns=columns))


def check_read_back(axis: GeneratedAxis, file: Path, within: float = 0.0) -> None:
    machines = TwinMachines(axis=axis)
    read = read_record(write_twin(machines, file), axis).channels()
    made = machines.record(0, 0).channels()
    assert read.keys() == made.keys()
    assert all(np.allclose(read[role], made[role], rtol=0, atol=within) for role in made)


@pytest.mark.parametrize("name", ["emps", "servo_joint", "linear_motor", "balanced_slide"])
def test_a_log_is_read_back_to_the_last_bit_without_options(name: str, tmp_path: Path) -> None:
    check_read_back(build(load_axis(name)), tmp_path / "twin.csv")


def test_counts_of_an_encoder_are_whole(tmp_path: Path) -> None:
    joint = load_axis("servo_joint")
    column = Column("inc", resolution=COUNTS, gear=GEAR)
    experiment = replace(joint.experiment, resolution=2 * math.pi / COUNTS / GEAR)  # type: ignore[type-var]
    axis = named(replace(joint, experiment=experiment), {"position": column})
    check_read_back(axis, tmp_path / "twin.csv", within=1e-12)
    _, head, *rows = (tmp_path / "twin.csv").read_text().splitlines()
    place = head.split(",").index("inc")
    assert all(float(row.split(",")[place]).is_integer() for row in rows)


def test_a_log_says_what_is_true_of_its_twin(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    first = write_twin(TwinMachines(axis=emps2015), tmp_path / "t.csv").read_text().split("\n")[0]
    assert first.startswith("# axisid.twin/1 twin 0001 of emps2015, seed 1;")
    assert "Fv = 236.9 N/(m/s)" in first


def test_sensors_are_columns_that_are_named(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    machines = TwinMachines(axis=emps2015, noise=Chain(velocity=1e-4))
    file = write_twin(machines, tmp_path / "t.csv")
    record = read_record(file, emps2015, columns={"velocity": "velocity"})
    assert np.array_equal(record.velocity, machines.record(0, 0).velocity)  # type: ignore[arg-type]


def test_a_column_by_its_number_is_refused(tmp_path: Path) -> None:
    axis = named(load_axis("emps2015"), {"position": "#9"})
    with refuses("twin"):
        write_twin(TwinMachines(axis=axis), tmp_path / "t.csv")
    assert not [*tmp_path.iterdir()]


def test_another_ending_is_refused(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    with refuses("twin"):
        write_twin(TwinMachines(axis=emps2015), tmp_path / "t.mat")
