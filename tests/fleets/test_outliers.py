"""Which logs stand out: those that differ by more than scatter and deviations explain."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.stats import binom

from axisid.estimation.thresholds import FLEET_LEVEL
from axisid.fleets import Fleet, FleetRow
from axisid.fleets.result import groups_of
from axisid.fleets.robust_statistics import robust_scatter
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from tests.fleets.logs import BETWEEN, CENTRE, WITHIN, row_of, rows_of


def test_centre_and_scatter_are_those_of_the_most_though_a_third_is_elsewhere() -> None:
    rng = np.random.default_rng(4)
    points = rng.multivariate_normal(CENTRE, BETWEEN, 300)
    points[:90] += [20.0, 0.0, 3.0]
    centre, covariance = robust_scatter(points)
    np.testing.assert_allclose(centre, CENTRE, atol=0.4)
    spread = np.sqrt(np.diag(covariance)) / np.sqrt(np.diag(BETWEEN))
    np.testing.assert_allclose(spread / spread.mean(), 1.0, atol=0.15)
    assert 1.0 < spread.mean() < 1.6  # the median of the distances is of all points


def test_units_do_not_matter() -> None:
    points = np.random.default_rng(2).multivariate_normal(CENTRE, BETWEEN, 60)
    scale = np.array([1e-6, 1e3, 1.0])
    plain, scaled = robust_scatter(points), robust_scatter(points * scale)
    np.testing.assert_allclose(scaled[0], plain[0] * scale)
    np.testing.assert_allclose(scaled[1], plain[1] * np.outer(scale, scale))


def test_the_scatter_between_logs_is_without_that_of_their_estimates() -> None:
    (group,) = groups_of(rows_of(400, 1))
    np.testing.assert_allclose(np.diag(group.usual.between), np.diag(BETWEEN), rtol=0.3)


def _values(row: FleetRow) -> Array:
    return np.array([value.value for value in row.parameters.values()])


def repeated(machines: int, logs: int, seed: int, apart: Array | None = None) -> list[FleetRow]:
    """Several logs of each machine."""
    rng = np.random.default_rng(seed)
    return [
        replace(
            row_of(f"{row.name}-{day}", rng.multivariate_normal(_values(row), WITHIN)), serial=s
        )
        for s, row in ((row.name, row) for row in rows_of(machines, seed, apart))
        for day in range(logs)
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "fleet_of",
    [partial(rows_of, 20), partial(rows_of, 60), partial(repeated, 20, 4)],
    ids=["20 logs", "60 logs", "4 logs of each of 20 machines"],
)
def test_right_fleets_have_an_outlier_no_more_often_than_the_level_says(
    fleet_of: Callable[[int], list[FleetRow]],
) -> None:
    runs = 40
    found = sum(bool(groups_of(fleet_of(seed))[0].outliers) for seed in range(runs))
    assert found <= binom.ppf(0.999, runs, FLEET_LEVEL.value)


def test_a_log_that_differs_is_named_with_the_parameter_that_does() -> None:
    for seed in range(5):
        first = groups_of(rows_of(60, seed, np.array([0.0, 0.0, 8.0])))[0].outliers[0]
        assert (first.name, first.parameter) == ("axis0", "Fc")
        assert first.apart == pytest.approx(8.0, rel=0.3)


def test_a_log_that_merely_knows_little_does_not_stand_out() -> None:
    rows = rows_of(60, 3)
    far = CENTRE + np.array([0.0, 0.0, 2.0])  # eight deviations of a log that knows more
    assert groups_of([*rows, row_of("vague", far, 400 * WITHIN)])[0].outliers == ()
    assert groups_of([*rows, row_of("sure", far)])[0].outliers[0].name == "sure"


def test_a_quarter_of_the_logs_that_lie_together_do_not_hide_one_another() -> None:
    moved = [row_of(r.name, _values(r) + np.array([10.0, 0.0, 2.0])) for r in rows_of(15, 8)]
    found = groups_of([*moved, *[replace(r, name=f"right{r.name}") for r in rows_of(45, 9)]])[0]
    assert {each.name for each in found.outliers} == {f"axis{i}" for i in range(15)}


def test_a_log_whose_values_are_not_finite_is_told_and_left_out() -> None:
    rows = rows_of(20, 1)
    odd = row_of("odd", np.array([np.nan, 200.0, 20.0]))
    assert groups_of([*rows, odd]) == groups_of(rows)
    said = " ".join(Fleet(folder="", rows=(*rows, odd)).summary().split())
    assert "1 log is excluded from the statistics" in said


@pytest.mark.parametrize("size", [1e90, 1e150, 1e308])
def test_a_log_whose_values_are_beyond_all_sense_hides_nothing_of_the_others(size: float) -> None:
    rows = rows_of(20, 1)
    for moved in (np.array([size, 200.0, 20.0]), np.full(3, size)):
        (group,) = groups_of([*rows, row_of("huge", moved)])
        np.testing.assert_allclose(group.usual.centre, CENTRE, rtol=0.05)
        assert [each.name for each in group.outliers] == (["huge"] if size < 1e100 else [])


def test_values_in_a_plane_tell_nothing_though_one_is_far() -> None:
    rows = [row_of(r.name, _values(r) * [1, 1, 0] + [0, 0, _values(r)[0]]) for r in rows_of(20, 1)]
    (group,) = groups_of([*rows, row_of("far", np.array([1e8, 1.0, 3.0]))])
    assert isinstance(group.usual, Missing)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (rows_of(8, 1), "8 logs are too few to find outliers; at least 15 are needed"),
        (repeated(3, 12, 1), "36 logs of 3 machines are too few"),
    ],
    ids=["logs", "machines"],
)
def test_of_few_logs_or_machines_nothing_is_usual(rows: list[FleetRow], said: str) -> None:
    (group,) = groups_of(rows)
    assert group.outliers == ()
    assert said in group.usual.reason


def test_a_machine_that_differs_is_named_by_all_its_logs() -> None:
    rows = repeated(30, 2, 5, np.array([0.0, 0.0, 12.0]))
    found = Fleet(folder="", rows=tuple(rows))
    assert [(o.name, o.parameter) for o in found.outliers[:2]] == [
        ("axis0-0", "Fc"),
        ("axis0-1", "Fc"),
    ]
    assert "stage, 60 logs of 30 machines" in found.summary()
    assert "sd between machines" in found.summary()


def test_logs_of_one_machine_are_held_against_one_another() -> None:
    rows = [replace(row, serial="17") for row in rows_of(60, 2, np.array([0.0, 0.0, 12.0]))]
    (group,) = groups_of(rows)
    assert (group.machines, group.outliers[0].name) == (60, "axis0")
