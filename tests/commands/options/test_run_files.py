"""How a log is read: by options, or by a run.toml, which stands in its place in every command."""

import json
import shutil
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

from axisid import Record, fleet, load_axis
from axisid.commands.main import cli
from axisid.fleets import gather_items
from tests.command_line import Refused, Run
from tests.files import csv_file, text_file
from tests.run_files import run_file

LS = ("--method", "idm-ls", "--bootstrap", "0")
NAMED = {"time": "t", "reference": "r", "position": "pos", "control": "volts"}


@pytest.fixture
def log(twin: Record, tmp_path: Path) -> Path:
    columns = {NAMED[role]: values[:3000] for role, values in twin.channels().items()}
    columns["pos"] = 1e3 * columns["pos"]
    return csv_file(tmp_path / "log.csv", columns, "%.12g")


OPTIONS = ("--columns", "time=t,reference=r:mm,position=pos:mm,control=volts", "--window", "0.2..2")
SAID: dict[str, Any] = {
    "columns": {**NAMED, "position": "pos:mm", "reference": "r:mm"},
    "windows": "0.2..2",
}


def told(run: Run, *words: object) -> dict[str, Any]:
    code, out, err = run(*words, "--json", "-")
    assert code == 0, err
    found: dict[str, Any] = json.loads(out)
    return found


@pytest.mark.parametrize(
    "command",
    [
        ("identify", "emps2015", "{}", *LS),
        ("compare", "--ladder", "emps2015", "{}"),
        pytest.param(("fit", "emps2015", "{}", "--bootstrap", "0"), marks=pytest.mark.slow),
        pytest.param(("sweep", "emps2015", "{}", "--points", "2"), marks=pytest.mark.slow),
        pytest.param(("law", "emps2015", "{}"), marks=pytest.mark.slow),
    ],
    ids=lambda words: words[0],
)
def test_it_stands_in_the_place_of_a_log(run: Run, log: Path, command: tuple[str, ...]) -> None:
    own = told(run, *(word.format(run_file(log, **SAID)) for word in command))
    other = told(run, *(word.format(log) for word in command), *OPTIONS)
    assert own == other


@pytest.mark.slow
def test_options_go_before_it_and_a_second_record_is_as_its_own_says(run: Run, log: Path) -> None:
    first = run_file(log, "first.toml", **{**SAID, "windows": "0.2..1.2"})
    second = run_file(log, "second.toml", **{**SAID, "windows": "1.5..2.5"})
    found = told(run, "identify", "emps2015", first, *LS, "--validate", second)
    assert found["record"]["windows"] == [[0.2, 1.2]]
    assert found["validation"]["record"]["windows"] == [[1.5, 2.5]]
    found = told(run, "identify", "emps2015", first, *LS, "--window", "0.3..2")
    assert found["record"]["windows"] == [[0.3, 2.0]]


def test_a_second_record_that_the_filter_does_not_suit_is_refused_before_all_else(
    refused: Refused, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("axisid.commands.options.stages.identify", None, raising=False)
    short = run_file(log, "short.toml", **{**SAID, "windows": "0.2..0.25"})
    first = run_file(log, **SAID)
    refused(
        "identify", "emps2015", first, "--validate", short, code=3, says="the record of --validate"
    )


def test_its_mistakes_are_listed_and_it_is_no_axis(refused: Refused, log: Path) -> None:
    file = run_file(log, gapz="split", mask="clip")
    lines = refused("identify", "emps2015", file, code=3).splitlines()
    assert lines[0].endswith("run.toml has 2 mistakes:")
    assert "gapz: the key is unknown" in lines[1]
    assert "Did you mean 'gaps'?" in lines[1]
    assert lines[2] == "  mask: there is no mask 'clip'. Choose from clipped."
    wrong = run_file(log, **{**SAID, "resample": 100.0})  # which the log alone tells
    refused("identify", "emps2015", wrong, says="alias the noise", code=3)
    refused("identify", file, "emps2015", says="is a log. Name the axis before")
    to_log = ("--json", log, "--force")
    refused("identify", "emps2015", run_file(log), *to_log, says="it is an input of this run")


def test_a_list_of_axes_ends_before_it(refused: Refused, log: Path) -> None:
    refused("compare", "--axes", "emps2015", run_file(log, **SAID), says="two or more axes")


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_what_new_writes_gives_what_options_give(run: Run, twin: Record) -> None:
    twin.write("log.csv", load_axis("emps2015"))
    code, out, err = run("new", "--record", "log.csv")
    assert (code, err) == (0, "")
    assert "axisid identify AXIS run.toml" in out
    own = told(run, "identify", "emps2015", "run.toml", *LS)
    assert own == told(run, "identify", "emps2015", "log.csv", *LS)
    text = Path("run.toml").read_text()
    Path("run.toml").write_text(text.replace('# windows = ["2..8.5", "12.."]', 'windows = "1..3"'))
    own = told(run, "identify", "emps2015", "run.toml", *LS)
    assert own == told(run, "identify", "emps2015", "log.csv", *LS, "--window", "1..3")


def test_new_keeps_what_is_there_and_stays_beside_the_log(run: Run, log: Path) -> None:
    assert run("new", "mine", "--record", log)[0] == 0
    assert (log.parent / "mine.toml").is_file()
    for words, said in (
        (("mine", "--record", log), "exists already"),
        (("../mine", "--record", log), "is not a file name"),
        (("--record", log, "--python"), "--record writes a run.toml"),
        (("--record", log.parent / "absent.csv"), "cannot be read"),
        ((), "or a log with --record"),
    ):
        code, _, err = run("new", *words)
        assert code in (2, 3)
        assert said in err


@pytest.mark.slow
def test_a_fleet_takes_it_from_folders_manifests_and_python(log: Path) -> None:
    logs = log.parent / "logs"
    for name in ("a", "b"):
        (logs / name).mkdir(parents=True)
        run_file(Path(shutil.copy(log, logs / name)), **SAID)
    (logs / "axis.toml").write_text('name = "mine"\n')
    items = gather_items(logs, log.parent / "out")
    assert [Path(item.log).relative_to(logs).as_posix() for item in items] == [
        "a/run.toml",
        "b/run.toml",
    ]
    manifest = log.parent / "manifest.csv"
    manifest.write_text("log,serial\nlogs/a/run.toml,1\nlogs/b/run.toml,2\n")
    how: dict[str, Any] = {"jobs": 1, "methods": ["idm-ls"], "bootstrap": 0}
    out = log.parent / "out"
    result = fleet(manifest, "emps2015", out, **how)
    assert not result.failed
    assert sorted(file.name[:3] for file in out.glob("*.json")) == ["log", "log"]
    before = [row.key for row in result.rows]
    assert [row.key for row in fleet(manifest, "emps2015", out, resume=True, **how).rows] == before
    run_file(logs / "a" / "log.csv", **{**SAID, "windows": "0.5..2"})
    (logs / "b" / "log.csv").write_text(log.read_text() + "\n")
    again = fleet(manifest, "emps2015", out, resume=True, **how)
    assert all(one != other for one, other in zip((r.key for r in again.rows), before, strict=True))


@pytest.mark.parametrize("name", ["identify", "fit", "sweep", "compare", "law", "fleet"])
def test_options_of_a_log_are_four_and_help_says_where_the_rest_is(run: Run, name: str) -> None:
    said = " ".join(run(name, "--help")[1].split())
    assert "A run.toml holds all other settings of a log" in said
    options = {o for p in cli.commands[name].params for o in p.opts}
    assert {"--columns", "--window", "--resample", "--gaps"} <= options
    assert not {"--sample-period", "--shift", "--wrap", "--mask", "--tail"} & options


def test_identify_has_few_options_below_titles(run: Run) -> None:
    options = [p for p in cli.commands["identify"].params if isinstance(p, click.Option)]
    assert len(options) <= 25
    said = run("identify", "--help")[1]
    titles = [line for line in said.splitlines() if line.endswith(":") and line[0] != " "]
    assert titles[0] == "Log:"
    assert "Options:" not in titles
    assert all(f"\n  {option.opts[-1]}" in said for option in options)


def test_a_key_that_is_taken_for_an_option_is_told(refused: Refused) -> None:
    said = "sample_period is a key of a log's run.toml. Write a run.toml with axisid new --record"
    refused("identify", "emps", "log.csv", "--sample-period", "1e-3", says=said)


IDENTIFY = ("identify", "emps2015", "--method", "idm-ls")


@pytest.fixture
def columns(twin: Record) -> dict[str, np.ndarray]:
    named = {role: np.array(values[:3000]) for role, values in twin.channels().items()}
    return {"t": named["time"], "pos": named["position"], "volts": named["control"]}


def german(file: Path, columns: dict[str, np.ndarray]) -> Path:
    """Columns with a decimal comma."""
    rows = zip(*columns.values(), strict=True)
    lines = [";".join(f"{x:.17g}".replace(".", ",") for x in row) for row in rows]
    return text_file(file, "\n".join([";".join(columns), *lines]))


CHOSEN = "time=t,position=pos,control=volts"


def values(result: dict[str, Any]) -> list[float]:
    return [p["value"] for p in result["estimates"][0]["parameters"].values()]


@pytest.mark.slow
def test_a_column_whose_name_has_a_comma_is_quoted(
    run: Run, refused: Refused, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    named = {"t": columns["t"], "pos": columns["pos"], "volts, raw": columns["volts"]}
    file = german(tmp_path / "comma.csv", named)
    quoted = 'time=t, position=pos,"control=volts, raw:V"'
    found = told(run, *IDENTIFY, file, "--columns", quoted)
    assert found["record"]["columns"]["control"] == "volts, raw"
    unquoted = ("--columns", "time=t,control=volts, raw")
    refused("identify", "emps2015", file, *unquoted, says="Quote a pair whose name has a comma")


@pytest.mark.slow
def test_log_in_other_units_and_another_dialect_gives_the_same_estimates(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    plain = told(run, *IDENTIFY, csv_file(tmp_path / "si.csv", columns), "--columns", CHOSEN)
    scaled = {
        "t": 1e3 * columns["t"],
        "pos [mm]": 1e3 * columns["pos"],
        "volts": 1e3 * columns["volts"],
    }
    file = german(tmp_path / "scaled.csv", scaled)
    units = "time=t:ms,position=pos,control=volts:mV"
    other = told(run, *IDENTIFY, file, "--columns", units)
    assert values(other) == pytest.approx(values(plain), rel=1e-9)
    assert other["record"]["assumed"] == [
        "separator semicolon, decimal comma",
        "time: ms -> s",
        "position: mm -> m",
        "control: mV -> V",
    ]


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--resample", "fast"], 2, "resampling rate is 'fast'"),
        (["--resample", "-1"], 2, "resampling rate is -1.0"),
        (["--resample", "100"], 2, "alias the noise"),
        (["--columns", "time=t,position=pos:deg,control=volts"], 2, "is measured in m"),
        (["--columns", "time=t,position=pos:inc,control=volts"], 2, "size of one count"),
        (["--gaps", "fill"], 2, "no repair of gaps 'fill'"),
        (["--window", "2-5"], 2, "Give FROM..TO"),
        (["--window", "5..2"], 2, "does not end after it begins"),
        (["--window", "100.."], 3, "has no samples"),
        (["--validate-like", "1"], 2, "no effect without --validate"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(
    refused: Refused,
    tmp_path: Path,
    columns: dict[str, np.ndarray],
    options: list[str],
    code: int,
    message: str,
) -> None:
    file = csv_file(tmp_path / "log.csv", columns)
    chosen = [] if "--columns" in options else ["--columns", CHOSEN]
    said = refused("identify", "emps2015", file, *chosen, *options, says=message, code=code)
    assert said.count("\n") == 1


@pytest.mark.slow
def test_windows_are_taken_and_told(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    file = csv_file(tmp_path / "log.csv", columns)
    chosen = (*IDENTIFY, file, "--columns", CHOSEN)
    one = told(run, *chosen, "--window", "0.5..2.5")
    assert one["record"]["windows"] == [[0.5, 2.5]]
    two = told(run, *chosen, "--window", "..1", "--window", "1.5..")
    first, last = columns["t"][[0, -1]]
    assert two["record"]["windows"] == [[first, 1.0], [1.5, last]]
    cut = csv_file(tmp_path / "cut.csv", {k: v[500:2501] for k, v in columns.items()})
    assert values(told(run, *IDENTIFY, cut, "--columns", CHOSEN)) == values(one)
