"""Bands for the model's error are the delete-one-group jackknife's."""

import numpy as np
import pytest

from axisid import Identification, Record, build, identify, leave_out, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.misspecification.model_error import groupings, jackknife_intervals


@pytest.fixture(scope="module")
def result(emps: GeneratedAxis) -> Identification:
    return identify(emps, twin_record(emps, seed=3), methods=["idm-ls", "ddm-ls"])


def test_estimates_without_a_group_are_those_of_the_other_rows(result: Identification) -> None:
    estimate = result["idm-ls"].with_inference(noise_free=None)
    for by, labels in groupings(result.data, estimate.rows.astype(np.intp)).items():
        names = np.unique(labels)
        others = [
            np.linalg.lstsq(estimate.X[labels != g], estimate.y[labels != g], rcond=None)[0]
            for g in names
        ]
        scatter = np.sum((np.array(others) - estimate.theta) ** 2, axis=0)
        expected = np.sqrt((len(names) - 1) / len(names) * scatter)
        bands = jackknife_intervals(estimate, {by: labels})
        assert [b.deviation for b in bands.values()] == pytest.approx(list(expected), rel=1e-6)
        assert all(b.groups == len(names) and b.by == by for b in bands.values())


def test_two_groups_or_one_that_alone_tells_a_parameter_tell_nothing(
    result: Identification,
) -> None:
    estimate = result["idm-ls"]
    halves = np.arange(len(estimate.y)) % 2
    acceleration = np.abs(estimate.X[:, 0])
    telling = 1 * (acceleration < 0.02 * acceleration.max())
    telling[1::2] += 2 * (telling[1::2] > 0)
    for labels in (halves, telling):
        assert jackknife_intervals(estimate, {"groups": labels}) == {}


@pytest.mark.slow
def test_bands_show_what_the_model_lacks_and_seldom_noise(emps2015: GeneratedAxis) -> None:
    """Behind a loop noise is differentiated, and adds up at the edges of groups alone."""

    def shown(axis: GeneratedAxis, record: Record, method: str) -> list[bool]:
        found = identify(axis, record, methods=["idm-iv", "didim"]).diagnosis.bands
        return [band.exceeds for band in found[method].values()]

    screw = build(load_axis("vertical_screw"))
    for seed in (401, 403):
        assert not any(shown(screw, twin_record(screw, seed=seed), "didim"))
    right = [shown(emps2015, twin_record(emps2015, seed=seed), "idm-iv") for seed in range(10)]
    assert np.mean(right) < 0.1
    whole = load_axis("rotary_table")
    lacking, record = build(leave_out(whole, ca=0.0)), twin_record(build(whole), seed=1)
    assert all(any(shown(lacking, record, method)) for method in ("idm-iv", "didim"))
