"""``axisid fit``: what it takes, prints, writes and refuses."""

import json
import pickle
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from axisid import Record, compare_results, fit, load_axis, load_result, read_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.presentation.result_files import SavedOutputFit
from tests.command_line import Refused, Run
from tests.refusals import refuses


@pytest.fixture
def log(tmp_path: Path, twin: Record) -> Path:
    return twin.write(tmp_path / "log.csv", load_axis("emps2015"))


@pytest.mark.slow
def test_options_reach_the_fit(run: Run, log: Path) -> None:
    options = ("--output", "position", "--loss", "soft-l1", "--start", "nominal", "--starts", 2)
    options += ("--bound", "Fc=..20", "--bound", "Fv=1..", "--prior", "M=100+-1")
    _, out, err = run("fit", "emps2015", log, *options, "--json", "-")
    written = json.loads(out)
    assert [written[n] for n in ("output", "loss", "started")] == ["position", "soft-l1", "nominal"]
    assert len(written["costs"]) == 2
    of = written["parameters"]
    assert of["Fc"]["bounds"] == [0.0, 20.0]
    assert of["Fc"]["at_bound"] == "upper"
    assert of["Fv"]["bounds"] == [1.0, None]
    assert of["M"]["prior"] == {"value": 100.0, "sd": 1.0}
    assert not err


@pytest.mark.parametrize(
    ("axis", "options", "says"),
    [
        ("emps2015", "--free kp,foo", "no gain 'foo'"),
        ("emps2015", "--bound Fc=..", "is not a bound"),
        ("emps2015", "--bound =1..2", "is not a bound"),
        ("emps2015", "--weight position", "is not a weight"),
        ("emps2015", "--weight position=fine", "is not a weight"),
        (
            "emps2015",
            "--bound M=90..100 --fix M=120",
            "'M' has both a fixed value and a bound",
        ),
        ("emps2015", "--horizon 1", "axisid fit --output open-loop"),
        # Before the axis is derived:
        ("nosuch.toml", "--output openloop", "--output"),
        ("nosuch.toml", "--prior M=95", "--prior"),
        (
            "nosuch.toml",
            "--bound M=1..2 --bound M=3..4",
            "--bound M is given 2 times",
        ),
        ("nosuch.toml", "--fix M=1 --fix Fc=2 --fix M=3", "--fix M is given 2 times"),
        ("nosuch.toml", "--known M=1 --known M=3", "--known M is given 2 times"),
    ],
)
def test_a_wrong_option_is_told(
    refused: Refused, log: Path, axis: str, options: str, says: str
) -> None:
    refused("fit", axis, log, *options.split(), says=says)


@pytest.mark.slow
def test_a_fit_is_read_back_as_it_was_written(
    run: Run, log: Path, tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    file, page = tmp_path / "fit.json", tmp_path / "fit.html"
    run("fit", "emps2015", log, "--json", file, "--report", page)
    saved = load_result(file)
    assert isinstance(saved, SavedOutputFit)
    with refuses("figure", says="the figure needs rows, samples or runs"):
        saved.plot("")
    assert saved.to_dict().items() <= json.loads(file.read_text()).items()
    found = fit(emps2015, read_record(log, emps2015))
    assert saved["M"].interval == pytest.approx(found["M"].interval)
    np.testing.assert_allclose(saved.covariance, found.covariance)
    assert saved.derive("M/Fv").interval == pytest.approx(found.derive("M/Fv").interval)
    assert saved.believed == found.believed
    assert pickle.loads(pickle.dumps(saved)) == saved  # noqa: S301
    html = page.read_text()
    assert 'id="figure-output"' in html
    assert "http" not in html.split("<body>")[1].split("<script")[0]


@pytest.mark.slow
def test_several_outputs_are_followed_and_read_back(run: Run, log: Path, tmp_path: Path) -> None:
    file = tmp_path / "fit.json"
    options = ("--output", "control,position", "--weight", "position=2e5")
    code, _, _ = run("fit", "emps2015", log, *options, "--json", file)
    assert code == 0
    written = json.loads(file.read_text())
    assert [each["output"] for each in written["record_errors"]] == ["control", "position"]
    assert written["record_errors"][1]["weight"] == 2e5
    saved = load_result(file)
    assert isinstance(saved, SavedOutputFit)
    assert saved.to_dict().items() <= written.items()


@pytest.mark.slow
def test_a_fit_is_no_result_of_identify(run: Run, log: Path, tmp_path: Path) -> None:
    file = tmp_path / "fit.json"
    run("fit", "emps2015", log, "--json", file)
    with refuses("result-file", says="is a fit of an output"):
        compare_results(file, file)


@pytest.mark.slow
def test_ctrl_c_keeps_the_best_values_of_a_fit(
    run: Run, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(done: int, _: int, __: str) -> None:
        if done:
            raise KeyboardInterrupt

    module = sys.modules["axisid.commands.fit"]
    monkeypatch.setattr(module, "progress_line", lambda _: nullcontext(interrupted))
    file = tmp_path / "fit.json"
    code, out, _ = run("fit", "emps2015", log, "--json", file)
    assert code == 130
    assert load_result(file)["M"].value == pytest.approx(100.2, rel=0.1)
    assert "interrupted after 2 steps" in out
