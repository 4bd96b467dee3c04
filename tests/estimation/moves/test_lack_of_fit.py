"""Residuals are split as they were made: into what repeats and noise."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, Prefilter, Record, identify, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.moves import LackOfFit, lack_of_fit
from axisid.support.arrays import Array


@pytest.fixture(scope="module")
def result(emps: GeneratedAxis) -> Identification:
    return identify(emps, twin_record(emps, seed=3), methods=["idm-ls"])


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
