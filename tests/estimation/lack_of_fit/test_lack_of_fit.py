"""Residuals are split as they were made; bands are the jackknife's, exact for each group."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Prefilter,
    Record,
    build,
    identify,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.lack_of_fit import LackOfFit, lack_of_fit
from axisid.estimation.lack_of_fit.repeated_phases import bands_of, groupings
from axisid.support.arrays import Array


@pytest.fixture(scope="module")
def result(emps: GeneratedAxis) -> Identification:
    return identify(emps, twin_record(emps, seed=3), methods=["idm-ls", "ddm-ls"])


def split(result: Identification, residuals: Array) -> LackOfFit:
    estimate = replace(result["idm-ls"], residuals=residuals).with_inference(noise_free=None)
    return lack_of_fit(estimate, result.data)


def repeated(result: Identification) -> Array:
    """What a smooth function of position and direction leaves, N."""
    position, velocity, _ = result.data.motion
    rows = result["idm-ls"].rows.astype(int)
    return np.asarray(np.sin(40 * position[rows]) * np.sign(velocity[rows]))


def test_what_repeats_is_told_from_noise(result: Identification, rng: np.random.Generator) -> None:
    own = repeated(result)
    found = split(result, own + 0.3 * rng.normal(size=len(own)))
    power = float(np.mean(own**2))
    assert found.share == pytest.approx(power / (power + 0.09), abs=0.03)
    assert found.noise == pytest.approx(0.3, rel=0.1)
    assert found.repeated == pytest.approx(np.sqrt(power), rel=0.05)
    assert found.is_mostly_model
    assert min(found.hac_excess.values()) > 1


@pytest.mark.slow
def test_noise_does_not_repeat_however_sluggish_it_is(
    result: Identification, rng: np.random.Generator
) -> None:
    rows = len(result["idm-ls"].y)
    said, blamed = [], []
    for pole in (0.0, 0.9, 0.98):
        for _ in range(20):
            noise = rng.normal(size=rows)
            for i in range(1, rows):
                noise[i] += pole * noise[i - 1]
            found = split(result, noise)
            said.append(found.is_there)
            blamed.append(found.is_mostly_model)
    assert np.mean(said) < 0.05
    assert np.mean(blamed) < 0.02


def test_steps_that_repeat_are_not_called_the_model(
    result: Identification, rng: np.random.Generator
) -> None:
    rows = result["idm-ls"].rows.astype(int)
    by_place = {}
    position, velocity, _ = result.data.motion
    for i, row in enumerate(rows):
        key = round(float(position[row]) * 1e4), velocity[row] > 0
        by_place.setdefault(key, []).append(i)
    steps = np.zeros(len(rows))
    for places in by_place.values():
        steps[places] = rng.normal()
    found = split(result, steps)
    assert found.share > 0.1 or not found.is_there
    assert not found.is_mostly_model


@pytest.mark.slow
def test_rows_that_are_left_out_keep_their_phase(emps: GeneratedAxis) -> None:
    record = twin_record(emps, seed=3)
    every = identify(emps, record, methods=["idm-ls"])
    parted = identify(emps, replace(record, masked=((5000, 5600),)), methods=["idm-ls"])
    whole, without = every.diagnosis.lack_of_fit, parted.diagnosis.lack_of_fit
    assert without.period == whole.period
    assert without.rows < whole.rows
    assert without.share == pytest.approx(whole.share, abs=0.15)


@pytest.mark.slow
def test_the_public_record_is_left_by_the_model(emps: GeneratedAxis, emps_record: Record) -> None:
    prefilter = Prefilter(cutoff=100, drop=(49, 0), hold="raw", reversals="keep")
    result = identify(emps, emps_record, prefilter, methods=["idm-iv"])
    found = result.diagnosis.lack_of_fit
    assert found.period == pytest.approx(6.24)
    assert found.share == pytest.approx(0.97, abs=0.02)
    assert found.noise == pytest.approx(0.35, abs=0.1)
    assert all(6 < ratio < 16 for ratio in found.hac_excess.values())
    (check,) = (c for c in result.verdict if c.name == "lack of fit")
    assert check.status == "note"
    assert " % of what the model leaves is the model: " in check.meaning
    band = result.diagnosis.bands["idm-iv"]["Fv"]
    assert band.exceeds
    assert 25 < band.deviation < 45


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
