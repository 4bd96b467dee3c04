"""Estimates within declared bounds: those of the bounded least squares, with what is held told."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.stats import t as student

from axisid import (
    Axis,
    Prefilter,
    build,
    identify,
    load_axis,
    load_result,
    simulate,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.identification import Identification
from axisid.estimation.records import Record
from tests.refusals import refuses

_KEPT = Prefilter(reversals="keep")


@cache
def _record() -> Record:
    return twin_record(build(load_axis("emps2015")), position_noise=1e-6)


def _bounded(**lower: float) -> GeneratedAxis:
    axis: Axis = load_axis("emps2015")
    changed = tuple(
        replace(p, lower=lower[p.name], nominal=max(lower[p.name], p.nominal))
        if p.name in lower
        else p
        for p in axis.parameters
    )
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
    held = {each.name: each.bound for each in result.held}
    assert set(held) == {
        n for n, at in zip(("M", "Fv", "Fc"), wanted.active_mask, strict=True) if at
    }
    names = ["M", "Fv", "Fc"]
    at, left = [names.index(n) for n in held], [i for i, n in enumerate(names) if n not in held]
    rest = free.y - free.X[:, at] @ [*held.values()]
    found = np.linalg.lstsq(free.X[:, left], rest)[0]
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
    path = tmp_path / "result.json"
    path.write_text(json.dumps(result.to_dict()))
    written = result.to_dict()["held"]["Fc"]
    assert (written["bound"], written["free"]) == (held.bound, held.free)
    assert load_result(path, axis=axis.axis).summary() == result.summary()


@pytest.mark.slow
def test_intervals_hold_the_truth_where_chance_takes_a_parameter_to_its_bound() -> None:
    """As if the bound were the truth, the intervals of Fc hold in none of these."""
    axis, truth = build(load_axis("emps2015")), {"M": 100.2, "Fv": 0.4, "Fc": 24.8}
    whole, held, misses = _record(), 0, 0
    for seed in range(30):
        noise = np.random.default_rng(seed).normal(scale=3.8e-6, size=len(whole))
        loop = simulate(
            axis, [*truth.values()], whole.reference, whole.period, position_noise=noise
        )
        record = replace(whole, position=loop.measured_position, control=loop.control)
        result = identify(axis, record, methods=["didim"], bounded=True)
        held += bool(result.held)
        if result.held:
            found = {name: value.interval for name, value in result.preferred.parameters.items()}
            misses += sum(not low <= truth[name] <= high for name, (low, high) in found.items())
    assert held >= 3
    assert misses <= 1


def test_what_leaves_no_axis_is_refused_with_what_is_beyond() -> None:
    record = _record()
    flipped = replace(record, control=None, force=-35.15 * np.asarray(record.control))
    with refuses("bounds"):
        identify(_bounded(), flipped, _KEPT, ["idm-ls"], bounded=True)
