"""How a log is read from the command line: units, repairs, and what is told of them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import Record
from tests.run_files import run_file

Run = Callable[..., tuple[int, str, str]]
FILTER = ("--method", "idm-ls")


@pytest.fixture
def columns(twin: Record) -> dict[str, np.ndarray]:
    named = {role: np.array(values[:3000]) for role, values in twin.channels().items()}
    return {"t": named["time"], "pos": named["position"], "volts": named["control"]}


def write(file: Path, columns: dict[str, np.ndarray], *, german: bool = False) -> Path:
    separator, mark = (";", ",") if german else (",", ".")
    rows = zip(*columns.values(), strict=True)
    lines = [separator.join(f"{x:.17g}".replace(".", mark) for x in row) for row in rows]
    file.write_text("\n".join([separator.join(columns), *lines]), encoding="utf-8")
    return file


CHOSEN = "time=t,position=pos,control=volts"


def estimates(run: Run, *arguments: object) -> dict[str, Any]:
    code, out, err = run("identify", "emps2015", *arguments, *FILTER, "--json", "-")
    assert code == 0, err
    found: dict[str, Any] = json.loads(out)
    return found


def values(result: dict[str, Any]) -> list[float]:
    return [p["value"] for p in result["estimates"][0]["parameters"].values()]


@pytest.mark.slow
def test_a_column_whose_name_has_a_comma_is_quoted(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    named = {"t": columns["t"], "pos": columns["pos"], "volts, raw": columns["volts"]}
    file = write(tmp_path / "comma.csv", named, german=True)
    found = estimates(run, file, "--columns", 'time=t, position=pos,"control=volts, raw:V"')
    assert found["record"]["columns"]["control"] == "volts, raw"
    code, _, err = run("identify", "emps2015", file, "--columns", "time=t,control=volts, raw")
    assert code == 2
    assert "quote a pair whose name has a comma" in " ".join(err.split())


@pytest.mark.slow
def test_log_in_other_units_and_another_dialect_gives_the_same_estimates(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    plain = estimates(run, write(tmp_path / "si.csv", columns), "--columns", CHOSEN)
    scaled = {
        "t": 1e3 * columns["t"],
        "pos [mm]": 1e3 * columns["pos"],
        "volts": 1e3 * columns["volts"],
    }
    file = write(tmp_path / "scaled.csv", scaled, german=True)
    other = estimates(run, file, "--columns", "time=t:ms,position=pos,control=volts:mV")
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
        (["--resample", "fast"], 2, "resample at is 'fast'; give hertz, or auto"),
        (["--resample", "-1"], 2, "resample at is -1.0; give hertz, or auto"),
        (["--resample", "100"], 2, "its noise would fold"),
        (["--columns", "time=t,position=pos:deg,control=volts"], 2, "is measured in m"),
        (["--columns", "time=t,position=pos:inc,control=volts"], 2, "'inc', which is not known"),
        (["--gaps", "fill"], 2, "no repair of gaps 'fill'; choose from split"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(
    run: Run,
    tmp_path: Path,
    columns: dict[str, np.ndarray],
    options: list[str],
    code: int,
    message: str,
) -> None:
    file = write(tmp_path / "log.csv", columns)
    chosen = [] if "--columns" in options else ["--columns", CHOSEN]
    got, out, err = run("identify", "emps2015", file, *chosen, *options)
    assert (got, out) == (code, "")
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_windows_are_taken_and_told(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    file = write(tmp_path / "log.csv", columns)
    one = estimates(run, file, "--columns", CHOSEN, "--window", "0.5..2.5")
    assert one["record"]["windows"] == [[0.5, 2.5]]
    two = estimates(run, file, "--columns", CHOSEN, "--window", "..1", "--window", "1.5..")
    first, last = columns["t"][[0, -1]]
    assert two["record"]["windows"] == [[first, 1.0], [1.5, last]]
    cut = write(tmp_path / "cut.csv", {k: v[500:2501] for k, v in columns.items()})
    assert values(estimates(run, cut, "--columns", CHOSEN)) == values(one)


@pytest.mark.slow
def test_a_second_record_has_windows_of_its_own(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray]
) -> None:
    file = write(tmp_path / "log.csv", columns)
    other = run_file(file, windows="1.5..2.5")
    words = ("--columns", CHOSEN, "--window", "..1.5", "--validate", other)
    found = estimates(run, file, *words)
    assert found["record"]["windows"] == [[0.0, 1.5]]
    assert found["validation"]["record"]["windows"] == [[1.5, 2.5]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--window", "2-5"), "a window is '2-5'; give FROM..TO"),
        (("--window", "5..2"), "does not end after it begins"),
        (("--window", "100.."), "holds no samples of the log"),
        (("--validate-like", "1"), "nothing without --validate"),
    ],
)
def test_windows_that_cannot_be_are_refused(
    run: Run, tmp_path: Path, columns: dict[str, np.ndarray], arguments: tuple[object], said: str
) -> None:
    file = write(tmp_path / "log.csv", columns)
    code, _, err = run("identify", "emps2015", file, "--columns", CHOSEN, *arguments, *FILTER)
    assert code == (3 if "100.." in arguments else 2)
    assert said in " ".join(err.split())
