"""Runs of a law along a record, by its terms and by its gains."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, build, twin_record
from axisid.codegen import GeneratedAxis
from axisid.estimation.loops import (
    LawAlong,
    LawPoint,
    LawTicks,
    control_along,
    law_run,
    law_ticks,
    start_of_law,
    state_at_rest,
)
from tests.axes.ready_laws import LAWS, with_law
from tests.axes.simulated import AXES


def test_law_in_pieces_gives_the_terms_of_the_whole(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    ticks = law_ticks(emps2015, twin, (0, len(twin)))
    start = state_at_rest(emps2015, ticks)
    whole = law_run.terms_along(emps2015, ticks, start)
    monkeypatch.setattr(law_run, "_EVALUATIONS", 3000)
    assert np.array_equal(law_run.terms_along(emps2015, ticks, start), whole)


def test_a_late_law_with_an_integral_is_the_sum_by_hand(rng: np.random.Generator) -> None:
    axis = build(AXES["delayed"], native=False)
    reference, position, velocity = rng.normal(size=(3, 50))
    ticks = LawTicks.at_samples(reference, position, velocity)
    error = reference - position
    total = np.cumsum(error) - error  # before each evaluation
    made = 150.0 * (60.0 * error + 1e-5 * total / 1e-3 - velocity)
    late = np.concatenate([made[:1], made[:1], made[:-2]])
    along = law_run.terms_along(axis, ticks, state_at_rest(axis, ticks)).sum(axis=1)
    np.testing.assert_allclose(along, late, rtol=1e-12, atol=1e-12)


def test_what_is_added_to_a_late_law_is_as_late(rng: np.random.Generator) -> None:
    added = rng.normal(size=9)
    ticks = LawTicks.at_samples(*np.zeros((3, 9)), added=added)
    assert ticks.added_at_samples(2).tolist() == [0.0, 0.0, *added[:-2]]


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
