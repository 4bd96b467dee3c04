"""A problem: rows of one record, of one with gaps, of several, are one regression."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter, Record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.methods import METHODS, estimate_by
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
    assert two.noise_free == pytest.approx(one.noise_free, rel=1e-6, abs=1e-9)
