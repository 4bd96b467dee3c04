"""Each record against the others, and checks of each joined to one of all."""

import re

import numpy as np
import pytest

from axisid import Identification, build, identify, leave_out
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Levels
from axisid.estimation.checks.check import Check
from axisid.estimation.diagnostics.records_alike import (
    Alike,
    RecordRegressor,
    alike_check,
    records_alike,
    rows_alike,
)
from axisid.estimation.fitting.spread import Scores
from axisid.support.arrays import Array
from axisid.support.errors import Missing
from tests.axes.stage import generated, stage, stage_record

METHOD = ["idm-iv"]


@pytest.fixture(scope="module")
def plain() -> GeneratedAxis:
    return build(leave_out(stage(), "tau0", "m_add"))


def _check(result: Identification) -> Check:
    (found,) = (c for c in result.verdict if c.name == "records alike")
    return found


@pytest.mark.slow
def test_right_records_are_alike(plain: GeneratedAxis) -> None:
    found = _check(identify(plain, [stage_record(s) for s in (1, 2, 3)], methods=METHOD))
    assert found.status == "pass"
    assert found.p_value > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("odd", "twins"), [(0, 32), (2, 8)])
def test_the_record_that_differs_is_named_with_the_parameter(
    plain: GeneratedAxis, odd: int, twins: int
) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.03 * (i == odd))) for i, s in enumerate((1, 2, 3))]
    result = identify(plain, records, methods=METHOD, bootstrap=twins)
    found = _check(result)
    assert found.status == "fail"
    assert found.meaning.startswith(f"run {odd + 1} speaks against the rest: ")
    assert re.search(rf"M is 103\.2 \+- 0\.0[4-8] kg in run {odd + 1} and 100\.2", found.meaning)
    assert "believe" in result.summary().lower()


@pytest.mark.slow
def test_the_others_are_as_sure_as_by_themselves(plain: GeneratedAxis) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.03 * (s == 1))) for s in range(1, 7)]
    found = _check(identify(plain, records, methods=METHOD))
    (printed,) = re.findall(r"and 100\.\d \+- (\S+) in the rest", found.meaning)
    alone = identify(plain, records[1:], methods=METHOD).preferred.parameters["M"].deviation
    assert float(printed) == pytest.approx(alone, rel=0.4)


@pytest.mark.slow
@pytest.mark.parametrize("odd", [1, 2])
def test_an_untold_payload_is_named_with_what_declares_it(plain: GeneratedAxis, odd: int) -> None:
    """The estimate of all is no record's: nothing of it is to be believed."""
    runs = (1, 2, 3)[: odd + 1]
    records = [stage_record(s, M=100.2 + 20.0 * (s - 1 == odd)) for s in runs]
    result = identify(plain, records, methods=METHOD)
    found = _check(result)
    assert found.status == "fail"
    of_all = "run 1" if odd == 1 else "the rest"
    figures = sorted(map(float, re.findall(r" (1[02]0\.\d) \+- 0\.\d+", found.meaning)))
    assert figures == pytest.approx([100.2, 120.2], abs=0.3)
    assert of_all in found.meaning
    assert "Fv" not in found.meaning
    assert "another load" in found.meaning
    assert found.meaning.endswith("let each record have its own (local M)")
    assert "known NAME=V1,V2" in found.meaning
    assert "do not believe" in result.summary().lower()


@pytest.mark.slow
def test_a_load_that_makes_two_parameters_differ_names_both() -> None:
    """On a slope the payload is in the mass and in the weight."""
    axis = build(leave_out(stage(), "m_add"))
    records = [stage_record(1, tau0=5.0), stage_record(2, M=110.0, tau0=25.0)]
    found = _check(identify(axis, records, methods=METHOD))
    (names,) = re.findall(r"\(local (\S+)\)", found.meaning)
    assert sorted(names.split(",")) == ["M", "tau0"]


@pytest.mark.slow
def test_a_difference_that_makes_no_force_is_a_note(plain: GeneratedAxis) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.01 * (s == 3))) for s in (1, 2, 3)]
    found = _check(identify(plain, records, methods=METHOD))
    assert found.status == "note"
    assert "less than 1 %" in found.meaning


@pytest.mark.slow
def test_what_is_declared_as_each_records_own_speaks_against_none() -> None:
    records = [stage_record(s, tau0=10.0 * s) for s in (1, 2, 3)]
    axis = build(leave_out(stage(), "m_add"))
    shared, local = (
        identify(axis, records, methods=METHOD, local=names) for names in ((), ("tau0",))
    )
    assert _check(shared).status == "fail"
    assert _check(local).status == "pass"
    apart = rows_alike(local.problem, local["idm-iv"])
    assert apart.against == ()


@pytest.mark.slow
def test_known_payloads_are_no_difference() -> None:
    records = [stage_record(1), stage_record(2, m_add=20.0)]
    axis = generated()
    told, untold = (
        identify(axis, records, methods=METHOD, known=known)
        for known in ({"m_add": [0.0, 20.0]}, None)
    )
    assert _check(told).status == "pass"
    assert _check(untold).status == "fail"


def _asked(
    J: Array,
    errors: Array,
    levels: Levels = DEFAULT_LEVELS,
    *,
    windows: int = 1,
    clustered: bool = False,
) -> Alike | Missing:
    """Of least squares over records of 400 rows, in so many windows each."""
    long = 400 // windows
    spans = tuple(
        tuple(slice(i, i + long) for i in range(first, first + 400, long))
        for first in range(0, len(J), 400)
    )
    theta = -np.linalg.lstsq(J, errors)[0]
    scores = Scores(
        jacobian=J,
        errors=errors + J @ theta,
        curvature=np.ones(len(J)),
        known=np.zeros((0, J.shape[1])),
        counts=np.ones(len(J)),
        spans=spans,
        periods=(1e-2,) * len(spans),
    )
    records = [
        RecordRegressor(
            names=("a", "b"),
            units=("kg", "N"),
            values=theta,
            slopes=np.eye(2),
            span=slice(first, first + 400),
            columns=J[first : first + 400],
            instruments=J[first : first + 400],
            size=1e-3,
        )
        for first in range(0, len(J), 400)
    ]

    def extended(_: Array, columns: Array) -> tuple[Array, Array, Array]:
        return scores.extended(columns, clustered=clustered)

    return records_alike(J, records, extended, levels)


@pytest.mark.parametrize("windows", [1, 40])
def test_records_of_one_machine_are_told_apart_as_often_as_claimed(
    rng: np.random.Generator, windows: int
) -> None:
    found = [
        _asked(
            rng.standard_normal((1200, 2)),
            rng.standard_normal(1200),
            windows=windows,
            clustered=windows > 1,
        )
        for _ in range(120)
    ]
    chances = np.array([each.p_value for each in found if isinstance(each, Alike)])
    assert len(chances) == len(found)
    assert np.mean(chances < 0.01) < 0.04
    assert 0.01 < np.mean(chances < 0.1) < 0.16


def test_one_after_the_other_is_named(rng: np.random.Generator) -> None:
    J = rng.standard_normal((2000, 2))
    errors = rng.standard_normal(2000)
    errors[400:800] -= J[400:800] @ [3.0, 0.0]
    errors[1600:] -= J[1600:] @ [0.0, 2.0]
    found = _asked(J, errors)
    assert found.against == (1, 4)
    surer = _asked(J, errors, Levels(level=1e-300))
    assert not surer.rejected
    assert found.differing.apart.names == ("a",)
    assert abs(found.differing.apart.own[0] - 3.0) < 4 * found.differing.apart.deviations[0]


def test_what_a_record_alone_does_not_tell_is_said(rng: np.random.Generator) -> None:
    J = rng.standard_normal((1200, 2))
    J[:400, 1] = 2 * J[:400, 0]
    J[800:] = 0.0
    found = _asked(J, rng.standard_normal(1200))
    check = alike_check(found, ["one", "two", "three"])
    assert check.status == "pass"
    assert check.meaning.endswith("(one alone would not tell b; three alone would not tell them)")


def test_few_windows_do_not_tell_what_is_chance(rng: np.random.Generator) -> None:
    J = rng.standard_normal((800, 2))
    found = _asked(J, rng.standard_normal(800), windows=4, clustered=True)
    assert isinstance(found, Missing)
