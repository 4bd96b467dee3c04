"""Every library axis from its twin: the intervals hold the truth."""

from functools import cache

import numpy as np
import pytest

from axisid import Identification, derive, identify, load_axis, twin_record
from axisid.codegen.artefacts.texts import axis_artefacts
from axisid.modeling import LIBRARY
from benchmarks.library import outside, prefilter_of
from tests.bounded import within

NO_DIRECT_MODEL = ("crank", "linear_motor")


@cache
def identified(name: str) -> Identification:
    axis = load_axis(name)
    return identify(axis, twin_record(axis), prefilter_of(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_least_squares_and_instruments_recover_the_twin(name: str) -> None:
    """To three deviations, or to a thousandth: noise biases least squares by less than that.

    One noise; `benchmarks/library.py` counts over many how often 95 % intervals hold the truth.
    """
    result = identified(name)
    direct = [] if name in NO_DIRECT_MODEL else ["ddm-ls", "ddm-iv"]
    assert set(result.estimates) == {"idm-ls", "idm-iv", "didim", *direct}
    truth = result.record.provenance.truth
    for method, estimate in result.estimates.items():
        for p, value in estimate.parameters.items():
            allowed = max(3 * value.deviation, 1e-3 * abs(truth[p]))
            assert abs(value.corrected - truth[p]) < allowed, (method, p)


@pytest.mark.slow
def test_nearly_all_95_percent_intervals_of_the_library_hold_the_truth() -> None:
    missed = {name: outside(identified(name)) for name in LIBRARY}
    intervals = sum(len(e.theta) for name in LIBRARY for e in identified(name).estimates.values())
    assert intervals > 100
    assert sum(map(len, missed.values())) <= 0.05 * intervals, missed


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_intervals_are_of_use(name: str) -> None:
    for value in identified(name)["idm-iv"].parameters.values():
        assert value.sd_hac < 0.25 * abs(value.value)


@pytest.mark.parametrize("name", LIBRARY)
def test_twins_stay_within_what_their_drive_can_do(name: str) -> None:
    axis, record = load_axis(name), twin_record(load_axis(name))
    assert np.abs(record.control).max() < 0.9 * axis.drive.limit


@pytest.mark.slow
def test_every_library_axis_derives_and_generates_within_its_bound() -> None:
    for name in LIBRARY:
        with within(1_500_000):
            texts = axis_artefacts(derive(load_axis(name)))
        assert all(texts.values()), name
