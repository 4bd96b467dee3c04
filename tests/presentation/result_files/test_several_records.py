"""Results of several records: as text, as JSON, read again, on a page, on the command line."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from axisid import (
    Identification,
    UsageError,
    export,
    load_result,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.commands.main import cli
from tests.axes.stage import generated, stage, stage_record
from tests.files import csv_file
from tests.refusals import refuses
from tests.run_files import run_file
from tests.unjudged import identify

STAGE = """
from dataclasses import replace
from tests.axes.stage import stage
from tests.run_files import run_file
names = {"time": "t", "position": "q", "reference": "r", "control": "u"}
axis = replace(stage(), columns=names)
"""


@pytest.fixture(scope="module")
def loaded() -> Identification:
    records = [stage_record(1, tau0=3.0), stage_record(2, m_add=20.0, tau0=-5.0)]
    return identify(generated(), records, known={"m_add": [0.0, (20.0, 0.01)]}, local="tau0")


@pytest.fixture(scope="module")
def file(loaded: Identification, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return loaded.save(tmp_path_factory.mktemp("several") / "result.json", draws=20)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("logs")
    for i, payload in enumerate((0.0, 20.0)):
        made = stage_record(i + 1, m_add=payload)
        columns = {"t": made.time, "q": made.position, "r": made.reference, "u": made.control}
        csv_file(folder / f"run{i + 1}.csv", columns, "%.12g")
    (folder / "stage.py").write_text(STAGE)
    (folder / "bad.csv").write_text("t,q,r,u\n0,1,2,3\n")
    return [str(folder / name) for name in ("stage.py", "run1.csv", "run2.csv", "bad.csv")]


@pytest.mark.slow
def test_a_result_is_read_as_it_was_written(loaded: Identification, file: Path) -> None:
    saved = load_result(file, stage())
    assert saved.summary().splitlines() == loaded.summary().splitlines()
    assert {n: v.value for n, v in saved["idm-iv"].parameters.items()} == {
        n: v.value for n, v in loaded["idm-iv"].parameters.items()
    }
    assert saved.local_names == loaded.local_names
    assert saved.to_dict() == loaded.to_dict(draws=20)
    assert "run 1 and run 2" in repr(saved)


@pytest.mark.slow
def test_what_needs_one_set_of_the_axis_parameters_is_refused_and_a_part_serves(
    loaded: Identification, file: Path
) -> None:
    for result in (loaded, load_result(file, stage())):
        with refuses("export", r"tau0, m_add have a separate value"):
            export(result, "c")
        with refuses("validation", "like=1"):
            validate(result, stage_record(3))
    assert "M_plus_m_add" in export(loaded.parts[1], "csv")
    assert "M_plus_m_add" in load_result(file, stage()).part(2).summary(full=True)


@pytest.mark.slow
def test_one_of_several_records_is_exported_with_its_own_parameters(
    emps2015: GeneratedAxis, tmp_path: Path
) -> None:
    """A live result and its file give the same numbers; a record that is not there is refused."""
    records = [twin_record(emps2015, seed=seed) for seed in (1, 2)]
    live = identify(emps2015, records, methods=["idm-ls"], local="Fc")
    file = live.save(tmp_path / "own.json")
    saved = load_result(file)
    mass = live.preferred.parameters["M"].corrected
    assert [v and v.value for v in saved.local["Fc"]] == [v and v.value for v in live.local["Fc"]]
    assert [each.preferred["Fc"].value for each in saved.parts] == [
        each.preferred["Fc"].value for each in live.parts
    ]
    ratios = (each.parts[1].preferred.derive("M/Fc").value for each in (live, saved))
    assert next(ratios) == pytest.approx(next(ratios), rel=1e-12)
    for number, own in enumerate(live.local["Fc"], 1):
        assert own is not None
        from_file = export(saved, "python", record=number)
        for text in (export(live, "python", record=number), from_file):
            assert f"Fc = {own.corrected!r}  #" in text
            assert f"M = {mass!r}  #" in text
        line = ["export", str(file), "--axis", "emps2015", "--to", "python", "--record", number]
        done = CliRunner().invoke(cli, list(map(str, line)))
        assert (done.exit_code, done.output) == (0, from_file)
    for result in (live, saved):
        with refuses("export", says="Name a record: record=1"):
            export(result, "python")
        with refuses("result", says="no record 3. There are 2"):
            export(result, "python", record=3)


@pytest.mark.slow
def test_a_record_is_validated_as_one_that_it_is_like(loaded: Identification, file: Path) -> None:
    heavy = stage_record(5, m_add=20.0, tau0=-5.0)
    for result in (loaded, load_result(file, stage())):
        held, off = (validate(result, heavy, like=number) for number in (2, 1))
        assert held["idm-iv"].holds
        assert not off["idm-iv"].holds  # of another payload
        assert validate(result, loaded.records[1], like=2).same_record
        with refuses("result", says="There are 2"):
            validate(result, heavy, like=3)


def _run(*arguments: str) -> str:
    done = CliRunner().invoke(cli, arguments)
    return done.output if done.exit_code == 0 else f"failed: {done.output}{done.exception}"


@pytest.mark.slow
def test_the_command_line_takes_several_logs(logs: list[str], tmp_path: Path) -> None:
    out = tmp_path / "r.json"
    told = _run(
        "identify", *logs[:3], "--known", "m_add=0,20+-0.01", "--local", "tau0", "--json", str(out)
    )
    assert "drive_gain" in told
    assert "tau0_2" in told
    written = json.loads(out.read_text())
    assert [m["record"]["source"] for m in written["records"]] == ["run1.csv", "run2.csv"]
    assert written["records"][1]["known"]["m_add"] == {"value": 20.0, "sd": 0.01}
    assert written["declared_gain"] == 35.15


@pytest.mark.slow
def test_a_fit_and_its_file_say_what_is_known_of_each_record(
    logs: list[str], tmp_path: Path
) -> None:
    out = tmp_path / "r.json"
    told = _run(
        "fit", *logs[:3], "--known", "m_add=0,20+-0.01", "--bootstrap", "0", "--json", str(out)
    )
    assert "; m_add = 20 +- 0.01 kg" in told
    assert "; m_add = 20 +- 0.01" in load_result(out).summary()


@pytest.mark.parametrize(
    ("count", "options", "said"),
    [
        (3, ("--known", "m_add=0"), "has 1 known value,"),
        (3, ("--known", "m_add=0,x"), "value number 2"),
        (3, ("--local", "nothing"), "no parameter 'nothing'"),
        (3, ("--local", "M,M"), "'M' twice"),
        (3, ("--local", ","), "an empty name"),
        (3, ("--known", "m_add=0,1", "--fix", "M=1"), "--known M=1.0,1.0"),
        (2, ("--local", "tau0"), "only one record. Give several"),
    ],
)
def test_options_of_several_have_errors_with_their_place(
    logs: list[str], count: int, options: tuple[str, ...], said: str
) -> None:
    assert said in _run("identify", *logs[:count], *options)


@pytest.mark.slow
def test_columns_may_be_named_for_one_log(logs: list[str], tmp_path: Path) -> None:
    text = Path(logs[2]).read_text().replace("t,q,r,u", "zeit,lage,soll,strom")
    (tmp_path / "other.csv").write_text(text)
    columns = {"time": "zeit", "position": "lage", "reference": "soll", "control": "strom"}
    own = run_file(tmp_path / "other.csv", columns=columns)
    told = _run("identify", *logs[:2], str(own), "--method", "idm-ls")
    assert "columns 2  time = zeit" in told


@pytest.mark.slow
def test_sweep_and_compare_take_several_logs_without_the_bad_ones(logs: list[str]) -> None:
    axis, first, second, bad = logs
    options = ("--skip-bad", "--columns", "time=t,position=q,reference=r,control=u")
    known = ("--known", "m_add=0,1,20")
    swept = _run("sweep", axis, first, bad, second, "--points", "2", *known, *options)
    assert "drive_gain [N/V]" in swept
    assert "bad.csv" in swept
    compared = _run("compare", first, bad, first, "--ladder", "emps2015", *options)
    assert "record 2   run1.csv" in compared


@pytest.mark.slow
def test_candidates_are_compared_with_what_is_known_and_local(
    logs: list[str], tmp_path: Path
) -> None:
    axis, first, second, bad = logs
    out = tmp_path / "c.json"
    arguments = ["compare", first, bad, second, "--ladder", axis, "--skip-bad", "--json", str(out)]
    told = _run(*arguments, "--known", "m_add=0,7,20+-0.01", "--local", "tau0")
    assert not told.startswith("failed"), told
    for said in ("m_add = 20 +- 0.01 kg", "drive_gain", "tau0_2", "not used   1 record"):
        assert said in told
    written = json.loads(out.read_text())
    assert written["known"]["m_add"][1] == {"value": 20.0, "sd": 0.01}
    assert [*written["set_aside"]] == [bad]
    assert written["recommended"] == "Coulomb"
    refused = CliRunner().invoke(cli, [*arguments[:-2], "--local", "nothing"])
    assert isinstance(refused.exception, UsageError)
    assert "nothing" in str(refused.exception)


@pytest.mark.slow
def test_estimates_are_held_against_several_further_records(
    logs: list[str], tmp_path: Path
) -> None:
    axis, first, second, _ = logs
    out = tmp_path / "r.json"
    told = _run(
        "identify",
        axis,
        first,
        first,
        "--validate",
        second,
        "--validate",
        first,
        "--json",
        str(out),
    )
    assert told.count("Frozen estimates on") == 2
    written = json.loads(out.read_text())
    assert [v["record"]["source"] for v in written["validations"]] == ["run2.csv", "run1.csv"]
    assert "from this record (100 % of its samples)" in told
    assert "M_plus_m_add" in export(load_result(out, stage()), "c")
