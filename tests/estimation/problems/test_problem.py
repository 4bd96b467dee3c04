"""A problem: rows of one record, of one with gaps, of several, are one regression."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter, Record, identify, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import Estimate
from axisid.estimation.methods import METHODS, bound_record, estimate_by
from axisid.estimation.problems import Problem
from axisid.estimation.signals import FilteredRecord

CUT = 4000


def part(record: Record, start: int, stop: int) -> Record:
    def cut(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[start:stop]

    return replace(
        record,
        time=record.time[start:stop],
        position=record.position[start:stop],
        control=cut(record.control),
        force=cut(record.force),
        reference=cut(record.reference),
    )


def problem(axis: GeneratedAxis, *records: Record, **settings: object) -> Problem:
    filter_ = Prefilter(**settings)  # type: ignore[arg-type]
    data = tuple(FilteredRecord.bind(axis, record, filter_) for record in records)
    return Problem(axis=axis, data=data)


@pytest.fixture(scope="module")
def halves(twin: Record) -> tuple[Record, Record]:
    return part(twin, 0, CUT), part(twin, CUT, len(twin))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("reversals", ["keep", "leave-out"])
def test_a_record_with_a_gap_and_its_two_parts_are_the_same_thing(
    emps2015: GeneratedAxis,
    twin: Record,
    halves: tuple[Record, Record],
    method: str,
    reversals: str,
) -> None:
    cut = replace(twin, segments=((0, CUT), (CUT, len(twin))))
    one, two = (
        estimate_by(problem(emps2015, *records, reversals=reversals), METHODS[method])
        for records in ((cut,), halves)
    )
    assert two.physical == pytest.approx(one.physical, rel=1e-12)
    for name, covariance in one.covariances.items():
        assert two.covariances[name] == pytest.approx(covariance, rel=1e-9)
    same = ("durbin_watson", "cross_z")
    for name in same:
        ours, theirs = (getattr(e.residual_tests, name) for e in (two, one))
        assert ours == pytest.approx(theirs, rel=1e-9)
    assert two.simulation_error_percent == pytest.approx(one.simulation_error_percent, rel=1e-9)
    assert one.noise_free is not None
    assert two.noise_free is not None
    assert two.noise_free == pytest.approx(one.noise_free, rel=1e-6, abs=1e-9)


def test_one_record_is_what_identify_makes_of_it(emps2015: GeneratedAxis, twin: Record) -> None:
    bound = Problem(axis=emps2015, data=(bound_record(emps2015, twin, Prefilter()),))
    found = estimate_by(bound, METHODS["idm-iv"])
    expected = identify(emps2015, twin, Prefilter(), "idm-iv", bootstrap=0)["idm-iv"]
    assert np.array_equal(found.physical, expected.physical)
    assert np.array_equal(found.covariances["hac"], expected.covariances["hac"])


def test_several_records_tell_more_than_one(emps2015: GeneratedAxis) -> None:
    truth = np.array([100.2, 236.9, 24.8])
    records = [twin_record(emps2015, seed=seed) for seed in range(3)]
    three = estimate_by(problem(emps2015, *records), METHODS["idm-iv"])
    singles = [estimate_by(problem(emps2015, r), METHODS["idm-iv"]) for r in records]
    mean = np.mean([_deviations(one) for one in singles], axis=0)
    assert _deviations(three) == pytest.approx(mean / np.sqrt(3), rel=0.25)
    assert np.all(np.abs(three.corrected - truth) < 4 * _deviations(three))
    assert len(three.y) == sum(len(one.y) for one in singles)
    assert three.times is not None
    assert len(three.times) == len(three.rows) == len(three.neighbours)


def _deviations(estimate: Estimate) -> np.ndarray:
    return np.sqrt(np.diag(estimate.covariances["hac"]))


def test_a_problem_is_pickled_without_what_it_computed(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    made = problem(emps2015, twin)
    before = len(pickle.dumps(made))
    first = estimate_by(made, METHODS["idm-ls"])
    assert len(pickle.dumps(made)) == before
    again = estimate_by(pickle.loads(pickle.dumps(made)), METHODS["idm-ls"])  # noqa: S301
    assert np.array_equal(again.physical, first.physical)
