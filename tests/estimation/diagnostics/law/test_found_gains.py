"""A law with gains that a fit has found is held against the control as surely as they are known."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import norm, t as student

from axisid import Record, build, fit, load_axis, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics.law import FoundGains, LawCheck, check_found_law
from axisid.estimation.diagnostics.law.control_law import apart_in_deviations
from axisid.estimation.fitting import OutputFit
from tests.axes.ready_laws import with_law

P_PI = "cascade_p_pi"
ALL = ("kp", "kv", "tn")


@cache
def _axis(name: str) -> GeneratedAxis:
    axis = load_axis("emps2015") if name == "emps2015" else with_law(name, 10.0).axis
    return build(axis)


@cache
def _record(name: str, **changes: int | float) -> Record:
    """A twin under a law with other gains, as factors, or another delay."""
    axis = _axis(name).axis
    law = axis.control
    gains = {n: value * changes.get(n, 1.0) for n, value in law.gains.items()}
    law = replace(law, gains=gains, delay=law.delay + int(changes.get("delay", 0)))
    made = build(replace(axis, control=law))
    return twin_record(made, seed=100, position_noise=1e-6)


def _found(name: str, sd: float, **off: float) -> tuple[GeneratedAxis, FoundGains]:
    """An axis with gains that are off by such factors, each known to a share of itself."""
    law = _axis(name).axis.control
    gains = {n: law.gains[n] * factor for n, factor in off.items()}
    deviations = sd * np.array([*gains.values()])
    return _axis(name).with_gains(gains), FoundGains(tuple(gains), np.diag(deviations**2), math.inf)


def _checked(name: str, sd: float, record: Record, **off: float) -> LawCheck:
    return check_found_law(_found(name, sd, **off)[0], record, _found(name, sd, **off)[1])


@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_gains_off_by_what_they_are_unsure_of_leave_a_right_law_right(name: str) -> None:
    check = _checked(name, 0.02, _record(name), kp=1.03, kv=0.98)
    assert check.passed, check.sentence
    assert "joint deviations" in check.meaning
    assert all(abs(factor - 1) < 1e-3 for factor in check.factors.values())


@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_gains_far_from_those_of_the_control_are_told(name: str) -> None:
    check = _checked(name, 0.002, _record(name), kp=1.03, kv=0.98)
    assert not check.passed
    assert check.found_apart
    assert "the fit finds" in check.meaning


def test_gains_off_by_less_than_matters_are_right_however_sure() -> None:
    assert _checked("emps2015", 1e-4, _record("emps2015"), kp=1.005, kv=0.995).passed


@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_a_wrong_gain_that_is_held_is_named(name: str) -> None:
    check = _checked(name, 0.02, _record(name, kv=1.1), kp=1.0)
    assert not check.passed
    law = _axis(name).axis.control
    assert f" for {law.gains['kv']:.5g}" in check.meaning
    said = float(check.meaning.split("with kv ")[1].split()[0])
    assert said == pytest.approx(1.1 * law.gains["kv"], rel=1e-3)
    assert "let kv be free too" in check.meaning


def test_a_law_that_no_gains_make_the_controls_fails() -> None:
    late = _checked(P_PI, 0.02, _record(P_PI, delay=2), kp=1.0, kv=1.0, tn=1.0)
    assert not late.passed
    assert late.meaning.startswith("with the kp and kv and tn that suit best, ")


@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_a_flipped_control_is_named_whatever_gains_are_free(name: str) -> None:
    record = _record(name)
    check = _checked(name, 0.02, replace(record, control=-record.control), kp=1.1, kv=0.9)
    assert not check.passed
    assert "its sign is opposite to the law's" in check.meaning
    law = _axis(name).axis.control
    assert f"by kp {law.gains['kp']:.3g}" in check.meaning
    assert check.advice == ""
    assert check.factors == {}


def test_the_distance_is_that_of_a_normal_of_one_dimension() -> None:
    assert apart_in_deviations(np.array([3.0]), np.array([[1.0]]), math.inf) == pytest.approx(3.0)
    two = apart_in_deviations(np.array([3.0, 0.0]), np.eye(2), math.inf)
    assert 2.0 < two < 3.0
    assert apart_in_deviations(np.array([3.0, 9.0]), np.diag([1.0, np.inf]), math.inf) == (
        pytest.approx(3.0)
    )
    assert apart_in_deviations(np.array([1.0]), np.array([[0.0]]), math.inf) == 0
    few = apart_in_deviations(np.array([3.0]), np.array([[1.0]]), 16.0)
    assert few == pytest.approx(-norm.ppf(student.sf(3.0, 16)))


def _fitted(name: str, seed: int, free: tuple[str, ...]) -> OutputFit:
    record = twin_record(_axis(name), seed=seed, position_noise=1e-6)
    return fit(_axis(name), record.windowed((None, 2.0)), free=free)


@pytest.mark.parametrize("seed", [100, 101])
@pytest.mark.parametrize(("name", "free"), [("emps2015", ("kp", "kv")), (P_PI, ALL)])
def test_right_fits_with_free_gains_are_believed(
    name: str, free: tuple[str, ...], seed: int
) -> None:
    found = _fitted(name, seed, free)
    assert found.believed, [check for check in found.checks if check.status == "fail"]
    assert found.found_gains.names == free
