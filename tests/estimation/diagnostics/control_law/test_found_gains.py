"""A law with gains that a fit has found is held against the control as surely as they are known."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import norm, t as student

from axisid import Record, build, fit, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.control_law import (
    EstimatedGains,
    FoundGainsAgree,
    FoundGainsDiffer,
    LateControl,
    LawAgreement,
    OtherGains,
    OtherScale,
    found_law_agreement,
)
from axisid.estimation.diagnostics.control_law.law_agreement import apart_in_deviations
from tests.axes.ready_laws import with_law
from tests.law_findings import law_finding_of

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


def _checked(name: str, sd: float, record: Record, **off: float) -> LawAgreement:
    """By an axis with gains that are off by such factors, each known to a share of itself."""
    gains = {n: _axis(name).axis.control.gains[n] * factor for n, factor in off.items()}
    found = EstimatedGains(tuple(gains), np.diag((sd * np.array([*gains.values()])) ** 2), math.inf)
    return found_law_agreement(_axis(name).with_gains(gains), record, found)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps2015", P_PI])
@pytest.mark.parametrize(
    ("sd", "kp", "kv", "passed"),
    [(0.02, 1.03, 0.98, True), (0.002, 1.03, 0.98, False), (1e-4, 1.005, 0.995, True)],
)
def test_found_gains_may_be_off_by_what_they_are_unsure_of_or_does_not_matter(
    name: str, sd: float, kp: float, kv: float, passed: bool
) -> None:
    check = _checked(name, sd, _record(name), kp=kp, kv=kv)
    assert (check.passed, check.found_apart) == (passed, not passed), check.sentence
    found = check.finding
    assert isinstance(found, FoundGainsAgree if passed else FoundGainsDiffer)
    assert set(found.gains) == {"kp", "kv"}
    assert all(abs(factor - 1) < 1e-3 for factor in check.factors.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_a_wrong_gain_that_is_held_is_named_and_a_delay_is_no_gains(name: str) -> None:
    check = _checked(name, 0.02, _record(name, kv=1.1), kp=1.0)
    assert not check.passed
    ((named,),) = law_finding_of(check, OtherGains).alternatives
    assert (named.name, named.times) == ("kv", pytest.approx(1.1, rel=1e-3))
    late = _checked(
        name, 0.02, _record(name, delay=2), **dict.fromkeys(_axis(name).axis.control.gains, 1.0)
    )
    assert law_finding_of(late, LateControl).samples == 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps2015", P_PI])
def test_a_flipped_control_is_named_whatever_gains_are_free(name: str) -> None:
    record = _record(name)
    check = _checked(name, 0.02, replace(record, control=-record.control), kp=1.02, kv=0.99)
    assert not check.passed
    assert law_finding_of(check, OtherScale).scale.times < 0


def test_the_distance_is_that_of_a_normal_of_one_dimension() -> None:
    for away, covariance, dof, distance in (
        ([3.0], [[1.0]], math.inf, 3.0),
        ([3.0, 9.0], [[1.0, 0.0], [0.0, np.inf]], math.inf, 3.0),
        ([1.0], [[0.0]], math.inf, 0.0),
        ([3.0], [[1.0]], 16.0, -norm.ppf(student.sf(3.0, 16))),
    ):
        found = apart_in_deviations(np.array(away), np.array(covariance), dof)
        assert found == pytest.approx(distance)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [100, 101])
@pytest.mark.parametrize(("name", "free"), [("emps2015", ("kp", "kv")), (P_PI, ALL)])
def test_right_fits_with_free_gains_are_believed(
    name: str, free: tuple[str, ...], seed: int
) -> None:
    record = twin_record(_axis(name), seed=seed, position_noise=1e-6)
    found = fit(_axis(name), record.windowed((None, 2.0)), free=free)
    assert found.believed, [check for check in found.checks if check.status == "fail"]
    assert found.estimated_gains.names == free
