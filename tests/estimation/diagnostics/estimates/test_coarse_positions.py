"""Logs without a reference: positions with steps, and noise that least squares is told about."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, identify, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check
from benchmarks.machines import Machine, records, white

STAGE = Machine(mass=100.2, viscous=236.9, coulomb=24.8, control_noise=white(2e-3))


def _reference() -> np.ndarray:
    time = 1e-3 * np.arange(8000)
    waves = 0.02 * np.sin(2 * np.pi * 0.5 * time) + 0.004 * np.sin(2 * np.pi * 1.9 * time)
    return np.minimum(1.0, time / 0.5) * waves


def _without_reference(
    axis: GeneratedAxis, machine: Machine, step: float = 0.0, late: int = 0, seed: int = 5
) -> Identification:
    (columns,) = records(machine, _reference(), 1, seed)
    position, control = columns["position"], np.roll(columns["control"], late)
    if step:
        position = step * np.round(position / step)
    return identify(
        axis,
        read_record({"time": columns["time"], "position": position, "control": control}, axis),
    )


def _checks(result: Identification) -> dict[str, Check]:
    return {check.name: check for check in result.verdict}


def _failed(result: Identification) -> list[str]:
    return [check.name for check in result.verdict if check.status == "fail"]


@pytest.mark.slow
def test_steps_that_the_log_alone_has_are_named_with_what_they_move(
    emps2015: GeneratedAxis,
) -> None:
    result = _without_reference(emps2015, STAGE, step=0.045 / 2**10)
    mass = result["idm-ls"].parameters["M"]
    assert mass.value < 0.99 * 100.2
    assert _failed(result) == ["coarse positions"]
    check = _checks(result)["coarse positions"]
    assert "4.39e-05 m" in check.meaning
    told = float(check.meaning.split("M by about ")[1].split()[0])
    assert told == pytest.approx(mass.value - 100.2, rel=0.35)


@pytest.mark.slow
def test_a_few_steps_are_more_than_can_be_reckoned(emps2015: GeneratedAxis) -> None:
    result = _without_reference(emps2015, STAGE, step=0.045 / 30)
    assert "coarse positions" in _failed(result)
    assert "fewer than 64 in the whole motion" in _checks(result)["coarse positions"].meaning


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.0, 1e-8])
def test_fine_positions_are_no_fault(emps2015: GeneratedAxis, step: float) -> None:
    result = _without_reference(emps2015, STAGE, step=step)
    assert "coarse positions" not in _failed(result)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1e-6, 5e-6])
def test_noise_that_is_reckoned_with_is_no_fault_of_timing_or_model(
    emps2015: GeneratedAxis, noise: float
) -> None:
    result = _without_reference(emps2015, replace(STAGE, position_noise=white(noise)))
    assert _failed(result) == []
    mass = result["idm-ls"].parameters["M"]
    assert abs(mass.corrected - 100.2) < 0.006 * 100.2
    assert not _checks(result)["alignment"].meaning.endswith("which noise may bias)")


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1e-6, 5e-6])
def test_a_control_that_is_logged_late_is_told_all_the_same(
    emps2015: GeneratedAxis, noise: float
) -> None:
    late = _without_reference(emps2015, replace(STAGE, position_noise=white(noise)), late=2)
    assert {"alignment", "missing terms"} & {*_failed(late)}
