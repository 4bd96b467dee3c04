"""Machines whose true values scatter and drift, and their logs, which are read back as they are."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import Record, UsageError, build, load_axis, read_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Chain
from axisid.estimation.monte_carlo import monte_carlo, twin_of, twins
from axisid.fleets import gather_items
from axisid.modeling.declaration import Axis, Column, back_and_forth
from axisid.twins import TwinMachines, twin_files, write_twin, write_twins
from tests.refusals import refuses

SHORT = back_and_forth(speeds=(0.05, 0.1), acceleration=0.75, seconds=0.1)


@pytest.fixture(scope="module")
def short() -> GeneratedAxis:
    return twin_of(build(load_axis("emps2015")), {}, SHORT)


def is_same(one: Record, other: Record) -> bool:
    """Whether two records have the same columns to the last bit, wherever they are from."""
    columns = zip(one.channels().values(), other.channels().values(), strict=True)
    return all(np.array_equal(a, b) for a, b in columns)


def test_true_values_scatter_as_told_and_keep_their_sign(short: GeneratedAxis) -> None:
    machines = TwinMachines(axis=short, count=400, scatter={"M": 0.02, "Fc": 0.5})
    true = [machines.truth(machine, 0) for machine in range(400)]
    mass, friction = (np.log([each[name] for each in true]) for name in ("M", "Fc"))
    assert np.exp(mass.mean()) == pytest.approx(100.2, rel=0.004)
    assert (mass.std(), friction.std()) == pytest.approx((0.02, 0.5), rel=0.1)
    assert abs(np.corrcoef(mass, friction)[0, 1]) < 0.2
    assert {each["Fv"] for each in true} == {236.9}
    drifting = TwinMachines(axis=short, days=3, drift={"Fc": 0.1})
    found = [drifting.truth(0, day)["Fc"] for day in range(3)]
    assert found == pytest.approx([24.8, 27.28, 29.76])


def test_machines_and_days_that_are_added_change_none(short: GeneratedAxis) -> None:
    few = TwinMachines(axis=short, count=2, scatter={"M": 0.02})
    more = replace(few, count=5, days=4)
    for machine in range(2):
        assert few.truth(machine, 0) == more.truth(machine, 0)
        assert is_same(few.record(machine, 0), more.record(machine, 0))
    assert not is_same(more.record(1, 0), more.record(1, 1))


@pytest.mark.slow
def test_machines_that_are_alike_are_the_runs_of_a_study(short: GeneratedAxis) -> None:
    plan = monte_carlo(short, 2, ["idm-ls"], seed=7).plan
    machines = TwinMachines(axis=short, count=2, seed=7)
    for run, record in twins(plan, range(2)):
        assert is_same(record, machines.record(run, 0))


def test_a_manifest_tells_a_fleet_what_is_true(short: GeneratedAxis, tmp_path: Path) -> None:
    machines = TwinMachines(axis=short, count=2, days=2, scatter={"M": 0.02})
    manifest = write_twins(machines, tmp_path / "logs", axis="emps2015")
    written = {file.name for file in manifest.parent.iterdir()}
    assert written == {*twin_files(machines, ".csv")}
    items = gather_items(manifest, tmp_path / "out")
    assert [item.serial for item in items] == ["0001", "0001", "0002", "0002"]
    assert {item.axis for item in items} == {"emps2015"}
    assert items[3].conditions["date"] == "2026-01-02"
    assert items[3].conditions["true M [kg]"] == machines.truth(1, 1)["M"]
    assert is_same(read_record(items[3].log, short), machines.record(1, 1))


def test_nothing_is_left_where_a_twin_cannot_be_simulated(
    short: GeneratedAxis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machines, record = TwinMachines(axis=short, count=3), TwinMachines.record

    def failing(self: TwinMachines, machine: int, day: int) -> Any:
        if machine == 2:
            raise UsageError("it runs away")
        return record(self, machine, day)

    monkeypatch.setattr(TwinMachines, "record", failing)
    with pytest.raises(UsageError, match="runs away"):
        write_twins(machines, tmp_path)
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"count": 0}, "twin"),
        ({"seed": -1}, "twin"),
        ({"scatter": {"m": 0.1}}, "twin"),
        ({"scatter": {"M": 1e7}}, "twin"),
        ({"days": 2, "drift": {"Fc": -1.5}}, "twin"),
        ({"days": 2, "drift": {"Fc": "-1"}}, "twin"),
        ({"days": 5, "drift": {"Fc": -0.25}}, "twin"),
        ({"scatter": {"M": -0.1}}, "twin"),
        ({"noise": 3}, "noise"),
        ({"noise": Chain(anywhere=True)}, "study"),
    ],
)
def test_what_makes_no_sense_is_refused(
    short: GeneratedAxis, given: dict[str, Any], code: str
) -> None:
    with refuses(code):
        TwinMachines(axis=short, **given)
    with refuses("twin"):  # no share of a true value of 0
        TwinMachines(axis=twin_of(short, {"Fc": 0.0}, None), days=2, drift={"Fc": 0.1})


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


def test_a_column_by_its_number_and_another_ending_are_refused(tmp_path: Path) -> None:
    axis = named(load_axis("emps2015"), {"position": "#9"})
    for written, name in ((axis, "t.csv"), (build(load_axis("emps2015")), "t.mat")):
        with refuses("twin"):
            write_twin(TwinMachines(axis=written), tmp_path / name)
    assert not [*tmp_path.iterdir()]
