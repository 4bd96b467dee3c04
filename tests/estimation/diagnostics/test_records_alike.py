"""Each record against the others; samples that are among them more than once."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Identification, build, identify, leave_out
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels
from axisid.estimation.diagnostics.records_alike import (
    Alike,
    RecordRegressor,
    alike_check,
    records_alike,
    repeated_check,
)
from axisid.estimation.fitting.spread import Scores
from axisid.estimation.records import Record, Repairs, read_record
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


@pytest.mark.slow
@pytest.mark.parametrize(("percent", "status"), [(0, "pass"), (1, "note")])
def test_no_difference_passes_and_one_that_makes_no_force_is_a_note(
    plain: GeneratedAxis, percent: float, status: str
) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.01 * percent * (s == 3))) for s in (1, 2, 3)]
    found = _check(identify(plain, records, methods=METHOD))
    assert found.status == status
    assert ("less than 1 %" in found.meaning) is (status == "note")


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
    assert "Fv" not in found.meaning
    for said in (of_all, "another load", "known NAME=V1,V2"):
        assert said in found.meaning
    assert found.meaning.endswith("let each record have its own (local M)")
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
@pytest.mark.parametrize(
    ("truths", "options"),
    [
        ([{"tau0": 10.0 * s} for s in (1, 2, 3)], {"local": ("tau0",)}),
        ([{}, {"m_add": 20.0}], {"known": {"m_add": [0.0, 20.0]}}),
    ],
    ids=["local", "known"],
)
def test_what_is_declared_as_each_records_own_speaks_against_none(
    truths: list[dict[str, float]], options: dict[str, Any]
) -> None:
    runs = [stage_record(seed, **truth) for seed, truth in enumerate(truths, 1)]
    axis = build(leave_out(stage(), "m_add")) if "local" in options else generated()
    declared, shared = (identify(axis, runs, methods=METHOD, **o) for o in (options, {}))
    assert _check(shared).status == "fail"
    assert _check(declared).status == "pass"


def _asked(
    J: Array,
    errors: Array,
    levels: Levels = DEFAULT_LEVELS,
    *,
    windows: int = 1,
    clustered: bool = False,
) -> Alike | Missing:
    """Of least squares over records of 400 rows, in so many windows each."""
    long, firsts = 400 // windows, range(0, len(J), 400)
    spans = tuple(tuple(slice(i, i + long) for i in range(a, a + 400, long)) for a in firsts)
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
        for first in firsts
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
        ).p_value
        for _ in range(120)
    ]
    chances = np.array(found)
    assert np.mean(chances < 0.01) < 0.04
    assert 0.01 < np.mean(chances < 0.1) < 0.16


def test_one_after_the_other_is_named(rng: np.random.Generator) -> None:
    J = rng.standard_normal((2000, 2))
    errors = rng.standard_normal(2000)
    errors[400:800] -= J[400:800] @ [3.0, 0.0]
    errors[1600:] -= J[1600:] @ [0.0, 2.0]
    found = _asked(J, errors)
    assert found.against == (1, 4)
    assert _asked(J, errors, Levels(level=1e-300)).differing is None
    first = found.differing.apart
    assert first.names == ("a",)
    assert abs(first.own[0] - 3.0) < 4 * first.deviations[0]


def test_what_a_record_alone_does_not_tell_is_said(rng: np.random.Generator) -> None:
    J = rng.standard_normal((1200, 2))
    J[:400, 1] = 2 * J[:400, 0]
    J[800:] = 0.0
    check = alike_check(_asked(J, rng.standard_normal(1200)), ["one", "two", "three"])
    assert check.status == "pass"
    assert check.meaning.endswith("(one alone would not tell b; three alone would not tell them)")


def test_few_windows_do_not_tell_what_is_chance(rng: np.random.Generator) -> None:
    J = rng.standard_normal((800, 2))
    assert isinstance(_asked(J, rng.standard_normal(800), windows=4, clustered=True), Missing)


def log(size: int = 3000, *, seed: int = 0, step: float = 0.0) -> Record:
    """A motion with rests; the position and the control in steps where one is given."""
    rng = np.random.default_rng(seed)
    time = 1e-3 * np.arange(size)
    moving = np.sin(12 * time) * (np.sin(2 * time) > 0)
    position = moving + (0 if step else 1e-6 * rng.normal(size=size))
    control = np.gradient(moving, time) + (0.002 if step else 0.02) * rng.normal(size=size)
    if step:
        position, control = step * np.round(position / step), 0.01 * np.round(control / 0.01)
    return Record(time=time, position=position, reference=moving, control=control)


def cut(record: Record, start: int, stop: int, *, absolute: bool = True) -> Record:
    columns = {role: v[start:stop] for role, v in record.channels().items()}
    columns["time"] = columns["time"] - (0 if absolute else columns["time"][0])
    return record.with_channels(columns)


@pytest.mark.parametrize("absolute", [True, False])
def test_records_of_one_log_that_overlap_are_told_with_the_times(absolute: bool) -> None:
    whole = log()
    check = repeated_check([cut(whole, 0, 2000), cut(whole, 1000, 3000, absolute=absolute)])
    assert check.status == "fail"
    assert check.figure == pytest.approx(1.5)
    there = "1 to 1.999" if absolute else "0 to 0.999"
    assert f"1000 samples in common, from 1 to 1.999 s of the first and from {there} s" in (
        check.meaning
    )


def test_a_record_given_three_times_counts_so() -> None:
    check = repeated_check([log(step=1e-2)] * 3)
    assert check.figure == 3.0
    assert check.meaning.count("have the same samples") == 3


def test_two_stretches_of_a_log_are_told_beside_the_whole() -> None:
    whole = log()
    parts = whole.windowed((None, 0.9995), (1.9995, None))
    assert repeated_check([whole, parts]).figure == pytest.approx(1.8, abs=2e-3)


def test_an_overlap_of_no_weight_is_a_note() -> None:
    whole = log(20_000)
    check = repeated_check([cut(whole, 0, 10_100), cut(whole, 10_000, 20_000)])
    assert check.status == "note"


@pytest.mark.parametrize("step", [0.0, 1e-2, 1e-1])
def test_runs_of_one_motion_have_nothing_in_common(step: float) -> None:
    assert repeated_check([log(seed=seed, step=step) for seed in range(4)]) is None


def test_parts_that_only_touch_or_that_do_not_log_the_drive_have_nothing_in_common() -> None:
    whole = log()
    assert repeated_check([cut(whole, 0, 1500), cut(whole, 1500, 3000)]) is None
    assert repeated_check([replace(whole, control=None, force=whole.control), whole]) is None


def test_records_resampled_to_other_times_are_told_by_their_rows_before() -> None:
    """Rows with 5 % jitter: each file is laid on a grid from its own first row."""
    whole = log()
    jitter = 5e-5 * np.random.default_rng(1).normal(size=len(whole))
    columns = {**whole.channels(), "time": whole.time + jitter}
    first, second = (
        read_record({n: v[rows] for n, v in columns.items()}, repairs=Repairs(resample="auto"))
        for rows in (slice(0, 2000), slice(1000, 3000))
    )
    assert not np.isin(first.control, second.control).any()
    assert repeated_check([first, second]).figure == pytest.approx(1.5, abs=2e-3)
    other = log(seed=1)
    again = read_record({**other.channels(), "time": other.time + jitter[::-1]})
    assert repeated_check([first, again]) is None
