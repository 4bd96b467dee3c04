"""The band is the jackknife's, exact for each group, and shown where noise is not what scatters."""

import numpy as np
import pytest

from axisid import Identification, build, identify, leave_out, load_axis, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.moves.lack_of_fit import bands_of, groupings


@pytest.fixture(scope="module")
def result(emps: GeneratedAxis) -> Identification:
    return identify(emps, twin_record(emps, seed=3), methods=["idm-ls", "ddm-ls"])


def test_estimates_without_a_group_are_those_of_the_other_rows(result: Identification) -> None:
    estimate = result["idm-ls"].with_inference(noise_free=None)
    for by, labels in groupings(result.data, estimate.rows.astype(np.intp)):
        names = np.unique(labels)
        others = [
            np.linalg.lstsq(estimate.X[labels != g], estimate.y[labels != g], rcond=None)[0]
            for g in names
        ]
        scatter = np.sum((np.array(others) - estimate.theta) ** 2, axis=0)
        expected = np.sqrt((len(names) - 1) / len(names) * scatter)
        bands = bands_of(estimate, [(by, labels)])
        assert [b.deviation for b in bands.values()] == pytest.approx(list(expected), rel=1e-6)
        assert all(b.groups == len(names) and b.by == by for b in bands.values())


def test_two_groups_tell_nothing(result: Identification) -> None:
    labels = np.arange(len(result["idm-ls"].y)) % 2
    assert bands_of(result["idm-ls"], [("halves", labels)]) == {}


def test_a_group_that_alone_tells_a_parameter_forms_none(result: Identification) -> None:
    estimate = result["idm-ls"]
    telling = np.zeros(len(estimate.y), dtype=np.intp)
    acceleration = np.abs(estimate.X[:, 0])
    telling[acceleration < 0.02 * acceleration.max()] = 1
    telling[1::2] += 2 * (telling[1::2] > 0)
    assert bands_of(estimate, [("acceleration", telling)]) == {}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [401, 403])
def test_noise_that_cancels_over_rows_shows_no_band(seed: int) -> None:
    """Behind a loop it is differentiated, and adds up at the edges of groups alone."""
    axis = build(load_axis("vertical_screw"))
    found = identify(axis, twin_record(axis, seed=seed), methods=["idm-iv", "didim"])
    assert not any(band.exceeds for band in found.diagnosis.bands["didim"].values())


@pytest.mark.slow
def test_a_force_that_the_model_lacks_shows_bands() -> None:
    whole = load_axis("rotary_table")
    axis = build(leave_out(whole, ca=0.0))
    found = identify(axis, twin_record(build(whole), seed=1), methods=["idm-iv", "didim"])
    assert all(any(b.exceeds for b in of.values()) for of in found.diagnosis.bands.values())


@pytest.mark.slow
def test_bands_are_seldom_shown_of_a_right_model(emps2015: GeneratedAxis) -> None:
    shown = []
    for seed in range(10):
        found = identify(emps2015, twin_record(emps2015, seed=seed), methods=["idm-iv"])
        shown += [band.exceeds for band in found.diagnosis.bands["idm-iv"].values()]
    assert np.mean(shown) < 0.1
