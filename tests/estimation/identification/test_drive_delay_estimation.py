"""A drive's lag or delay is found, and told."""

from dataclasses import replace
from typing import Any

import pytest

from axisid import (
    Parameter,
    Record,
    build,
    twin_record,
)
from axisid.modeling import back_and_forth
from tests.axes.lagging import TRUTH, lagging, noisy
from tests.refusals import refuses
from tests.unjudged import identify

METHODS = ["idm-ls", "idm-iv", "didim"]


def _short_record(seed: int = 1, **timing: float) -> Record:
    """The twin of a short experiment."""
    moves = back_and_forth(speeds=(0.06, 0.12), acceleration=0.8, seconds=0.4)
    axis = lagging(**timing)
    short = replace(axis, experiment=replace(axis.experiment, moves=moves))
    return twin_record(build(short), position_noise=1e-6, seed=seed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "known", "true"), [("lag", {"delay": 3.5e-4}, 8e-4), ("delay", {}, 6e-4)]
)
def test_lag_or_delay_is_found_and_is_in_every_deviation(
    name: str, known: dict[str, float], true: float
) -> None:
    drive = {**known, name: Parameter("T", "s", nominal=2e-4)}
    away, axis = [], build(lagging(**drive))
    for seed in range(6):
        record = _short_record(seed=seed, **known, **{name: true})
        result = identify(axis, record, methods=["idm-ls", "idm-iv"])
        found = result.drive_time
        away.append((found.value - true) / found.deviation)
    assert 0.4 < (sum(z**2 for z in away) / len(away)) ** 0.5 < 1.7
    assert found.deviation < 1e-4
    assert str(found).startswith(f"{name} T = ")
    assert found.interval[0] < true < found.interval[1]
    assert getattr(result.axis.axis.drive, name) == found.value
    alone = identify(lagging(**known, **{name: found.value}), record, methods=["idm-ls", "idm-iv"])
    for method, estimate in result.estimates.items():
        for parameter, truth in TRUTH.items():
            value, exact = (each.parameters[parameter] for each in (estimate, alone[method]))
            assert value.value == exact.value
            assert value.deviation > exact.deviation
            assert abs(value.value - truth) < 3 * value.deviation


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "late", "count"),
    [({"control": None}, 0, 1), ({}, 1, 1), ({}, 0, 2)],
    ids=["no law", "force before its command", "two records"],
)
def test_what_a_record_cannot_show_is_refused(
    changed: dict[str, Any], late: int, count: int
) -> None:
    axis = replace(lagging(lag=Parameter("Tc", "s", nominal=1e-3)), **changed)
    with refuses("drive-time"):
        identify(axis, [_short_record().shifted(control=late)] * count)


@pytest.mark.slow
def test_a_bound_between_the_estimates_by_two_times_is_kept_by_both() -> None:
    """Of 0.79 ms, the estimate, and of a deviation more."""
    axis = lagging(lag=Parameter("T", "s", nominal=2e-4))
    mass, *others = axis.parameters
    bounded = replace(axis, parameters=(replace(mass, upper=95.031), *others))
    found = identify(
        bounded, _short_record(lag=8e-4), bootstrap=0, bounded=True, methods=METHODS[:2]
    )
    assert found.drive_time.value == pytest.approx(7.9e-4, rel=0.05)
    assert [each.name for each in found.held] == ["M"]


def test_a_value_may_be_known_with_a_deviation_beyond_its_bound() -> None:
    axis = lagging()
    mass, viscous, *others = axis.parameters
    known = {"Fv": [(200.0, 1.0)]}
    free, near = (
        identify(
            replace(axis, parameters=(mass, replace(viscous, upper=upper), *others)),
            _short_record(),
            methods=["idm-ls"],
            bootstrap=0,
            known=known,
        ).preferred.parameters["M"]
        for upper in (float("inf"), 200.5)
    )
    assert near.deviation == pytest.approx(free.deviation, rel=1e-3)


BEHIND = {"lag": 8e-4, "delay": 3.5e-4, "logged": "current"}
PATH = {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.3}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "noise"),
    [
        ({"lag": 1e-3}, 0.0),
        ({"delay": 3.5e-4}, 0.0),
        ({"lag": 8e-4, "delay": 1.35e-3, "logged": "applied"}, 0.0),
        (BEHIND, 0.0),
        (PATH, 1e-6),
        ({**PATH, **BEHIND}, 1e-6),
    ],
)
def test_what_a_drive_declares_leaves_no_error(declared: dict[str, Any], noise: float) -> None:
    axis = build(noisy(lagging(**declared), noise, seed=7))
    result = identify(axis, twin_record(axis), methods=["idm-iv"] if noise else METHODS)
    for estimate in result.estimates.values():
        for name, true in TRUTH.items():
            value = estimate.parameters[name]
            most = 2.5 * value.deviation if noise else 1e-5 * true
            assert abs(value.corrected - true) < most
            assert noise or abs(value.value / true - 1) < 9e-4  # by the filter, beside reversals
    checks = {check.name: check for check in result.verdict}
    for name in checks if noise else ("control law", "alignment", "simulation", "method"):
        assert checks[name].status != "fail", checks[name]
    assert checks["control law"].figure < 1e-6
    assert noise or result.preferred.simulation_error_percent < 0.1


@pytest.mark.slow
def test_an_undeclared_dead_band_is_taken_for_friction_and_named_with_its_width() -> None:
    record = twin_record(build(noisy(lagging(deadband=0.05), 1e-6)))
    result = identify(lagging(), record, methods=METHODS)
    assert result.estimates["idm-iv"].parameters["Fc"].corrected > 1.05 * TRUTH["Fc"]
    (failing,) = (check for check in result.verdict if check.status == "fail")
    assert failing.name == "missing terms"
    assert "Drive(deadband=0.05" in failing.meaning
