"""A multisine added to the control, from a simulator apart from axisid: found, checked, missed."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Identification,
    Parameter,
    Record,
    build,
    identify,
    load_result,
    newton,
    read_record,
    simulate,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, coulomb, viscous
from axisid.estimation.diagnostics.control_law import (
    OtherGains,
    OtherInjectedSize,
    OtherTestSignal,
    law_agreement,
)
from axisid.estimation.findings import Finding
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration import back_and_forth
from benchmarks.machines import Machine, records, white
from tests.command_line import Run
from tests.files import csv_file
from tests.law_findings import law_finding_of, repair_of_law
from tests.refusals import refuses
from tests.run_files import run_file

TRUTH = {"M": 100.0, "Fv": 240.0, "Fc": 25.0}
MOVES = back_and_forth(speeds=(0.04, 0.12), acceleration=0.8, seconds=0.75, repeat=2)
REFERENCE = np.asarray(trajectory(MOVES, 1e-3))
QUIET = Machine(resolution=5e-8, control_noise=white(2e-3))
PLACES = {"control": 0.3, "reference": 4e-5}


def multisine(size: float) -> np.ndarray:
    time, rng = 1e-3 * np.arange(len(REFERENCE)), np.random.default_rng(3)
    waves = (np.sin(2 * np.pi * f * time + rng.uniform(0, 6)) for f in (2.0, 5.0, 9.0, 14.0, 23.0))
    return np.asarray(size * np.minimum(1.0, time / 0.5) * sum(waves))


@pytest.fixture(scope="module")
def stage() -> GeneratedAxis:
    q = Coordinate("q", unit="m")
    mass = Parameter("M", "kg", nominal=90.0, lower=0.0)
    fv, fc = Parameter("Fv", "N/(m/s)"), Parameter("Fc", "N")
    law = cascade_pd_difference(kp=QUIET.kp, kv=QUIET.kv, period=QUIET.period)
    return build(
        newton(
            "stage",
            coordinate=q,
            parameters=(mass, fv, fc),
            inertia=mass,
            resistance=(viscous(fv, q), coulomb(fc, q)),
            drive=Drive(gain=QUIET.gain, unit="V", limit=QUIET.limit),
            control=law,
        )
    )


@cache
def made(place: str, seed: int) -> dict[str, np.ndarray]:
    """Columns of a machine with a test signal, or of a quiet one."""
    injected = multisine(PLACES[place]) if place else None
    machine = replace(QUIET, injected=injected, injected_at=place or QUIET.injected_at)
    (columns,) = records(machine, REFERENCE, 1, seed)
    return columns


def driven(place: str, *, seed: int = 1) -> dict[str, np.ndarray]:
    return {**made(place, seed)}


def record_of(place: str, stage: GeneratedAxis, *, seed: int = 1) -> Record:
    return read_record(driven(place, seed=seed), stage, injected_at=place)


@pytest.fixture(scope="module")
def plain(stage: GeneratedAxis) -> Identification:
    """Of a record without a test signal."""
    return identify(stage, read_record(driven("", seed=4), stage))


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_instruments_give_the_truth_and_the_law_is_the_drives(
    place: str, stage: GeneratedAxis
) -> None:
    result = identify(stage, record_of(place, stage))
    estimate = result["idm-iv"]
    for name, value in estimate.parameters.items():
        low, high = value.interval
        assert low - 2e-3 * TRUTH[name] < TRUTH[name] < high + 2e-3 * TRUTH[name]
    assert estimate.simulation_error_percent < 1
    law = result.diagnosis.law
    assert law.passed
    assert law.residual_percent < 0.5


@pytest.mark.slow
def test_a_wrong_place_sign_or_size_is_told(stage: GeneratedAxis) -> None:
    right = record_of("control", stage)
    there = law_agreement(stage, replace(right, injected_at="reference"))
    assert repair_of_law(there, OtherTestSignal).change == "added to the control"
    opposite = law_agreement(stage, replace(right, injected=-right.injected))
    assert repair_of_law(opposite, OtherTestSignal).change == "opposite sign"
    for times in (7, 1.04):  # no unit is that of another
        law = law_agreement(stage, replace(right, injected=times * right.injected))
        assert not law.passed
        found = law_finding_of(law, Finding)
        is_told = isinstance(found, OtherGains) and found.injected_differs
        assert is_told or isinstance(found, OtherInjectedSize)


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_validation_reckons_with_it_and_misses_it(
    place: str, stage: GeneratedAxis, plain: Identification
) -> None:
    held = validate(plain, record_of(place, stage, seed=5))
    assert "the estimates hold" in str(held)
    assert held.to_dict()["holds"]
    columns = driven(place, seed=5)
    del columns["injected"]
    missed = validate(plain, read_record(columns, stage))
    said = " ".join(str(missed).split())
    assert "the estimates hold" not in said
    assert "does not hold" in said
    assert "injected" in said
    assert not missed.to_dict()["holds"]


@pytest.mark.slow
def test_the_command_line_takes_it_and_the_file_says_where_it_entered(
    run: Run, emps2015: GeneratedAxis, tmp_path: Path
) -> None:
    added = multisine(0.3)
    noise = np.random.default_rng(1).normal(scale=1e-6, size=len(REFERENCE))
    given = {"position_noise": noise, "injected": added}
    loop = simulate(emps2015, emps2015.nominal, REFERENCE, 1e-3, **given)  # type: ignore[arg-type]
    columns = {"time": loop.time, "reference": REFERENCE, "position": loop.measured_position}
    columns |= {"control": loop.control, "exc": added}
    file, out = csv_file(tmp_path / "log.csv", columns), tmp_path / "result.json"
    own = run_file(file, columns={"injected": "exc"}, injected_at="control")
    code, text, err = run("identify", "emps2015", own, "--json", out)
    assert (code, err) == (0, "")
    assert "'exc' was added to the control" in " ".join(text.split())
    written = json.loads(out.read_text())
    assert written["record"]["injected_at"] == "control"
    assert written["law_check"]["passed"]
    saved = load_result(out, axis=emps2015.axis)
    assert saved.record.injected_at == "control"
    again = read_record(file, emps2015, columns={"injected": "exc"}, injected_at="control")
    assert "holds" in saved.validate(again).to_dict()


def test_a_twin_has_the_signal_that_it_is_given(emps2015: GeneratedAxis) -> None:
    plain = twin_record(emps2015)
    added = 0.2 * np.sin(2 * np.pi * 11 * plain.time)
    twin = twin_record(emps2015, injected=added, injected_at="control")
    assert twin.injected_at == "control"
    law = law_agreement(emps2015, twin)
    assert law.factors["injected"] == pytest.approx(1.0, abs=0.05)
    moved = twin_record(emps2015, injected=1e-5 * added, injected_at="reference")
    np.testing.assert_allclose(moved.commanded, moved.reference + 1e-5 * added)
    with refuses("test-signal", says="None"):
        twin_record(emps2015, injected=added)
