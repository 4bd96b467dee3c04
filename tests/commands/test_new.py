"""What `axisid new` writes runs at once and finds its own truth."""

import json
from pathlib import Path

import pytest

from axisid import load_axis
from axisid.commands.new import scaffold
from tests.command_line import Refused, Run

OPTIONS = [[], ["--lagrange"], ["--python"], ["--lagrange", "--python"]]


@pytest.mark.slow
@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_every_scaffold_shows_generates_and_identifies_its_twin_within_its_intervals_and_rounding(
    run: Run, here: Path, options: list[str]
) -> None:
    code, out, err = run("new", "mine", *options)
    assert (code, err) == (0, "")
    (file,) = here.iterdir()
    assert file.name == ("mine.py" if "--python" in options else "mine.toml")
    assert f"wrote {file.name}" in out
    show, identify = [line.split()[1:] for line in out.splitlines()[1:]]
    code, out, err = run(*show)
    assert (code, err) == (0, "")
    assert out.startswith("mine: ")
    code, out, err = run(*identify, "--method", "idm-iv", "--json", "-")
    assert (code, err) == (0, "")
    axis = load_axis(file)
    (estimate,) = json.loads(out)["estimates"]
    for name, value in estimate["parameters"].items():
        low, high = value["interval_95"]
        # At 60 Hz the filter rounds the reversals; with this little noise that shows, at 0.2 %.
        rounded = 2e-3 * abs(value["value"])
        assert low - rounded < axis.experiment.truth[name] < high + rounded, name
    assert run("generate", file.name)[0] == 0
    assert (here / "generated" / "mine" / "functions.py").is_file()


@pytest.mark.parametrize("newton", [True, False])
def test_both_languages_declare_the_same(here: Path, newton: bool) -> None:
    for toml, suffix in ((True, "toml"), (False, "py")):
        Path(f"same.{suffix}").write_text(scaffold("same", newton=newton, toml=toml))
    assert load_axis("same.toml") == load_axis("same.py")


def test_nothing_is_overwritten(refused: Refused, here: Path) -> None:
    (here / "mine.toml").write_text("precious")
    refused("new", "mine", says="exists already")
    assert (here / "mine.toml").read_text() == "precious"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["../mine"], "A name is a letter"),
        (["double"], "a keyword of C"),
        (["emps"], "an axis of the library"),
        (["sympy", "--python"], "would hide the Python module sympy"),
        ([], "or a log with --record"),
    ],
)
def test_bad_names_are_refused(
    refused: Refused, here: Path, arguments: list[str], message: str
) -> None:
    refused("new", *arguments, says=message)
    assert list(here.iterdir()) == []
