"""An axis with a one-sided spring, declared by its energies in TOML, from `show` to `identify`."""

import json
from pathlib import Path

import pytest

from tests.command_line import Refused, Run
from tests.files import text_file

AXIS = """
name = "bumper"
coordinate = {{ name = "x", unit = "m" }}

[parameters]
M = {{ unit = "kg", nominal = 5, lower = 0 }}
Fv = {{ unit = "N/(m/s)" }}
Fc = {{ unit = "N" }}
k = {{ unit = "{unit}" }}

[constants]
rest = {{ value = 0.04, unit = "m" }}

[lagrange]
kinetic = "M*dx**2/2"
potential = "{potential}"
dissipation = "Fv*dx**2/2 + Fc*abs(dx)"

[drive]
gain = 18.0
unit = "A"

[control]
law = "cascade_pd"
kp = 50.0
kv = 60.0
period = 1e-3

[experiment]
back_and_forth = {{ speeds = [0.1, 0.2, 0.3], acceleration = 4.0, seconds = 0.4, repeat = 3 }}
truth = {{ M = 6.2, Fv = 14.0, Fc = 7.5, k = {truth} }}
position_noise = 1e-6
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("potential", "unit", "truth"),
    [
        ("k*max(0, x - rest)**2/2", "N/m", 250.0),
        ("k*abs(x - rest)**3/3", "N/m^2", 3000.0),
        ("k*max(x, rest)", "N", 9.0),
    ],
)
def test_a_potential_with_a_kink_is_shown_generated_and_identified(
    run: Run, tmp_path: Path, potential: str, unit: str, truth: float
) -> None:
    file = text_file(
        tmp_path / "bumper.toml", AXIS.format(potential=potential, unit=unit, truth=truth)
    )
    for style in ("text", "latex", "markdown"):
        code, _, err = run("show", file, "--format", style)
        assert code == 0, err
    code, _, err = run("generate", file, "--output", tmp_path / "generated")
    assert code == 0, err
    code, out, err = run("identify", file, "--json", "-")
    assert code == 0, err
    estimates = json.loads(out)["estimates"]
    assert len(estimates) == 5
    for estimate in estimates:
        found = {name: p["value"] for name, p in estimate["parameters"].items()}
        assert found["k"] == pytest.approx(truth, rel=0.01), estimate["method"]
        assert found["M"] == pytest.approx(6.2, rel=0.01), estimate["method"]


def test_a_potential_that_jumps_is_refused(refused: Refused, tmp_path: Path) -> None:
    file = text_file(
        tmp_path / "bumper.toml", AXIS.format(potential="k*sign(x - rest)", unit="J", truth=1.0)
    )
    refused("show", file, says="the potential energy jumps with x", code=4)
