"""Comparison of each record with the others."""

from typing import Any

import numpy as np
import pytest

from axisid import (
    Identification,
    build,
    leave_out,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.pooling import (
    PoolingTest,
    RecordRegressor,
    pooling_check,
    pooling_test_of,
)
from axisid.estimation.diagnostics.pooling_findings import (
    ComparedRecords,
    OddRecord,
    UnidentifiedInRecord,
)
from axisid.estimation.output_error.covariance import Sandwich
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from tests.axes.stage import generated, stage, stage_record
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

METHOD = ["idm-iv"]


@pytest.fixture(scope="module")
def plain() -> GeneratedAxis:
    return build(leave_out(stage(), "tau0", "m_add"))


def _check(result: Identification) -> Check:
    return checks_of(result)["records alike"]


def _odd(check: Check) -> OddRecord:
    """The record that differs from the others."""
    odd = finding_of(check, ComparedRecords).odd
    assert odd is not None
    return odd


@pytest.mark.slow
@pytest.mark.parametrize(
    ("odd", "percent", "twins", "status"),
    [(1, 0, 32, "pass"), (3, 1, 32, "note"), (1, 3, 32, "fail"), (3, 3, 8, "fail")],
)
def test_the_record_that_differs_is_named_with_the_parameter(
    plain: GeneratedAxis, odd: int, percent: int, twins: int, status: str
) -> None:
    records = [stage_record(s, M=100.2 * (1 + 0.01 * percent * (s == odd))) for s in (1, 2, 3)]
    check = _check(identify(plain, records, methods=METHOD, bootstrap=twins))
    assert check.status == status
    found = finding_of(check, ComparedRecords)
    assert found.largest_percent == check.figure
    if status == "pass":
        assert found.odd is None
        return
    of_odd = _odd(check)
    assert (of_odd.name, of_odd.other) == (f"run {odd}", None)
    assert of_odd.matters is (status == "fail")
    if status == "fail":
        (mass,) = (each for each in of_odd.parameters if each.name == "M")
        assert mass.own == pytest.approx(103.2, abs=0.1)
        assert mass.common == pytest.approx(100.2, abs=0.1)
        assert 0.04 < mass.standard_error < 0.1
        assert mass.is_load


@pytest.mark.slow
@pytest.mark.parametrize("odd", [1, 2])
def test_an_undeclared_payload_is_named_with_its_size(plain: GeneratedAxis, odd: int) -> None:
    """The common estimate describes none of the records, so that it must not be used."""
    masses = [100.2] * odd + [120.2]
    records = [stage_record(s, M=mass) for s, mass in enumerate(masses, 1)]
    result = identify(plain, records, methods=METHOD)
    of_odd = _odd(_check(result))
    (mass,) = of_odd.parameters
    assert (mass.name, mass.unit, mass.is_load) == ("M", "kg", True)
    assert sorted((mass.own, mass.common)) == pytest.approx([100.2, 120.2], abs=0.3)
    assert (of_odd.other is None) is (odd == 2)
    assert result.belief == "not believed"


@pytest.mark.slow
def test_a_load_that_makes_two_parameters_differ_names_both_as_they_may_be_declared() -> None:
    """On a slope the payload is in the mass, of which a record tells a sum, and in the weight."""
    records = [stage_record(1, tau0=5.0), stage_record(2, M=110.0, tau0=25.0)]
    of_odd = _odd(_check(identify(generated(), records, methods=METHOD)))
    names = [each.name for each in of_odd.parameters]
    own = identify(generated(), records, methods=METHOD, local=names)
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
    every: int = 1,
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
            every=every,
        )
        for first in firsts
    ]

    def extended(_: Array, columns: Array) -> tuple[Array, Array, Array]:
        return sandwich.extended(columns, clustered=clustered)

    return pooling_test_of(J, records, extended, levels)


@pytest.mark.slow
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


def test_parameters_that_a_record_alone_does_not_identify_are_named(
    rng: np.random.Generator,
) -> None:
    J = rng.standard_normal((1200, 2))
    J[:400, 1] = 2 * J[:400, 0]
    J[800:] = 0.0
    check = pooling_check(_asked(J, rng.standard_normal(1200)), ["one", "two", "three"])
    assert check.status == "pass"
    assert finding_of(check, ComparedRecords).unidentified == (
        UnidentifiedInRecord(record="one", parameters=("b",)),
        UnidentifiedInRecord(record="three", parameters=()),
    )


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize(("rows", "every", "tested"), [(4, 1, 0), (19, 1, 0), (200, 10, 2)])
def test_a_record_of_few_rows_is_not_compared_nor_are_others_with_it(
    rng: np.random.Generator, place: int, rows: int, every: int, tested: int
) -> None:
    """Fewer than ten for a parameter: the estimate follows them, whatever is wrong."""
    J, errors = rng.standard_normal((800, 2)), rng.standard_normal(800)
    few = slice(400 * place, 400 * place + 400 - rows)
    J[few], errors[few] = 0.0, 0.0
    found = _asked(J, errors, every=every)
    records = [] if isinstance(found, Missing) else found.records
    assert sum(not isinstance(each, Missing) for each in records) == tested


def test_few_windows_do_not_tell_what_is_chance(rng: np.random.Generator) -> None:
    J = rng.standard_normal((800, 2))
    assert isinstance(_asked(J, rng.standard_normal(800), windows=4, clustered=True), Missing)
