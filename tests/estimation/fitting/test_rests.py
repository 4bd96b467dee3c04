"""Fits of machines that rest: what has weight, and that intervals hold the truth."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import build, fit, load_axis, read_record, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.fitting import OutputFit
from axisid.estimation.records import Record
from axisid.modeling import Move, back_and_forth
from benchmarks.machines import records
from tests.axes.remembering import dahl_axis
from tests.refusals import refuses

Run = Callable[..., tuple[int, str, str]]
cases: Any = import_module("judged_cases")
TRUTH = ("M", "Fv", "Fc")


def dwelling(moves: tuple[Move, ...], resolution: float = 2e-6) -> tuple[GeneratedAxis, Record]:
    """The paper's axis behind an encoder, and its record."""
    axis = load_axis("emps2015")
    assert axis.experiment is not None
    experiment = replace(axis.experiment, moves=moves, resolution=resolution, position_noise=0.0)
    generated = build(replace(axis, experiment=experiment))
    return generated, twin_record(generated)


@pytest.fixture(scope="module")
def dwells() -> tuple[GeneratedAxis, Record]:
    return dwelling(
        back_and_forth(speeds=(0.05, 0.1), acceleration=0.75, seconds=0.4, dwell=0.4, repeat=2)
    )


def far(found: OutputFit, record: Record) -> list[float]:
    """How far each parameter is from its true value, %."""
    return [100 * abs(found[n].value / record.provenance.truth[n] - 1) for n in found.names]


def note(found: OutputFit) -> Any:
    return next((each for each in found.checks if each.name == "samples near rests"), None)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_rests_behind_an_encoder_bias_no_fit(
    dwells: tuple[GeneratedAxis, Record], output: str
) -> None:
    axis, record = dwells
    found, kept = (fit(axis, record, output, rests=rests) for rests in ("leave-out", "keep"))
    assert max(far(found, record)) < 0.5
    assert max(far(found, record)) < max(far(kept, record)) / 3


@pytest.mark.slow
def test_the_share_without_weight_is_told(dwells: tuple[GeneratedAxis, Record]) -> None:
    axis, record = dwells
    found = fit(axis, record)
    (of_record,) = found.of_records
    assert note(found).status == "note"
    assert note(found).figure == pytest.approx(1 - of_record.rows / len(record))
    assert 0.2 < note(found).figure < 0.6
    kept = fit(axis, record, rests="keep")
    assert kept.of_records[0].rows == len(record)
    assert note(kept) is None


@pytest.mark.slow
def test_short_moves_of_which_too_little_is_left_keep_their_samples() -> None:
    axis, record = dwelling((Move(2e-3, 0.1, 2.0, 0.05), Move(-2e-3, 0.1, 2.0, 0.05)) * 20)
    found = fit(axis, record)
    assert found.of_records[0].rows == len(record)
    assert note(found).status == "note"
    assert note(found).figure == 0


@pytest.mark.slow
def test_friction_that_remembers_is_shown_near_rests_and_keeps_them() -> None:
    axis = build(dahl_axis())
    record = twin_record(axis)
    assert fit(axis, record).of_records[0].rows == len(record)


def test_a_choice_that_is_none_is_refused(dwells: tuple[GeneratedAxis, Record]) -> None:
    with refuses("fit-choice"):
        fit(*dwells, rests="drop")


def test_rests_are_kept_from_the_command_line(run: Run, tmp_path: Any) -> None:
    log, moves = (
        tmp_path / "twin.csv",
        ("--speed", "0.05", "--acceleration", "0.75", "--dwell", "0.2"),
    )
    assert run("twin", "emps2015", "--output", log, *moves)[0] == 0
    assert "samples near rests" in run("fit", "emps2015", log)[1]
    assert "samples near rests" not in run("fit", "emps2015", log, "--rests", "keep")[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dwells, 2 um", "P-PI, dwells, 1 um"])
@pytest.mark.parametrize("output", ["control", "position", "open-loop"])
def test_intervals_hold_the_truth_of_machines_that_rest(name: str, output: str) -> None:
    """By a simulator of its own; with rests 0 of 6 hold Fv and Fc of the first by control."""
    case = cases.FIELD[name]
    axis, machine = cases.axis_of(case), case.machine
    true = np.array([machine.mass, machine.viscous, machine.coulomb])
    away = []
    for columns in records(machine, cases.reference_of(case.motion, machine.period), 4, seed=5):
        found = fit(axis, read_record(columns, axis), output)
        away.append(
            [(found[n].value - t) / found[n].deviation for n, t in zip(TRUTH, true, strict=True)]
        )
    assert np.sqrt(np.mean(np.square(away))) < 1.7
    assert np.abs(away).max() < 4
