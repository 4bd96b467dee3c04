"""Parameters against motions that lack one thing each."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    simulate,
    twin_record,
)
from axisid.control import cascade_pd
from axisid.elements import Drive, offset, spring
from axisid.estimation.diagnostics import Precision
from axisid.estimation.diagnostics.model_error_checks import SimulatedLoop
from axisid.estimation.simulation.twin import trajectory
from axisid.estimation.verdict_checks import Check
from axisid.modeling import Experiment, Move, back_and_forth
from tests.axes.bodies import k, stage, x
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

PERIOD = 1e-3
f = Parameter("f", "N")
TRUTH = {"m": 5.0, "b": 20.0, "c": 4.0, "f": 3.0, "k": 50.0}
STAGE = stage(
    offset(f),
    spring(k, x),
    parameters=(f, k),
    drive=Drive(gain=1.0, unit="N"),
    control=cascade_pd(kp=60.0, kv=600.0, period=PERIOD),
)
ALL = back_and_forth(speeds=(0.05, 0.1, 0.2), acceleration=2.0, seconds=0.5, repeat=2)


def moved(*moves: Move, disturbance: float = 0.0) -> Identification:
    """The stage after a motion; a disturbance of the recorded force, N, leaves LS unbiased."""
    axis = build(
        replace(STAGE, experiment=Experiment(moves=moves, truth=TRUTH, position_noise=1e-7))
    )
    record = twin_record(axis)
    noise = np.random.default_rng(6).normal(0.0, disturbance, len(record))
    record = replace(record, control=record.control + noise)
    return identify(axis, record, methods=["idm-ls", "idm-iv"])


def precision(result: Identification) -> Check:
    return checks_of(result)["precision"]


@pytest.mark.slow
def test_rich_motion_lacks_nothing_and_its_figures_are_those_of_the_columns() -> None:
    """Shares of the force, and the diagonal of the inverse of the columns' cosines."""
    result = moved(*ALL)
    shown, estimate = result.diagnosis.excitation, result["idm-iv"]
    assert not any(each.lacking or each.alike for each in shown)
    assert precision(result).status == "pass"
    parts = np.linalg.norm(estimate.X * estimate.physical, axis=0) / np.linalg.norm(estimate.y)
    assert [each.share for each in shown] == pytest.approx(parts.tolist())
    unit = estimate.X / np.linalg.norm(estimate.X, axis=0)
    expected = np.diag(np.linalg.inv(unit.T @ unit))
    assert [each.inflation for each in shown] == pytest.approx(expected.tolist(), rel=1e-6)


@pytest.mark.slow
def test_a_mass_that_is_none_beside_a_known_one_is_no_lack_of_acceleration() -> None:
    added = Parameter("m_add", "kg", nominal=1.0)
    truth = {**TRUTH, "m_add": 0.0}
    axis = stage(
        *(offset(f), spring(k, x), added * x.acceleration),
        parameters=(f, k, added),
        drive=STAGE.drive,
        control=STAGE.control,
        experiment=Experiment(moves=ALL, truth=truth, position_noise=1e-7),
    )
    records = [twin_record(build(axis), seed=seed) for seed in (1, 2)]
    result = identify(axis, records, methods="idm-iv", known={"m": [truth["m"]] * 2})
    assert not any(each.lacking for each in result.diagnosis.excitation)
    assert precision(result).status == "pass"
    found = finding_of(precision(result), Precision)
    assert [each.name for each in found.negligible] == ["m_add"]


FORWARD = (Move(0.1, 0.1, 2.0), Move(0.2, 0.2, 2.0), Move(-0.004, 0.05, 4.0))


@pytest.mark.parametrize(
    ("moves", "disturbance", "name", "alike", "lacking", "vague"),
    [
        pytest.param(FORWARD, 20.0, "c", "f", None, "f", marks=pytest.mark.slow),
        (
            back_and_forth(speeds=(0.1,), acceleration=50.0, seconds=1.0, repeat=3),
            *(0.0, "b", None, "the axis has one cruising speed only", None),
        ),
        pytest.param(
            back_and_forth(speeds=(0.005, 0.01, 0.02), acceleration=0.02, seconds=2.0),
            *(5.0, "m", None, "the axis hardly accelerates", "m"),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["hardly a reversal", "one speed", "slow"],
)
def test_what_a_motion_lacks_is_told_of_the_parameter_that_it_hides(
    moves: tuple[Move, ...],
    disturbance: float,
    name: str,
    alike: str | None,
    lacking: str | None,
    vague: str | None,
) -> None:
    result = moved(*moves, disturbance=disturbance)
    shown = {each.name: each for each in result.diagnosis.excitation}
    assert alike is None or alike in shown[name].alike
    assert lacking is None or lacking in shown[name].lacking
    assert lacking not in shown["f"].lacking
    found = finding_of(precision(result), Precision).unidentified
    assert vague is None or vague in [each.name for group in found for each in group.parameters]


@pytest.mark.slow
def test_axis_that_stays_in_place_does_not_show_a_far_spring() -> None:
    """1 m from its rest a spring of 50 N/m is a constant of 50 N."""
    reference = 1.0 + trajectory(
        back_and_forth(speeds=(0.02, 0.04), acceleration=1.0, seconds=0.3, repeat=3), PERIOD
    )
    axis = build(STAGE)
    loop = simulate(axis, list(TRUTH.values()), reference, PERIOD)
    record = Record(
        time=loop.time, position=loop.position, reference=reference, control=loop.control
    )
    kept = Prefilter(reversals="keep")
    (shown,) = (e for e in identify(axis, record, kept).diagnosis.excitation if e.name == "k")
    assert shown.alike == ("f",)
    assert shown.lacking == ("the axis hardly changes its position",)


@pytest.mark.slow
def test_a_weight_that_the_model_lacks_is_blamed_for_the_loop_and_hides_each_parameter() -> None:
    truth = {**TRUTH, "f": 60.0, "k": 0.0}
    weighed = replace(STAGE, experiment=Experiment(moves=ALL, truth=truth, position_noise=1e-7))
    axis = build(stage(drive=STAGE.drive, control=STAGE.control))
    result = identify(axis, twin_record(build(weighed)))
    simulation = checks_of(result)["simulation"]
    assert simulation.status == "fail"
    assert finding_of(simulation, SimulatedLoop).is_misspecified
    (group,) = finding_of(precision(result), Precision).unidentified
    assert [each.name for each in group.parameters] == ["m", "b", "c"]
    assert group.reason == "below residual"
