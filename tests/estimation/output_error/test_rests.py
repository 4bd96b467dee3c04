"""Fits of machines that rest, of friction that remembers, of a time of the drive."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import (
    Parameter,
    Record,
    build,
    fit,
    load_axis,
    load_result,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import dahl
from axisid.estimation.output_error import OutputFit
from axisid.estimation.output_error.fit_findings import OpenLoopWindows
from axisid.modeling import Move, back_and_forth
from axisid.support.arrays import Array
from benchmarks.machines import Machine, white
from tests.axes.remembering import CASCADE, Fc, bristle, declared, virtual, x
from tests.command_line import Run
from tests.estimation.output_error.fits import looped, off
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

field: Any = import_module("field")
PUSHED = Machine(resolution=5e-8, force_noise=white(3.0))


def dwelling(moves: tuple[Move, ...], resolution: float = 2e-6) -> tuple[GeneratedAxis, Record]:
    """The paper's axis behind an encoder, and its record."""
    axis = load_axis("emps2015")
    experiment = replace(axis.experiment, moves=moves, resolution=resolution, position_noise=0.0)
    generated = build(replace(axis, experiment=experiment))
    return generated, twin_record(generated)


@pytest.fixture(scope="module")
def dwells() -> tuple[GeneratedAxis, Record]:
    return dwelling(
        back_and_forth(speeds=(0.05, 0.1), acceleration=0.75, seconds=0.4, dwell=0.4, repeat=2)
    )


def note(found: OutputFit) -> Any:
    return checks_of(found).get("samples near rests")


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_rests_behind_an_encoder_bias_no_fit_and_their_share_is_told(
    dwells: tuple[GeneratedAxis, Record], output: str
) -> None:
    axis, record = dwells
    truth = np.array([*record.provenance.truth.values()])
    found, kept = (fit(axis, record, output, rests=rests) for rests in ("leave-out", "keep"))
    far, kept_far = (np.abs(each.physical / truth - 1).max() for each in (found, kept))
    assert far < min(0.005, kept_far / 3)
    assert note(found).status == "note"
    assert note(found).figure == pytest.approx(1 - found.of_records[0].rows / len(record))
    assert 0.2 < note(found).figure < 0.6
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
def test_rests_are_kept_from_the_command_line(run: Run, tmp_path: Any) -> None:
    log, moves = tmp_path / "twin.csv", ("--speed", "0.05", "--dwell", "0.2")
    run("twin", "emps2015", "--output", log, "--acceleration", "0.75", *moves)
    for rests, is_noted in ((), True), (("--rests", "keep"), False):
        file = tmp_path / f"fit{is_noted}.json"
        run("fit", "emps2015", log, *rests, "--json", file)
        assert ("samples near rests" in checks_of(load_result(file))) is is_noted


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "output", "count"),
    [
        (field.FIXED["PD, 2 um, dwells, force of 20 ms"], "control", 2),
        (field.FIXED["PD, 2 um, dwells, force of 20 ms"], "position", 2),
        (field.FIXED["P-PI, 1 um, dwells"], "control", 2),
        (
            field.Case(machine=PUSHED, declared=PUSHED, motion=field.Motion("trapezoids")),
            "open-loop",
            12,
        ),
    ],
)
def test_deviations_are_right_of_machines_that_rest_or_are_pushed(
    case: Any, output: str, count: int
) -> None:
    """By a simulator of its own.

    They were three times too small with samples at rest, and in open loop by an autoregression in
    place of the scatter over windows.
    """
    found = [fit(case.axis, record, output) for record in case.records(count, 5)]
    assert np.sqrt(np.mean([off(each, case.truth) ** 2 for each in found])) < 1.7


@pytest.mark.slow
def test_few_windows_are_not_believed_and_shorter_ones_are_named(
    dwells: tuple[GeneratedAxis, Record],
) -> None:
    found = fit(*dwells, "open-loop", horizon=1.0)
    windows = finding_of(checks_of(found)["windows"], OpenLoopWindows)
    assert windows.state == "few"
    assert windows.windows < windows.advised_windows


def _record(axis: GeneratedAxis, theta: Array, *, noise: float, samples: int) -> Record:
    """A record of a swing whose frequency grows, each turn followed by a wiggle of micrometres."""
    time = axis.axis.control.period * np.arange(samples)  # type: ignore[union-attr]
    slow = 2e-3 * np.sin(2 * np.pi * (0.5 * time + 0.6 * time**2))
    held = np.floor(time / 0.5) % 3 == 2
    last = np.maximum.accumulate(np.where(held, 0, np.arange(samples)))
    reference = slow[last] + np.where(held, 1e-5 * np.sin(4 * np.pi * time), 0.0)
    record, _ = looped(axis, theta, reference, noise, seed=1)
    return record


@pytest.mark.parametrize(
    ("by", "code", "asked"),
    [
        (identify, "equation", {}),
        (fit, "equation", {"output": "open-loop"}),
        (fit, "free", {"free": "lag"}),
        (fit, "simulation", {"start": {"s0": 1e12}}),
    ],
)
def test_what_friction_that_remembers_does_not_serve_is_refused(
    by: Callable[..., object], code: str, asked: dict[str, Any]
) -> None:
    axis = virtual("dahl")
    record = _record(axis, axis.nominal, noise=0.0, samples=50)
    with refuses(code):
        by(axis, record, **asked)
    unknown = Parameter("s0", "N/m", lower=0.0)
    unsized = build(declared("unsized", (unknown, Fc), dahl(unknown, x, coulomb=Fc)))
    with refuses("fit"):
        fit(unsized, record)


@pytest.mark.slow
def test_the_parameters_of_a_bristle_lie_within_their_own_intervals() -> None:
    axis = build(bristle(control=CASCADE))
    truth = axis.nominal * [0.9, 1.25, 0.8, 1.1, 0.9, 1.1, 0.8]
    result = fit(axis, _record(axis, truth, noise=2e-9, samples=4000))
    assert result.started == "nominal"
    assert "internal state" in result.remarks[0]
    low, high = np.transpose([each.interval for each in result.parameters.values()])
    assert np.all((low <= truth) & (truth <= high))
    assert np.all(result.deviations < 1e-3 * truth)
    assert not [check for check in result.checks if check.status == "fail"]
    # In the rows of friction that remembers nothing can be looked for.
    assert [check.name for check in result.checks if check.leaves_open] == ["missing terms"]
    assert result.of_records[0].rows == 4000  # friction that remembers is shown near rests


@pytest.mark.slow
def test_a_delay_is_found_without_a_law(emps2015: GeneratedAxis, twin: Record) -> None:
    axis = build(replace(emps2015.axis, control=None))
    found = fit(axis, twin.windowed((None, 1.5)), "open-loop", free="delay", start="nominal")
    assert abs(found["delay"].value) < 4 * found["delay"].deviation + 1e-6
    assert found["delay"].deviation < 1e-4
