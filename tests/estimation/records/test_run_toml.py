"""A run.toml stands in the place of a log: every key, all mistakes at once, and how one starts."""

import math
import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import AxisidError, DataError, Record, load_axis, read_record
from axisid.estimation import Repairs
from axisid.estimation.choices import LOG_KEYS
from axisid.estimation.records import log_of, started_run
from axisid.support.errors import RunFileError
from tests.files import text_file
from tests.run_files import run_file

N = 400
TIME = 1e-3 * np.arange(N)
COLUMNS = {
    "t": TIME,
    "q": np.mod(40 * TIME, 2 * np.pi),
    "r": 40 * TIME,
    "u": np.clip(np.cos(30 * TIME), -0.9, 0.9),
    "v": np.repeat(40 + np.sin(30 * TIME[::4]), 4),
    "e": 0.1 * np.sin(90 * TIME),
}
ROLES = {"time": "t", "position": "q", "reference": "r", "control": "u"}
STRAIGHT = {"time": "t", "position": "r", "control": "u"}
WRAP = "6.283185307179586"


def write(folder: Path, ending: str = "") -> Path:
    log = folder / "log.csv"
    rows = zip(*(column.tolist() for column in COLUMNS.values()), strict=True)
    lines = [",".join(COLUMNS), *(",".join(map(repr, row)) for row in rows)]
    log.write_text("\n".join([*lines, ending]))
    return log


#: Of each key what is said in TOML, and what that is in Python.
SAID: dict[str, tuple[object, object]] = {
    "sample_period": (1e-3, 1e-3),
    "windows": (["0.05..0.2", "0.25.."], [(0.05, 0.2), (0.25, None)]),
    "injected_at": ("control", "control"),
    "resample": ("auto", "auto"),
    "gaps": ("split", "split"),
    "wrap": (WRAP, WRAP),
    "mask": ("clipped", "clipped"),
    "tail": ("drop", "drop"),
    "max_memory": (1e9, 1e9),
    "columns": (ROLES, ROLES),
    "shift": ({"control": 1}, {"control": 1}),
    "between": ({"velocity": "linear"}, {"velocity": "linear"}),
}


def same(one: Record, other: Record) -> bool:
    columns, others = one.channels(), other.channels()
    return (
        columns.keys() == others.keys()
        and all(np.array_equal(columns[role], others[role]) for role in columns)
        and (one.windows, one.masked, one.spans) == (other.windows, other.masked, other.spans)
        and one.provenance == other.provenance
    )


@pytest.mark.parametrize("key", LOG_KEYS)
def test_every_key_says_what_its_argument_says(key: str, tmp_path: Path) -> None:
    log = write(tmp_path, "some words\n" if key == "tail" else "")
    more = {"injected_at": {"injected": "e"}, "between": {"velocity": "v"}}.get(key, {})
    toml, python = ({"wrap": WRAP, key: said, "columns": {**ROLES, **more}} for said in SAID[key])
    repairs = {name: python.pop(name) for name in [*python] if LOG_KEYS[name].is_repair}
    found = read_record(run_file(log, **toml))
    assert same(found, read_record(log, **python, repairs=Repairs(**repairs)))
    without = read_record(log, columns=ROLES, repairs=Repairs(wrap=WRAP, tail="drop"))
    assert key in ("columns", "wrap", "tail", "max_memory") or not same(found, without)


def test_examples_of_keys_are_values_of_them(tmp_path: Path) -> None:
    log = write(tmp_path)
    refused = {}
    for key in LOG_KEYS.values():
        file = text_file(tmp_path / "run.toml", f'log = "{log.name}"\n{key.name} = {key.example}\n')
        try:
            read_record(file)
        except RunFileError as error:
            refused[key.name] = str(error)
        except AxisidError:
            pass  # it is said of another log
    assert refused == {}


def test_arguments_go_before_what_the_file_says_one_by_one(tmp_path: Path) -> None:
    log = write(tmp_path)
    said: dict[str, Any] = {"columns": {**ROLES, "control": "v"}, "wrap": WRAP, "gaps": "split"}
    file = run_file(log, windows="0.1..0.2", **said)
    found = read_record(
        file, columns={"control": "u"}, windows=[(0.0, 0.3)], repairs=Repairs(mask="clipped")
    )
    repairs = Repairs(wrap=WRAP, gaps="split", mask="clipped")
    assert same(found, read_record(log, columns=ROLES, windows=[(0.0, 0.3)], repairs=repairs))


def test_columns_may_be_tables_and_name_signals_of_the_axis(tmp_path: Path) -> None:
    log = write(tmp_path)
    scaled = run_file(log, columns={**STRAIGHT, "position": {"name": "r", "scale": 0.5}})
    assert read_record(scaled).position == pytest.approx(20 * TIME)
    slide = load_axis("balanced_slide")
    signal = slide.signals[0].name
    with pytest.raises(RunFileError, match=rf"columns\.{signal}: the key is unknown"):
        read_record(run_file(log, columns={signal: "v"}))
    with pytest.raises(DataError) as refused:
        read_record(run_file(log, columns={signal: "nothing"}), slide)
    assert not isinstance(refused.value, RunFileError)


def test_the_log_is_as_from_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = run_file(write(tmp_path), columns=STRAIGHT)
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    assert len(read_record("../run.toml")) == len(read_record(file)) == N
    assert log_of("../run.toml") == Path("../log.csv")
    assert log_of("../log.csv") == Path("../log.csv")


MISTAKES = """
gaps = "splitt"
windows = "5..2"
sample_period = "fast"
colums = {}
mask = false
max_memory = -1
injected_at = "here"
wrap = [1]
resample = true
tail = "crop"
log = "lgo.csv"
[columns]
positon = "q"
time = 3
[shift]
controll = 1
[between]
velocity = "splin"
"""


def test_all_mistakes_are_told_at_once_each_with_its_key(tmp_path: Path) -> None:
    write(tmp_path)
    file = text_file(tmp_path / "run.toml", MISTAKES)
    with pytest.raises(RunFileError) as refused:
        read_record(file)
    told = dict(mistake.split(": ", 1) for mistake in refused.value.mistakes)
    keys = {*LOG_KEYS, "colums", "columns.positon", "columns.time", "log", "shift.controll"}
    keys -= {"columns", "shift"}
    assert told.keys() == keys
    assert refused.value.headline.endswith("run.toml has 15 mistakes:")
    for key, said in {
        "gaps": "no repair of gaps 'splitt'",
        "colums": "Did you mean 'columns'?",
        "columns.positon": "Did you mean 'position'?",
        "shift.controll": "Did you mean 'control'?",
        "log": "Did you mean 'log.csv'?",
        "sample_period": "'fast'",
    }.items():
        assert said in told[key]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "log: the path of the log is missing"),
        ('log = "run.toml"', "log: the path of the log is 'run.toml'"),
        ("log = 3", "path of a log"),
        ("log = log.csv", "is not valid TOML"),
        ("columns = 1", r"table, as in \[columns\]"),
    ],
)
def test_what_is_no_run_file_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(RunFileError, match=said):
        read_record(tmp_path / "run.toml")


def test_a_started_file_has_what_was_found_and_runs(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = (f"{i};{10 * math.sin(0.01 * i):.4f};{i % 7}" for i in range(500))
    log.write_text("\n".join(["t;pos [mm];u", *rows]))
    file = text_file(tmp_path / "run.toml", started_run(log))
    text = file.read_text()
    assert tomllib.loads(text) == {"log": "log.csv", "columns": {}}
    for role in ("time", "position", "control"):
        text = text.replace(f"\n# {role} = ", f"\n{role} = ")
    file.write_text(text)
    named = {"time": "t:ms", "position": "pos", "control": "u"}
    assert tomllib.loads(text) == {"log": "log.csv", "columns": named}
    assert all(f"\n# {key} = " in text for key in LOG_KEYS if key != "columns")
    assert '"pos": -' in text
    assert same(read_record(file), read_record(log, columns=named))


def test_a_started_file_is_toml_whatever_columns_are_called(tmp_path: Path) -> None:
    odd = ['a "b" \\ c', "\x7f", "é\u2028", "Position", "position", "T", "x" * 3000]
    np.savez(tmp_path / "log.npz", **dict.fromkeys(odd, TIME), gain=[[50.0]], machine="A")
    text = started_run(tmp_path / "log.npz")
    assert '#   "gain": one number, 50.0\n#   "machine": text\n' in text
    for role in ("time", "position"):
        text = text.replace(f"\n# {role} = ", f"\n{role} = ")
    assert tomllib.loads(text)["columns"] == {"time": "T", "position": "position"}
    assert max(map(len, text.splitlines())) < 200


def test_what_cannot_be_read_is_refused_and_waits_for_nothing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.toml")
    for file in (tmp_path / "run.toml", Path("a\0.toml"), tmp_path / "none.toml"):
        with pytest.raises(RunFileError, match="cannot be read"):
            read_record(file)
        assert log_of(file) == file
