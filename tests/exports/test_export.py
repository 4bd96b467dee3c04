"""Exports: the same from a result as from its file, loadable, refused where they would be wrong."""

import csv
import io
import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from axisid import (
    Identification,
    Record,
    export,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.commands.new import scaffold
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.estimates.estimated_values import Value
from axisid.export_targets import TARGETS
from axisid.exports import scaled
from tests.command_line import Refused, Run
from tests.estimation.methods.test_partially_linear import stribeck_axis
from tests.files import text_file
from tests.recipes import recipe_blocks
from tests.refusals import refuses
from tests.unjudged import identify


@pytest.fixture
def file(result: Identification, tmp_path: Path) -> Path:
    return text_file(tmp_path / "result.json", json.dumps(result.to_dict()))


@pytest.mark.parametrize("target", [target.name for target in TARGETS])
def test_a_result_and_its_file_give_the_same_text(
    run: Run, result: Identification, file: Path, tmp_path: Path, target: str
) -> None:
    wanted = export(result, target)
    code, out, err = run("export", file, "--axis", "emps2015", "--to", target)
    assert (code, out, err) == (0, wanted, "")
    other = tmp_path / "out"
    command = ("export", file, "--axis", "emps2015", "--to", target, "-o", other)
    assert run(*command) == (0, "", "")
    assert other.read_text() == wanted
    one = export(file, target, axis="emps2015", method="ddm-ls")
    assert one == export(result, target, method="ddm-ls") != wanted


def test_functions_have_the_numbers_and_say_of_which_code(result: Identification) -> None:
    told = (repr(result["didim"].parameters["M"].corrected), result.axis.signature)
    for target in ("c", "st", "python"):
        assert all(each in export(result, target) for each in told)


def test_json_and_csv_hold_every_method_and_parameter(result: Identification) -> None:
    written = json.loads(export(result, "json"))
    rows = list(csv.DictReader(io.StringIO(export(result, "csv"))))
    assert written["schema"] == "axisid.parameters/1"
    assert len(rows) == 15
    for row in rows:
        value = result[row["method"]].parameters[row["parameter"]]
        figures = written["parameters"][row["method"]][row["parameter"]]
        assert float(row["value"]) == value.value == figures["value"]
        interval = (float(row["lower_95"]), float(row["upper_95"]))
        assert interval == value.interval == tuple(figures["interval_95"])


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_toml_takes_the_place_of_a_declarations_parameters() -> None:
    text = scaffold("mine", newton=True, toml=True)
    Path("mine.toml").write_text(text)
    axis = load_axis("mine.toml")
    found = identify(axis, twin_record(axis), methods=["idm-iv"])
    made = export(found, "toml")
    table = made[made.index("[parameters]") : made.index("# Not part")]
    pasted = re.sub(r"\[parameters\].*?(?=\n\[)", lambda _: table, text, flags=re.DOTALL)
    Path("mine.toml").write_text(pasted)
    again = load_axis("mine.toml")
    assert {p.name: p.nominal for p in again.parameters} == {
        name: v.corrected for name, v in found["idm-iv"].parameters.items()
    }
    for before, after in zip(axis.parameters, again.parameters, strict=True):
        assert after == replace(before, nominal=after.nominal)
    figures = tomllib.loads(made)["identified"]
    mass = found["idm-iv"].parameters["m"]
    assert figures["parameters"]["m"] == {
        "value": mass.value,
        "unit": "kg",
        "sd_hac": mass.sd_hac,
        "interval_95": list(mass.interval),
        "interval_covariance": "hac",
    }
    assert figures["method"] == "idm-iv"


@pytest.mark.slow
def test_toml_leaves_out_a_bound_that_the_estimate_breaks(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    declared = emps2015.axis
    first = replace(
        declared.parameters[0], nominal=90.0, upper=95.0, description='a "b" \u00e9\x7f'
    )
    axis = replace(declared, parameters=(first, *declared.parameters[1:]))
    text = export(identify(axis, twin, methods=["idm-ls"]), "toml")
    mass = tomllib.loads(text)["parameters"]["M"]
    assert [*mass] == ["unit", "nominal", "lower", "description"]
    assert mass["description"] == first.description
    assert "# outside its bound upper = 95.0" in text


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (203.5034, 4.4103, r"203.5 \pm 4.4"),
        (1.23456e-5, 2.2e-7, r"(1.235 \pm 0.022) \cdot 10^{-5}"),
        (-7.2e8, 3.1e6, r"(-7.200 \pm 0.031) \cdot 10^{8}"),
        (0.0, 0.5, r"0.00 \pm 0.50"),
        (1.5, 0.0, r"1.500000 \pm 0.000000"),
        (12.0, 340.0, r"12 \pm 340"),
        (5e-324, 0.0, r"(0.000000 \pm 0.000000) \cdot 10^{-300}"),
    ],
)
def test_digits_are_those_that_the_deviation_warrants(value: float, sd: float, text: str) -> None:
    made = Value(
        value=value, unit="1", deviations=dict.fromkeys(COVARIANCES, sd), interval=(0.0, 1.0)
    )
    assert scaled(made, value, sd) == text


@pytest.mark.slow
def test_partially_linear_axes_are_exported_too() -> None:
    axis = stribeck_axis()
    found = identify(axis, twin_record(axis), methods=["idm-ls"])
    text = export(found, "st")
    assert "EXP(" in text
    assert repr(found["idm-ls"].parameters["v"].corrected).split("e")[0] in text


def test_axis_of_a_file_is_found_in_the_library_and_asked_for_where_it_is_none(
    file: Path, tmp_path: Path
) -> None:
    assert export(file, "c") == export(file, "c", axis="emps2015")
    assert export(file, "c") == export(file, "c", axis=load_axis("emps2015"))
    other = text_file(
        tmp_path / "other.json", file.read_text().replace('"axis": "emps2015"', '"axis": "mine"')
    )
    with refuses("result-file", says=r"'mine'\. .* \(axis\)"):
        export(other, "c")


def test_numbers_of_another_axis_are_refused(refused: Refused, file: Path, tmp_path: Path) -> None:
    edited = text_file(
        tmp_path / "edited.py",
        "from dataclasses import replace\nfrom axisid import load_axis\n"
        "from axisid.elements import Drive\n"
        "axis = replace(load_axis('emps2015'), drive=Drive(gain=35.0))\n",
    )
    for axis, says in (
        ("emps", "of the axis 'emps2015', but the current declaration of 'emps' has"),
        (edited, "identify again"),
    ):
        refused("export", file, "--axis", axis, "--to", "csv", says=says)


def test_bad_arguments_are_explained(
    refused: Refused, file: Path, result: Identification, tmp_path: Path
) -> None:
    command = ("export", file, "--axis", "emps2015", "--to")
    for arguments, message in (
        (("c", "--dead-zone", "-1"), "the dead zone is -1.0"),
        (("csv", "--dead-zone", "1"), "a dead zone applies to c, st, python only, not to csv"),
        (("rust",), "'rust' is not one of"),
        (("c", "-o", file), "it is an input of this run"),
        (("c", "-o", tmp_path / "no" / "x.c"), "the folder does not exist"),
    ):
        refused(*command, *arguments, says=message)
    refused("export", tmp_path / "absent.json", *command[2:], "c", code=3)
    with refuses("export", says="'rust'"):
        export(result, "rust")
    with refuses("result", says="'ols'"):
        export(result, method="ols")
    with refuses("result-file"):
        export(tmp_path, axis="emps2015")


PENDULUM = """\
name = "arm"
coordinate = { name = "q", unit = "rad" }
drive = { gain = 0.5, unit = "A", limit = 20.0 }
control = { law = "cascade_pd_averaged", kp = 20.0, kv = 12.0, period = 1e-3 }
parameters.m = { unit = "kg", nominal = 0.3, known = 0.24, known_sd = 0.001 }
parameters.l = { unit = "m", nominal = 0.5 }
parameters.fv = { unit = "N m/(rad/s)" }

[newton]
inertia = "m*l**2"
resistance = ["fv*dq", "m*G*l*sin(q)"]

[experiment]
back_and_forth = { speeds = [1.0, 3.0], acceleration = 20.0, seconds = 0.3, repeat = 1 }
truth = { m = 0.24, l = 0.5, fv = 0.02 }
position_noise = 1e-6
"""


@pytest.mark.slow
def test_physical_parameters_from_known_values_are_exported(tmp_path: Path) -> None:
    file = text_file(tmp_path / "arm.toml", PENDULUM)
    axis = load_axis(file)
    result = identify(axis, twin_record(axis), methods=["idm-ls", "idm-iv"])
    written = result.save(tmp_path / "arm.json")
    for source, given in ((result, None), (written, file)):
        found = json.loads(export(source, "json", axis=given))["parameters"]["idm-iv"]
        assert list(found) == [*result["idm-iv"].parameters, "m", "l"]
        value = result.physical["idm-iv"].parameters["l"]
        assert found["l"]["value"] == value.value
        assert found["l"]["interval_95"] == list(value.interval)
        table = export(source, "csv", axis=given)
        assert f"arm,idm-iv,l,m,{value.value!r}," in table
        assert "$l$ & $\\mathrm{m}$" in export(source, "latex", axis=given)
        assert "\nl = { value = " in export(source, "toml", axis=given)


#: Puts the recipe's file beside the other printers, and its row below theirs.
_ADDED = """
from axisid.codegen import printers
from axisid import export_targets as targets
from axisid.export_targets import _PRINTERS, ExportTarget

printers.__path__.append({folder!r})
targets.TARGETS += ({row},)
"""


@pytest.fixture(scope="module")
def folder(result: Identification, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result, and the file that the recipe for a target shows."""
    folder = tmp_path_factory.mktemp("toy")
    result.save(folder / "result.json")
    (folder / "printers").mkdir()
    (folder / "printers" / "javascript.py").write_text(recipe_blocks("Add a target")[0])
    return folder


def run(folder: Path, then: str) -> str:
    row = recipe_blocks("Add a target")[1].strip()
    program = _ADDED.format(folder=str(folder / "printers"), row=row) + then
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env={**os.environ, "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


#: What `run` is to run: command lines, one after the other.
COMMANDS = """
import sys
from axisid.commands.main import main
for line in {lines!r}:
    sys.argv = ["axisid", *line.split()]
    try:
        main()
    except SystemExit as end:
        assert not end.code, line
"""
EXPORT = "export result.json --axis emps2015 --to js"


@pytest.mark.slow
def test_one_file_and_one_row_add_a_target_to_the_command(folder: Path) -> None:
    # An earlier export is known and written anew.
    lines = [EXPORT, *[f"{EXPORT} -o emps2015.js"] * 2]
    text = run(folder, COMMANDS.format(lines=lines))
    for told in (
        "export function emps2015_feedforward(q, dq, ddq) {",
        "const M = ",
        "Math.sign(dq)",
        "const tau = emps2015_feedforward(q, dq, ddq);",
        "return (",
    ):
        assert told in text
    assert (folder / "emps2015.js").read_text() == text
