"""Each record against the others; samples that are among them more than once."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Identification, build, identify, leave_out
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Check, Levels
from axisid.estimation.diagnostics.records_alike import (
    PoolingTest,
    RecordRegressor,
    pooling_check,
    records_alike,
    repeated_check,
)
from axisid.estimation.output_error.covariance import Sandwich
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
@pytest.mark.parametrize(
    ("odd", "percent", "twins", "status", "said"),
    [
        (1, 0, 32, "pass", "each record alone would give the same"),
        (3, 1, 32, "note", "less than 1 %"),
        *(
            (
                odd,
                3,
                twins,
                "fail",
                rf"^run {odd} speaks against the rest: .*M is 103\.2 kg in run {odd} and 100\.2 in "
                r"the rest \(\+3 \+- 0\.0[5-9]\)",
            )
            for odd, twins in ((1, 32), (3, 8))
        ),
    ],
)
def test_the_record_that_differs_is_named_with_the_parameter(
    plain: GeneratedAxis, odd: int, percent: int, twins: int, status: str, said: str
) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.01 * percent * (s == odd))) for s in (1, 2, 3)]
    found = _check(identify(plain, records, methods=METHOD, bootstrap=twins))
    assert found.status == status
    assert re.search(said, found.meaning)


@pytest.mark.slow
@pytest.mark.parametrize(("odd", "of_all"), [(1, "run 1"), (2, "the rest")])
def test_an_untold_payload_is_named_with_what_declares_it(
    plain: GeneratedAxis, odd: int, of_all: str
) -> None:
    """The estimate of all is no record's: nothing of it is to be believed."""
    masses = [100.2] * odd + [120.2]
    records = [stage_record(s, M=mass) for s, mass in enumerate(masses, 1)]
    result = identify(plain, records, methods=METHOD)
    said = _check(result).meaning
    figures = sorted(map(float, re.findall(r" (1[02]0\.\d) ", said)))
    assert figures == pytest.approx([100.2, 120.2], abs=0.3)
    assert "Fv" not in said
    assert all(words in said for words in (of_all, "another load", "known NAME=V1,V2"))
    assert said.endswith("let each record have its own (local M)")
    assert result.belief == "not believed"


@pytest.mark.slow
def test_a_load_that_makes_two_parameters_differ_names_both_as_they_may_be_declared() -> None:
    """On a slope the payload is in the mass, of which a record tells a sum, and in the weight."""
    records = [stage_record(1, tau0=5.0), stage_record(2, M=110.0, tau0=25.0)]
    (names,) = re.findall(
        r"\(local (\S+)\)", _check(identify(generated(), records, methods=METHOD)).meaning
    )
    own = identify(generated(), records, methods=METHOD, local=names.split(","))
    assert sorted(own.local) == ["M", "tau0"]
    assert _check(own).status == "pass"


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
) -> PoolingTest | Missing:
    """Of least squares over records of 400 rows, in so many windows each."""
    long, firsts = 400 // windows, range(0, len(J), 400)
    spans = tuple(tuple(slice(i, i + long) for i in range(a, a + 400, long)) for a in firsts)
    theta = -np.linalg.lstsq(J, errors)[0]
    sandwich = Sandwich(
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
        return sandwich.extended(columns, clustered=clustered)

    return records_alike(J, records, extended, levels)


@pytest.mark.parametrize("windows", [1, 40])
def test_records_of_one_machine_are_told_apart_as_often_as_claimed(
    rng: np.random.Generator, windows: int
) -> None:
    p_values = np.array(
        [
            _asked(
                rng.standard_normal((1200, 2)),
                rng.standard_normal(1200),
                windows=windows,
                clustered=windows > 1,
            ).p_value
            for _ in range(120)
        ]
    )
    assert np.mean(p_values < 0.01) < 0.04
    assert 0.01 < np.mean(p_values < 0.1) < 0.16


def test_the_most_odd_one_is_named(rng: np.random.Generator) -> None:
    J = rng.standard_normal((2000, 2))
    errors = rng.standard_normal(2000)
    errors[400:800] -= J[400:800] @ [3.0, 0.0]
    found = _asked(J, errors)
    assert _asked(J, errors, Levels(level=1e-300)).odd is None
    first = found.records[1]
    assert first.differing(DEFAULT_LEVELS) == ("a",)
    assert abs(first.distances["a"] - 3.0 / first.deviations["a"]) < 4
    errors[1600:] -= J[1600:] @ [0.0, 2.0]
    assert found.odd == _asked(J, errors).odd == 1


def test_what_a_record_alone_does_not_tell_is_said(rng: np.random.Generator) -> None:
    J = rng.standard_normal((1200, 2))
    J[:400, 1] = 2 * J[:400, 0]
    J[800:] = 0.0
    check = pooling_check(_asked(J, rng.standard_normal(1200)), ["one", "two", "three"])
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


WHOLE, LONG = log(), log(20_000)


@pytest.mark.parametrize(
    ("records", "figure", "status", "said"),
    [
        *(
            (
                [cut(WHOLE, 0, 2000), cut(WHOLE, 1000, 3000, absolute=absolute)],
                *(1.5, "fail"),
                f"1000 samples in common, from 1 to 1.999 s of the first and from {there} s",
            )
            for absolute, there in ((True, "1 to 1.999"), (False, "0 to 0.999"))
        ),
        (
            [log(step=1e-2)] * 3,
            3.0,
            "fail",
            "(record 1) and arrays (record 3) have 3000 samples in common",
        ),
        ([WHOLE, WHOLE.windowed((None, 0.9995), (1.9995, None))], 1.8, "fail", "in common"),
        ([cut(LONG, 0, 10_100), cut(LONG, 10_000, 20_000)], 1.01, "note", "100 samples in common"),
    ],
    ids=["same clock", "own clocks", "given three times", "two stretches", "of no weight"],
)
def test_samples_that_are_given_again_are_told_with_the_times(
    records: list[Record], figure: float, status: str, said: str
) -> None:
    check = repeated_check(records)
    assert check.status == status
    assert check.figure == pytest.approx(figure, abs=2e-3)
    assert said in check.meaning


@pytest.mark.parametrize(
    "records",
    [
        *([log(seed=seed, step=step) for seed in range(4)] for step in (0.0, 1e-2, 1e-1)),
        [cut(WHOLE, 0, 1500), cut(WHOLE, 1500, 3000)],
        [replace(WHOLE, control=None, force=WHOLE.control), WHOLE],
    ],
)
def test_runs_of_one_motion_and_parts_that_only_touch_have_nothing_in_common(
    records: list[Record],
) -> None:
    assert repeated_check(records) is None


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
