"""A law run by its gains is the generated law, and gives its gains back."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, twin_record
from axisid.estimation.loops import LawAlong, LawPoint, control_along, law_ticks, start_of_law
from tests.axes.ready_laws import LAWS, with_law


@cache
def _twin(name: str, limit: float) -> Record:
    return twin_record(with_law(name, limit))


def _along(name: str, limit: float = 10.0) -> tuple[LawAlong, LawPoint]:
    axis, record = with_law(name, limit), _twin(name, limit)
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole)
    along = LawAlong.of(axis, LAWS[name](), ticks, record)
    start = start_of_law(axis, record, whole, ticks)
    return along, LawPoint(along.declared.gains, start)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limit"),
    [("cascade_p_pi, feed-forward", 10.0), ("cascade_p_pi, back-calculation", 3.2), ("pid", 10.0)],
)
def test_a_run_by_gains_is_the_generated_law(name: str, limit: float) -> None:
    axis, record = with_law(name, limit), _twin(name, limit)
    along, point = _along(name, limit)
    wanted = control_along(axis, along.ticks, point.start)
    given = np.clip(along.output(point), -limit, limit)
    np.testing.assert_allclose(given, wanted, atol=1e-9)
    np.testing.assert_allclose(given, np.asarray(record.control), atol=1e-9)


def test_slopes_are_those_of_the_output() -> None:
    along, point = _along("cascade_p_pi")
    by_gain, by_start = along.slopes_by_gain(point), along.slopes_by_start(point)
    assert by_gain.shape == (len(along.control), 3)
    assert by_start.shape == (len(along.control), 2)
    # All of the output is a multiple of kv; the integral's start stands in it over tn.
    np.testing.assert_allclose(by_gain[:, 1], along.output(point), rtol=1e-6, atol=1e-6)
    kv, tn = along.law.gains["kv"], along.law.gains["tn"]
    np.testing.assert_allclose(by_start[:, 1], kv / tn, rtol=1e-5)


@pytest.mark.parametrize("name", ["cascade_p_pi, clamped", "pid_ideal"])
def test_gains_that_are_7_percent_off_are_found_again(name: str) -> None:
    along, point = _along(name)
    off = replace(point, gains=1.07 * point.gains)
    found = along.fitted(off, lambda control: control[10:], range(len(point.gains)))
    np.testing.assert_allclose(found.gains, point.gains, rtol=1e-6)
