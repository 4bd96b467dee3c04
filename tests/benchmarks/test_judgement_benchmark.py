"""The machines of the study of judgements move as the axes that are declared of them."""

import json
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import simulate
from benchmarks.machines import Machine, autoregressive, records, white

study: Any = import_module("judgement")
cases: Any = import_module("judged_cases")


@pytest.mark.slow
@pytest.mark.parametrize("weight", [0.0, 150.0])
def test_a_machine_moves_as_its_axis_is_simulated(weight: float) -> None:
    machine = Machine(offset=weight, coulomb=40.0)
    reference = cases.reference_of("moves")[:1500]
    axis = cases.declared(has_offset=bool(weight))
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb, "F0": weight}
    loop = simulate(axis, [truth[name] for name in axis.names], reference, machine.period)
    (columns,) = records(machine, reference, 1, seed=1)
    np.testing.assert_allclose(columns["position"], loop.position, atol=1e-8)
    np.testing.assert_allclose(columns["control"], loop.control, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "machine",
    [
        Machine(kp=25.0, kv=150.0, tn=0.05),
        Machine(kp=1200.0, ki=4000.0, kd=80.0),
        Machine(kp=15.0, kv=100.0, tn=0.1, period=5e-3),
    ],
    ids=["P-PI", "PID", "P-PI, 5 ms"],
)
def test_a_machine_under_each_law_moves_and_rests_as_its_axis_is_simulated(
    machine: Machine,
) -> None:
    reference = cases.reference_of("dwells", machine.period)[: round(3.2 / machine.period)]
    axis = cases.declared(has_offset=False, gains=cases.Gains.of(machine))
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb}
    loop = simulate(axis, [truth[name] for name in axis.names], reference, machine.period)
    (columns,) = records(machine, reference, 1, seed=1)
    np.testing.assert_allclose(columns["position"], loop.position, atol=1e-7)


@pytest.mark.slow
def test_what_a_machine_has_besides_moves_it() -> None:
    plain = Machine()
    others = (
        replace(plain, mass_at=lambda time: 110.0 if time > 0.02 else 100.0),
        replace(plain, resistance=lambda _, __, v: 10.0 * np.abs(v)),
        replace(plain, force_noise=white(1.0)),
        replace(plain, resolution=1e-5),
        replace(plain, kp=170.0),
    )
    reference = study.reference_of("moves")[:500]
    (own,) = records(plain, reference, 1, seed=1)
    for other in others:
        (columns,) = records(other, reference, 1, seed=1)
        assert np.abs(columns["position"] - own["position"]).max() > 1e-7


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "load behind a spring, 12 Hz",
        "load behind a spring, 35 Hz",
        "cogging of 5 mm",
        "friction every 20 mm",
        "Stribeck peak",
    ],
)
def test_a_load_that_swings_and_waves_are_named_with_frequency_and_period(name: str) -> None:
    assert study.figures_of(name, runs=1, seed=3).named == 1


def test_autoregressive_noise_has_its_deviation_and_its_time(rng: np.random.Generator) -> None:
    noise = autoregressive(2.0, 0.05, 1e-3)(rng, 200, 2000)
    assert noise.std() == pytest.approx(2.0, rel=0.05)
    assert noise[:, 0].std() == pytest.approx(2.0, rel=0.2)
    shared = np.mean(noise[:, 50:] * noise[:, :-50]) / noise.var()
    assert shared == pytest.approx(np.exp(-1), abs=0.05)


def test_what_is_out_of_its_aim_by_more_than_chance_is_listed() -> None:
    right = {
        "runs": 50,
        "failed": {"alignment": 0.08, "precision": 1.0, "excitation": 0.02},
        "rightly": ["precision"],
        "held": {"M": 0.94, "Fv": 0.8},
    }
    missed = [(miss.what, miss.aim) for miss in study.misses("right", "sines", right)]
    assert missed == [("alignment", 0.02), ("interval of Fv", 0.93)]
    assert [miss.what for miss in study.misses("kept", "sines", right)] == ["alignment"]
    wrong = {"runs": 50, "failed": {"alignment": 1.0}, "noticed": 1.0, "named": 0.98}
    assert not [*study.misses("wrong", "spring", wrong)]
    (miss,) = study.misses("wrong", "spring", wrong | {"named": 0.8})
    assert str(miss) == "wrong, spring: named 80 %, 95 %"


@pytest.mark.slow
def test_study_counts_the_runs_of_a_right_and_of_a_wrong_case(root: Path) -> None:
    assert not set(study.RIGHT) & set(study.WRONG)
    for name, kind, of_all in (
        ("2 s of it", "right", "held"),
        ("missing offset", "wrong", "named"),
    ):
        command = [sys.executable, "benchmarks/judgement.py", "--runs", "2", "--only", name]
        told = subprocess.run(
            [*command, "--json", "-"], cwd=root, capture_output=True, text=True, check=True
        )
        shares = json.loads(told.stdout)[kind][name]
        assert shares["runs"] == 2
        assert of_all in shares


@pytest.mark.parametrize(
    ("name", "missing"),
    [("no Coulomb friction declared", "Fc"), ("no viscous friction declared", "Fv")],
)
def test_what_is_not_declared_is_no_parameter(name: str, missing: str) -> None:
    axis = cases.axis_of(cases.CASES[name])
    assert {"M", "Fv", "Fc"} - set(axis.names) == {missing}


def test_a_load_behind_a_spring_swings_at_its_frequency_and_is_carried_along() -> None:
    """Beside a free axis, as two masses do, and with nothing lost that nothing takes."""
    free = Machine(
        viscous=0.0, coulomb=0.0, kp=0.0, kv=0.0, load=40.0, antiresonance=35.0, load_damping=0.0
    )
    push = replace(free, injected=np.where(np.arange(2000) < 40, 5.0, 0.0))
    (columns,) = records(push, np.zeros(2000), 1, seed=1)
    velocity = np.gradient(columns["position"], 1e-3)[60:]
    expected = 0.04 * 5.0 * push.gain / push.mass
    assert velocity.mean() == pytest.approx(expected, rel=0.01)
    swing = np.abs(np.fft.rfft((velocity - velocity.mean()) * np.hanning(len(velocity)), 1 << 16))
    frequency = np.fft.rfftfreq(1 << 16, 1e-3)[np.argmax(swing)]
    assert frequency == pytest.approx(35.0 * np.sqrt(100 / 60), rel=0.01)
