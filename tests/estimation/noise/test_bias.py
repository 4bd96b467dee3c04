"""Least squares less instruments against a resampling of its own, and where intervals miss."""

from pathlib import Path

import numpy as np
import pytest

from axisid import Identification, Record, build, identify, load_axis, read_record, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.noise import NoiseBias, noise_biases
from benchmarks.machines import Machine, records, white


def _reference() -> np.ndarray:
    time = 1e-3 * np.arange(8000)
    waves = 0.02 * np.sin(2 * np.pi * 0.5 * time) + 0.004 * np.sin(2 * np.pi * 1.9 * time)
    return np.minimum(1.0, time / 0.5) * waves


def _results(axis: GeneratedAxis, machine: Machine, runs: int) -> list[Identification]:
    every = records(machine, _reference(), runs, 5)
    return [
        identify(axis, read_record(columns, axis), methods=["idm-ls", "idm-iv"], bootstrap=0)
        for columns in every
    ]


def _biases(results: list[Identification]) -> list[dict[str, NoiseBias]]:
    return [noise_biases(result.estimates)["idm-ls"] for result in results]


@pytest.mark.slow
def test_interval_that_noise_of_the_position_moves_is_said_to_miss(
    emps2015: GeneratedAxis,
) -> None:
    machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(5e-6))
    for result in _results(emps2015, machine, 2):
        bias = result.diagnosis.noise_biases["idm-ls"]["M"]
        low, high = result["idm-ls"].parameters["M"].interval
        assert bias.misses
        assert not low < 100.2 < high
        assert bias.difference < 0
        (check,) = (c for c in result.verdict if c.name == "least squares against instruments")
        assert check.status == "note"
        assert "its 95 % interval of M misses for it" in check.meaning
        row = next(
            line for line in result.summary().splitlines() if line.startswith("  moved by noise")
        )
        assert float(row.split()[3]) == pytest.approx(bias.difference, rel=0.01)


@pytest.mark.slow
def test_noise_of_the_recorded_control_moves_nothing(emps2015: GeneratedAxis) -> None:
    machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, control_noise=white(0.05))
    results = _results(emps2015, machine, 6)
    biases = _biases(results)
    assert biases[0] == results[0].diagnosis.noise_biases["idm-ls"]
    assert not any(b.misses for of_one in biases for b in of_one.values())
    assert all(b.shift < 0.1 for of_one in biases for b in of_one.values())
    assert np.median([of_one["M"].p_value for of_one in biases]) > 0.01
    assert "moved by noise" not in results[0].summary()


@pytest.mark.slow
@pytest.mark.parametrize("runs", [6, pytest.param(16, marks=pytest.mark.slow)])
def test_deviation_of_the_difference_is_its_scatter(emps2015: GeneratedAxis, runs: int) -> None:
    """Noise of the position, over runs: what the difference scatters by, chance alone."""
    machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(5e-6))
    every = [of_one["M"] for of_one in _biases(_results(emps2015, machine, runs))]
    scatter = np.std([b.difference for b in every], ddof=1)
    assert 0.5 < np.mean([b.deviation for b in every]) / scatter < 3


def test_it_needs_a_form_with_both(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, methods=["idm-ls", "ddm-ls", "ddm-iv"])
    assert set(noise_biases(result.estimates)) == {"ddm-ls"}
    assert noise_biases({"idm-ls": result["idm-ls"]}) == {}


@pytest.mark.parametrize(
    ("p", "joint", "shift", "moved", "misses"),
    [
        (0.001, 0.001, 3.0, True, True),
        (0.001, 0.001, 1.0, True, False),
        (0.02, 0.001, 9.0, False, False),
        (0.001, 0.02, 9.0, False, False),
        (1e-9, 1e-9, 0.4, False, False),
    ],
)
def test_interval_misses_where_both_tests_reject_and_it_excludes_the_instruments(
    p: float, joint: float, shift: float, *, moved: bool, misses: bool
) -> None:
    bias = NoiseBias(difference=1.0, deviation=0.1, p_value=p, joint_p_value=joint, shift=shift)
    assert (bias.moved, bias.misses) == (moved, misses)


_SCREW = """
name = "zscrew"
coordinate = { name = "z", unit = "m" }
drive = { gain = 300.0, unit = "A", limit = 20.0 }
control = { law = "cascade_p_pi", kp = 40.0, kv = 30.0, tn = 0.05, period = 1e-3 }
[parameters]
m = { unit = "kg", nominal = 60.0, lower = 0.0 }
b = { unit = "N/(m/s)", lower = 0.0 }
c = { unit = "N", lower = 0.0 }
fs = { unit = "N", lower = 0.0 }
[newton]
inertia = "m"
resistance = ["viscous(b, z)", "coulomb(c, z)", "stribeck(fs, z, velocity=0.01)", "gravity(m)"]
[experiment]
back_and_forth = { speeds = [0.02, 0.1, 0.3], acceleration = 3.0, seconds = 0.6, repeat = 2 }
truth = { m = 80.0, b = 300.0, c = 60.0, fs = 25.0 }
position_noise = 1e-6
"""


@pytest.mark.slow
def test_what_noise_moves_within_an_interval_is_a_remark(tmp_path: Path) -> None:
    (tmp_path / "screw.toml").write_text(_SCREW)
    axis, remarks = build(load_axis(tmp_path / "screw.toml")), 0
    for seed in range(200, 206):
        result = identify(axis, twin_record(axis, seed=seed), bootstrap=0)
        (check,) = (c for c in result.verdict if c.name == "least squares against instruments")
        moved = [b for b in result.diagnosis.noise_biases["idm-ls"].values() if b.moved]
        assert check.status == ("note" if moved else "pass")
        assert bool(moved) == ("holds the instruments' value all the same" in check.meaning)
        remarks += bool(moved)
    assert remarks


@pytest.mark.slow
def test_least_squares_alone_is_held_against_instruments(emps2015: GeneratedAxis) -> None:
    noisy = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(5e-6))
    quiet = Machine(mass=100.2, viscous=236.9, coulomb=24.8, control_noise=white(0.05))
    found = {}
    for name, machine in {"noisy": noisy, "quiet": quiet}.items():
        (columns,) = records(machine, _reference(), 1, 5)
        record = read_record(columns, emps2015)
        alone, all_of_it = (
            identify(emps2015, record, methods=["idm-ls"], bootstrap=0),
            identify(emps2015, record, bootstrap=0),
        )
        found[name] = alone
        ours, theirs = (r.diagnosis.noise_biases["idm-ls"]["M"] for r in (alone, all_of_it))
        assert ours.difference == pytest.approx(theirs.difference)
        assert ours.misses == theirs.misses
    noisy_check, quiet_check = (
        next(c for c in r.verdict if c.name == "least squares against instruments")
        for r in (found["noisy"], found["quiet"])
    )
    assert (noisy_check.status, quiet_check.status) == ("fail", "pass")
    assert "identify by instruments (idm-iv)" in noisy_check.meaning
    assert "moved by noise" in found["noisy"].summary()


@pytest.mark.slow
def test_least_squares_alone_says_why_nothing_is_told_without_a_reference(
    emps2015: GeneratedAxis,
) -> None:
    machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(5e-6))
    (columns,) = records(machine, _reference(), 1, 5)
    columns = {name: each for name, each in columns.items() if name != "reference"}
    result = identify(emps2015, read_record(columns, emps2015), methods=["idm-ls"])
    check = next(c for c in result.verdict if c.name == "least squares against instruments")
    assert check.status == "not evaluated"
    assert "no reference" in check.meaning
    assert result.diagnosis.noise_biases == {}
