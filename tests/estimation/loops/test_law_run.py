"""A law along a record, by hand, and in pieces, each from where the one before it ended."""

import numpy as np
import pytest

from axisid import Record, build
from axisid.codegen import GeneratedAxis
from axisid.estimation.loops import LawTicks, law_run, law_ticks, state_at_rest
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
