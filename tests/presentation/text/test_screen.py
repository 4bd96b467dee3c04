"""What `identify` prints by default fits on a screen and says what is to be believed."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from axisid import Prefilter, Record, identify
from axisid.codegen.artefacts import GeneratedAxis

Run = Callable[..., tuple[int, str, str]]


def test_emps_fits_on_a_screen(run: Run, emps_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    file.write_text(f"log = {str(emps_file)!r}\nsample_period = 1e-3\n")
    code, out, _ = run("identify", "emps", file)
    lines = out.splitlines()
    assert code == 0
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 100


def test_values_are_the_centres_of_their_intervals(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin)
    (row,) = re.findall(r"(?m)^M +kg +(\S+) +\S+ +(\S+) to (\S+)", result.summary())
    value, low, high = map(float, row)
    assert value == pytest.approx((low + high) / 2, abs=1e-3)
    assert value == pytest.approx(result.preferred.parameters["M"].corrected, abs=1e-3)


@pytest.mark.parametrize("switch", ["--all", "--full"])
def test_every_method_stands_beside_the_others_where_that_is_asked_for(
    run: Run, switch: str
) -> None:
    short, long = (run("identify", "emps2015", *more)[1] for more in ((), (switch,)))
    assert "DIDIM" in short
    assert "DDM-IV" not in short
    assert {"IDM-LS", "IDM-IV", "DIDIM", "DDM-LS", "DDM-IV"} <= {*long.split()}


def test_least_squares_stands_beside_what_it_is_off_by(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Reversals that are kept bias it by more than its interval."""
    kept = identify(emps2015, twin, Prefilter(reversals="keep"))
    assert "IDM-LS" in kept.summary()
