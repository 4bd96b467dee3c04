"""A record as a file: it is read back as it is, by the axis's own names and units."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from axisid import Axis, ModelError, Record, UsageError, build, load_axis, read_record, twin_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from tests.refusals import refuses

ENDINGS = (".csv", ".parquet", ".npz")


@cache
def made(name: str) -> tuple[GeneratedAxis, Record]:
    axis = build(load_axis(name), native=False)
    return axis, twin_record(axis)


def is_same(read: Record, written: Record, within: float = 0.0) -> bool:
    mine, own = read.channels(), written.channels()
    return mine.keys() == own.keys() and all(
        np.allclose(mine[role], own[role], rtol=0.0, atol=within) for role in own
    )


@pytest.mark.slow
@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("name", ["emps", "valve"])  # with names of its own, a recorded signal
def test_a_record_is_read_back_to_the_last_bit(name: str, ending: str, tmp_path: Path) -> None:
    axis, record = made(name)
    read = read_record(record.write(tmp_path / f"log{ending}", axis), axis)
    assert is_same(read, record)
    assert read.digest == record.digest


@pytest.mark.parametrize("ending", ENDINGS)
def test_units_of_the_axis_are_those_of_the_file(
    ending: str, tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    axis = replace(emps2015.declared, columns={"position": "x [mm]", "time": "t [ms]"})
    record = twin_record(emps2015)
    file = record.write(tmp_path / f"log{ending}", axis)
    assert is_same(read_record(file, axis), record, within=1e-15)


def test_what_the_axis_does_not_name_is_named_as_it_is_read(
    tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    record = twin_record(emps2015, velocity_noise=1e-4)
    file = record.write(tmp_path / "log.npz", emps2015)
    assert is_same(read_record(file, emps2015, columns={"velocity": "velocity"}), record)


def test_a_csv_says_of_what_it_is_on_one_line(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015)
    odd = replace(record, provenance=replace(record.provenance, source="a\nb,c"))
    file = odd.write(tmp_path / "log.csv", emps2015)
    assert file.read_text().splitlines()[0] == "# axisid.record/1 a b,c"
    assert is_same(read_record(file, emps2015), record)


@pytest.mark.parametrize(
    ("name", "axis", "code"),
    [("log.mat", load_axis("emps2015"), "twin"), ("log.csv", None, "twin")],
)
def test_what_cannot_be_written_is_refused(
    name: str, axis: Axis | None, code: str, tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    with refuses(code):
        twin_record(emps2015).write(tmp_path / name, axis)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_what_names_no_file_is_refused(emps2015: GeneratedAxis) -> None:
    with refuses("twin", "file is 5"):
        made("emps2015")[1].write(5, emps2015)  # type: ignore[arg-type]


def test_a_place_that_cannot_be_written_to_is_told(tmp_path: Path, emps2015: GeneratedAxis) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"log\.csv cannot be written"):
        twin_record(emps2015).write(tmp_path / "file" / "log.csv", emps2015)


@pytest.mark.parametrize("told", ["no JSON", "[1, 2]", '{"position": 3}', "{}"])
def test_units_of_an_archive_that_cannot_be_read_are_refused_and_none_are_si(
    told: str, tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    record = twin_record(emps2015)
    file = tmp_path / "log.npz"
    np.savez(file, **record.channels(), **{"axisid.units": np.array(told)})  # type: ignore[arg-type]
    if told == "{}":
        assert is_same(read_record(file, emps2015), record)
    else:
        with refuses("log-file", r"units by name"):
            read_record(file, emps2015)


@pytest.mark.parametrize("heads", [("1", "2", "3", "4"), ("t", "ref", "a,b", "u")])
def test_heads_that_no_text_with_commas_can_have_are_refused(
    heads: tuple[str, ...], tmp_path: Path
) -> None:
    roles = ("time", "reference", "position", "control")
    axis = replace(load_axis("emps2015"), columns=dict(zip(roles, heads, strict=True)))
    record = twin_record(axis)
    with pytest.raises(ModelError, match=r"names in a header|cannot be written as comma"):
        record.write(tmp_path / "log.csv", axis)
    assert not [*tmp_path.iterdir()]
