"""Why a record does not show a parameter: motions that lack one thing each."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    identify,
    simulate,
    twin_record,
)
from axisid.control import cascade_pd
from axisid.elements import Drive, offset, spring
from axisid.estimation.checks.check import Check
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Experiment, Move, back_and_forth
from tests.axes.bodies import k, stage, x

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
    (check,) = (c for c in result.verdict if c.name == "precision")
    return check


@pytest.mark.slow
def test_rich_motion_lacks_nothing() -> None:
    result = moved(*ALL)
    for shown in result.diagnosis.excitation:
        assert shown.lacking == ()
        assert shown.alike == ()
    assert precision(result).status == "pass"


@pytest.mark.slow
def test_shares_are_the_parts_of_the_force() -> None:
    result = moved(*ALL)
    estimate = result["idm-iv"]
    parts = np.linalg.norm(estimate.X * estimate.physical, axis=0) / np.linalg.norm(estimate.y)
    assert [e.share for e in result.diagnosis.excitation] == pytest.approx(parts.tolist())


def test_inflation_is_that_of_the_inverse_correlation() -> None:
    """Uncentred variance inflation: the diagonal of the inverse of the columns' cosines."""
    result = moved(*ALL)
    unit = result["idm-iv"].X / np.linalg.norm(result["idm-iv"].X, axis=0)
    expected = np.diag(np.linalg.inv(unit.T @ unit))
    assert [e.inflation for e in result.diagnosis.excitation] == pytest.approx(
        expected.tolist(), rel=1e-6
    )


@pytest.mark.slow
def test_motion_with_hardly_a_reversal_trades_coulomb_friction_for_the_offset() -> None:
    back = Move(-0.004, 0.05, 4.0)
    result = moved(Move(0.1, 0.1, 2.0), Move(0.2, 0.2, 2.0), back, disturbance=20.0)
    shown = {e.name: e for e in result.diagnosis.excitation}
    assert "f" in shown["c"].alike
    assert precision(result).status != "pass"
    assert "f is not identified" in precision(result).meaning


def test_one_speed_trades_viscous_for_coulomb_friction() -> None:
    result = moved(*back_and_forth(speeds=(0.1,), acceleration=50.0, seconds=1.0, repeat=3))
    shown = {e.name: e for e in result.diagnosis.excitation}
    assert "there is one speed only" in shown["b"].lacking
    assert "there is one speed only" not in shown["f"].lacking


@pytest.mark.slow
def test_slow_motion_does_not_show_the_mass() -> None:
    creep = back_and_forth(speeds=(0.005, 0.01, 0.02), acceleration=0.02, seconds=2.0)
    result = moved(*creep, disturbance=5.0)
    (shown,) = (e for e in result.diagnosis.excitation if e.name == "m")
    assert shown.share < 0.05
    assert shown.lacking == ("the axis hardly accelerates",)
    assert precision(result).status != "pass"
    assert "m is not identified" in precision(result).meaning


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
    assert shown.lacking == ("the axis hardly leaves its place",)
