"""Lanes that are identified side by side are what each record gives alone."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Estimate,
    Prefilter,
)
from axisid.codegen import GeneratedAxis
from axisid.estimation import LaneEstimates, RecordLanes, identify_lanes, simulate_batch
from axisid.estimation.simulation.twin import trajectory
from tests.refusals import refuses
from tests.unjudged import identify

PERIOD = 1e-3
PUBLISHED = Prefilter(cutoff=60.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


@pytest.fixture(scope="module")
def lanes(emps2015: GeneratedAxis) -> RecordLanes:
    reference = trajectory(emps2015.axis.experiment.moves, PERIOD)[:5000].copy()
    noise = 1e-6 * np.random.default_rng(3).normal(size=(len(reference), 3))
    sets = np.tile([100.2, 236.9, 24.8], (3, 1))
    wanted = ("position", "control")
    made = simulate_batch(emps2015, sets, reference, PERIOD, position_noise=noise, wanted=wanted)
    return RecordLanes(
        reference=reference,
        position=made["position"] + noise,
        control=made["control"],
        period=PERIOD,
    )


def _agree(found: LaneEstimates, lane: int, alone: Estimate) -> None:
    np.testing.assert_allclose(found.values[lane], alone.physical, rtol=1e-9)
    for name, matrix in alone.covariances.items():
        deviations = np.sqrt(np.diag(matrix))
        np.testing.assert_allclose(found.deviations[name][lane], deviations, rtol=1e-7)
        np.testing.assert_allclose(found.freedom[name][lane], alone.freedom[name], rtol=1e-7)
    assert found.iterations[lane] == len(alone.iterates) - 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "prefilter",
    [
        None,
        Prefilter(cutoff=60.0, decimate=10, reversals="keep"),
        PUBLISHED,
        Prefilter(cutoff=60.0, decimate=1, reversals="keep"),
    ],
)
def test_a_lane_is_what_identify_makes_of_its_record(
    emps2015: GeneratedAxis, lanes: RecordLanes, prefilter: Prefilter | None
) -> None:
    found = identify_lanes(emps2015, lanes, prefilter=prefilter)
    assert "side by side" in found.how
    lane = found.how.index("side by side")
    alone = identify(emps2015, lanes.record(lane), prefilter, ["idm-iv"], bootstrap=0)
    _agree(found, lane, alone["idm-iv"])


def test_without_a_compiler_lanes_are_identified_alone(
    emps2015: GeneratedAxis, lanes: RecordLanes, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = identify_lanes(emps2015, lanes, prefilter=PUBLISHED)
    monkeypatch.setattr(emps2015.native, "lanes", None)
    plain = identify_lanes(emps2015, lanes, prefilter=PUBLISHED)
    assert compiled.how == ("side by side",) * 3
    assert plain.how == ("alone",) * 3
    np.testing.assert_allclose(plain.values, compiled.values, rtol=1e-9)
    np.testing.assert_allclose(plain.deviations["hac"], compiled.deviations["hac"], rtol=1e-7)


def test_a_lane_is_the_same_to_the_last_bit_in_any_company(
    emps2015: GeneratedAxis, lanes: RecordLanes
) -> None:
    together = identify_lanes(emps2015, lanes, prefilter=PUBLISHED)
    alone = identify_lanes(emps2015, lanes.part(slice(2, 3)), prefilter=PUBLISHED)
    assert np.array_equal(together.values[2:], alone.values)
    assert np.array_equal(together.deviations["hac"][2:], alone.deviations["hac"])


def test_lags_that_are_too_many_are_told_of_each_lane(
    emps2015: GeneratedAxis, lanes: RecordLanes
) -> None:
    found = identify_lanes(emps2015, lanes, prefilter=PUBLISHED, lags=len(lanes.reference))
    assert found.how == ("failed",) * 3
    assert "lags are too many" in found.errors[2]
    assert np.isnan(found.values).all()


def test_what_is_not_served_is_identified_alone(
    emps2015: GeneratedAxis, lanes: RecordLanes
) -> None:
    found = identify_lanes(emps2015, lanes.part(slice(0, 1)), "idm-ls", PUBLISHED)
    assert found.how == ("alone",)
    alone = identify(emps2015, lanes.record(0), PUBLISHED, ["idm-ls"])["idm-ls"]
    assert np.array_equal(found.values[0], alone.physical)


def test_a_lane_that_cannot_be_identified_is_told_and_the_others_are_not_harmed(
    emps2015: GeneratedAxis, lanes: RecordLanes
) -> None:
    position = lanes.position.copy()
    position[100, 1] = np.nan
    found = identify_lanes(emps2015, replace(lanes, position=position), prefilter=PUBLISHED)
    assert found.how == ("side by side", "failed", "side by side")
    assert "position" in found.errors[1]
    assert np.all(np.isnan(found.values[1]))
    alone = identify(emps2015, lanes.record(2), PUBLISHED, ["idm-iv"], bootstrap=0)
    _agree(found, 2, alone["idm-iv"])


def test_lanes_of_other_shapes_are_refused(lanes: RecordLanes) -> None:
    with refuses("simulation-input"):
        replace(lanes, control=lanes.control[:, :2])
