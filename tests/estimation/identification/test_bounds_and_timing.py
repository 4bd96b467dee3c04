"""Parameters within declared bounds, and a drive's lag or delay: held, or found, and told."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.stats import t as student

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    load_result,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.modeling import back_and_forth
from tests.axes.lagging import TRUTH, lagging, noisy
from tests.refusals import refuses

_KEPT = Prefilter(reversals="keep")


@cache
def _record() -> Record:
    return twin_record(build(load_axis("emps2015")), position_noise=1e-6)


def _bounded(**lower: float) -> GeneratedAxis:
    axis = load_axis("emps2015")
    ends = ((p, lower.get(p.name, p.lower)) for p in axis.parameters)
    changed = tuple(replace(p, lower=end, nominal=max(end, p.nominal)) for p, end in ends)
    return build(replace(axis, parameters=changed))


@cache
def _free() -> Identification:
    return identify(_bounded(), _record(), _KEPT, ["idm-ls"])


@pytest.mark.slow
@pytest.mark.parametrize("beyond", [(3.0, 0.2), (-1e-3, 0.2), (3.0, -0.05)])
def test_least_squares_are_those_of_the_same_rows_within_the_bounds(
    beyond: tuple[float, float],
) -> None:
    within = identify(_bounded(), _record(), _KEPT, ["idm-ls"], bounded=True)
    free = _free().preferred
    assert not within.held
    assert within.preferred == free
    lower = {"Fv": free.corrected[1] + beyond[0], "Fc": free.corrected[2] + beyond[1]}
    result = identify(_bounded(**lower), _record(), _KEPT, ["idm-ls"], bounded=True)
    bounds = ([-np.inf, *lower.values()], np.inf)
    y = free.y + free.X @ (free.corrected - free.physical)
    wanted = lsq_linear(free.X, y, bounds=bounds, method="bvls", tol=1e-14)
    at = wanted.active_mask != 0
    assert [held.name for held in result.held] == [*np.array(["M", "Fv", "Fc"])[at]]
    found = np.linalg.lstsq(free.X[:, ~at], free.y - free.X[:, at] @ wanted.x[at])[0]
    assert result.preferred.physical == pytest.approx(found, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("deviations", "status"), [(1.0, "note"), (8.0, "fail")])
def test_a_bound_that_the_record_contradicts_fails_and_one_by_chance_is_told(
    tmp_path: Path, deviations: float, status: str
) -> None:
    value = _free().preferred.parameters["Fc"]
    lower = value.corrected + deviations * value.deviation
    axis = _bounded(Fc=lower)
    result = identify(axis, _record(), _KEPT, ["idm-ls"], bounded=True)
    (held,) = result.held
    ends = sorted((held.bound, held.reach))
    away = student.ppf(0.95, _free().preferred.freedom["hac"][2]) * held.deviation
    room = max(0.0, held.free + away - held.bound)
    assert ends[1] - ends[0] == pytest.approx(room, rel=1e-6, abs=1e-12)
    (check,) = (each for each in result.verdict if each.name == "bounds")
    assert (check.status, check.figure) == (status, pytest.approx(held.distance))
    saved = load_result(result.save(tmp_path / "result.json"), axis=axis.axis)
    assert saved.summary() == result.summary()


@pytest.mark.slow
def test_intervals_hold_the_truth_where_chance_takes_a_parameter_to_its_bound() -> None:
    """As if the bound were the truth, the intervals of Fc hold in none of these."""
    axis, truth = _bounded(), {"M": 100.2, "Fv": 0.4, "Fc": 24.8}
    whole, held, misses = _record(), 0, 0
    for seed in range(30):
        noise = np.random.default_rng(seed).normal(scale=3.8e-6, size=len(whole))
        loop = simulate(
            axis, [*truth.values()], whole.reference, whole.period, position_noise=noise
        )
        record = replace(whole, position=loop.measured_position, control=loop.control)
        result = identify(axis, record, methods=["didim"], bounded=True)
        held += bool(result.held)
        for name, value in result.preferred.parameters.items() if result.held else ():
            misses += not value.interval[0] <= truth[name] <= value.interval[1]
    assert held >= 3
    assert misses <= 1


def test_what_leaves_no_axis_is_refused_with_what_is_beyond() -> None:
    record = _record()
    flipped = replace(record, control=None, force=-35.15 * np.asarray(record.control))
    with refuses("bounds"):
        identify(_bounded(), flipped, _KEPT, ["idm-ls"], bounded=True)


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


BEHIND = {"lag": 8e-4, "delay": 3.5e-4, "logged": "current"}
PATH = {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.3}
METHODS = ["idm-ls", "idm-iv", "didim"]


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
