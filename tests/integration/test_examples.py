"""The examples run, and the README's code is code that runs."""

import re
import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import Experiment, back_and_forth, load_axis, twin_record

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_example_axes_are_identified_from_their_twins(
    run: Callable[..., tuple[int, str, str]], file: Path
) -> None:
    axis = load_axis(str(file))
    code, out, err = run("identify", file, "--hold", "zoh")
    assert (code, err) == (0, "")
    assert axis.experiment is not None
    for line in out.splitlines():
        name, *cells = line.split() or [""]
        if name in axis.experiment.truth and len(cells) > 6:
            values = [float(cell) for cell in cells if re.fullmatch(r"-?\d+\.\d{4,}", cell)]
            assert values[0] == pytest.approx(axis.experiment.truth[name], rel=0.03)


def test_belt_example_is_also_a_program(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "examples" / "belt_drive.py"), run_name="__main__")
    assert "belt drive with a return spring" in capsys.readouterr().out


def test_readme_code_runs_as_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from dataclasses import replace

    declaration, script = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    monkeypatch.chdir(tmp_path)
    Path("my_axis.py").write_text(declaration)
    experiment = Experiment(
        moves=back_and_forth(speeds=(0.1, 0.3), acceleration=4.0, seconds=0.5, repeat=3),
        truth={"m": 6.2, "b": 14.0, "c": 7.5},
    )
    twin = twin_record(replace(load_axis("my_axis.py"), experiment=experiment))
    assert twin.reference is not None
    assert twin.control is not None
    np.savetxt(
        "log.csv",
        np.column_stack([twin.time, twin.reference, twin.position, twin.control]),
        delimiter=",",
        header="time,reference,position,cmd",
        comments="",
    )
    exec(script, {})
    out = capsys.readouterr().out
    assert "stage" in out
    assert "DDM-IV" in out
