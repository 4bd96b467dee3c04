"""Samples near reversals and rests, where the low-pass rounds what friction does at once."""

import numpy as np
import pytest

from axisid import (
    Prefilter,
    Record,
    build,
    friction_ladder,
    identify,
    load_axis,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.methods import bound_record
from axisid.estimation.signals.filtered_record import FilteredRecord
from axisid.estimation.signals.sampling import near_turns
from tests.estimation.methods.test_partially_linear import TRUTH, stribeck_axis


def test_samples_no_further_than_the_reach_from_a_turn_or_a_rest_are_near_it() -> None:
    velocity = np.repeat([1.0, -1.0, 0.01, -1.0], 20)
    near = np.flatnonzero(near_turns(velocity, 3, 0.1))
    assert near.tolist() == [*range(20 - 3, 20 + 4), *range(40 - 3, 60 + 4)]


@pytest.fixture(scope="module")
def stribeck() -> GeneratedAxis:
    return build(stribeck_axis())


@pytest.mark.slow
@pytest.mark.parametrize(("cutoff", "decimate"), [(60.0, 10), (100.0, 10), (400.0, 20)])
@pytest.mark.parametrize("method", ["idm-ls", "idm-iv"])
def test_stribeck_friction_without_noise_is_found_whatever_the_filter(
    stribeck: GeneratedAxis, cutoff: float, decimate: int, method: str
) -> None:
    record = twin_record(stribeck, position_noise=0.0)
    found = identify(stribeck, record, Prefilter(cutoff=cutoff, decimate=decimate), method)
    assert found[method].physical == pytest.approx(list(TRUTH.values()), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "level"), [("belt_axis", "Fcp"), ("crank", "fc")])
def test_friction_of_linear_axes_comes_out_straighter(name: str, level: str) -> None:
    axis = build(load_axis(name))
    truth = axis.axis.experiment.truth[level]
    record = twin_record(axis)
    off = {}
    for reversals in ("keep", "leave-out"):
        filter_ = Prefilter.suited(record.period, reversals=reversals)
        value = identify(axis, record, filter_, "idm-ls")["idm-ls"].parameters[level].value
        off[reversals] = abs(value / truth - 1)
    assert off["leave-out"] < 0.2 * off["keep"]


def test_default_leaves_them_out_where_there_is_friction(
    emps2015: GeneratedAxis, twin: Record, stribeck: GeneratedAxis
) -> None:
    for axis, record in ((emps2015, twin), (stribeck, twin_record(stribeck))):
        chosen = FilteredRecord.bind(axis, record, Prefilter())
        assert chosen.prefilter.reversals == "leave-out"
        assert chosen.sampling.excluded_samples > 0
    rungs = friction_ladder(emps2015.declared)
    smooth = build(rungs["viscous"])
    assert FilteredRecord.bind(smooth, twin, Prefilter()).prefilter.reversals == "keep"
    assert FilteredRecord.bind(smooth, twin, Prefilter()).excluded == ()


def test_rows_and_signals_stay_together_and_what_is_silent_enters_none(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    data = bound_record(emps2015, twin, Prefilter(reversals="leave-out"))
    spoilt = np.array(twin.control)
    for start, stop in data.excluded:
        spoilt[start:stop] = 1e3
    clean = data.reduce(np.asarray(twin.control))
    assert np.array_equal(data.reduce(spoilt), clean)
    assert len(data.sampling.rows) == len(clean)
    result = identify(emps2015, twin, data.prefilter)
    assert len(result["idm-iv"].rows) == len(result["idm-iv"].y)
    excluded = data.sampling.excluded_samples
    assert f"{excluded} samples near reversals" in " ".join(result.summary(every=True).split())
    assert result.to_dict()["prefilter"]["silent"] == excluded


def test_instruments_are_weighted_as_the_regressor_is(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    filter_ = Prefilter(reversals="leave-out")
    iv, direct = (identify(emps2015, twin, filter_)[m] for m in ("idm-iv", "ddm-iv"))
    assert iv.physical == pytest.approx(direct.physical, rel=1e-9)
