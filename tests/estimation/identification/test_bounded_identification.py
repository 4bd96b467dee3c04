"""Parameters within declared bounds: held at them, and told."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.stats import t as student

from axisid import (
    Identification,
    Prefilter,
    Record,
    build,
    load_axis,
    load_result,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of

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
    check = checks_of(result)["bounds"]
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


@pytest.mark.slow
def test_what_leaves_no_axis_is_refused_with_what_is_beyond() -> None:
    record = _record()
    flipped = replace(record, control=None, force=-35.15 * np.asarray(record.control))
    with refuses("bounds"):
        identify(_bounded(), flipped, _KEPT, ["idm-ls"], bounded=True)
