"""Filters of records whose periods differ."""

import pytest

from axisid.estimation.parameters.known import prefilters_of
from axisid.estimation.signals.prefilter import Prefilter
from tests.refusals import refuses


def test_records_of_one_period_have_the_filter_that_was_asked_for() -> None:
    asked = Prefilter(cutoff=20.0, decimate=7)
    assert prefilters_of(asked, 1e-3, [1e-3, 1.0000001e-3]) == [asked, asked]


@pytest.mark.parametrize(
    "periods", [(1e-3, 2e-3), (1e-3, 1.5e-3), (1 / 300, 1 / 500, 3e-3), (2e-3, 5e-4)]
)
def test_rows_are_as_far_apart_in_all_records(periods: tuple[float, ...]) -> None:
    asked = Prefilter(cutoff=40.0, decimate=10)
    found = prefilters_of(asked, periods[0], periods)
    apart = [f.decimate * period for f, period in zip(found, periods, strict=True)]
    assert apart == pytest.approx([apart[0]] * len(apart), rel=1e-9)
    assert 0.5 * 10 * periods[0] <= apart[0] <= 2 * 10 * periods[0]
    assert {f.cutoff for f in found} == {40.0}


def test_periods_without_a_common_multiple_are_refused_with_advice() -> None:
    with refuses("no-common-period"):
        prefilters_of(Prefilter(), 1e-3, [1e-3, 1.0137e-3])
