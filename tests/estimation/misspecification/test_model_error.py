"""Repeats are found in the reference alone, and residuals split by them.

Bands for the model's error are the delete-one-group jackknife's.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid import (
    Identification,
    Prefilter,
    Record,
    build,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.model_error_checks import ResidualAtRepeats
from axisid.estimation.misspecification.model_error import (
    LackOfFit,
    groupings,
    jackknife_intervals,
    lack_of_fit,
    repeated_part,
)
from axisid.support.arrays import Array
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of


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


@pytest.mark.slow
def test_what_repeats_is_told_from_noise(result: Identification, rng: np.random.Generator) -> None:
    own = repeated(result)
    found = split(result, own + 0.3 * rng.normal(size=len(own)))
    power = float(np.mean(own**2))
    assert found.share == pytest.approx(power / (power + 0.09), abs=0.03)
    assert found.noise == pytest.approx(0.3, rel=0.1)
    assert found.repeated == pytest.approx(np.sqrt(power), rel=0.05)
    assert found.is_mostly_model


@pytest.mark.slow
def test_noise_does_not_repeat_however_sluggish_it_is(
    result: Identification, rng: np.random.Generator
) -> None:
    found = [
        split(result, lfilter([1.0], [1.0, -pole], rng.normal(size=len(result["idm-ls"].y))))
        for pole in 20 * (0.0, 0.9, 0.98)
    ]
    assert np.mean([each.is_there for each in found]) < 0.05
    assert np.mean([each.is_mostly_model for each in found]) < 0.02


def test_steps_that_repeat_are_not_called_the_model(
    result: Identification, rng: np.random.Generator
) -> None:
    rows, (position, velocity, _) = result["idm-ls"].rows.astype(int), result.data.motion
    places = np.round(position[rows] * 1e4) + 0.5 * (velocity[rows] > 0)
    _, place = np.unique(places, return_inverse=True)
    found = split(result, rng.normal(size=place.max() + 1)[place])
    assert found.share > 0.1 or not found.is_there
    assert not found.is_mostly_model


@pytest.mark.slow
def test_rows_that_are_left_out_keep_their_phase(emps: GeneratedAxis) -> None:
    record = twin_record(emps, seed=3)
    whole, without = (
        identify(emps, each, methods=["idm-ls"]).diagnosis.lack_of_fit
        for each in (record, replace(record, masked=((5000, 5600),)))
    )
    assert without.period == whole.period
    assert without.rows < whole.rows
    assert without.share == pytest.approx(whole.share, abs=0.15)


@pytest.mark.slow
def test_the_public_record_is_left_by_the_model(emps: GeneratedAxis, emps_record: Record) -> None:
    prefilter = Prefilter(cutoff=100, drop=(49, 0), hold="raw", reversals="keep")
    result = identify(emps, emps_record, prefilter, methods=["idm-iv"])
    found, band = result.diagnosis.lack_of_fit, result.diagnosis.bands["idm-iv"]["Fv"]
    told = [found.period, found.share, found.noise, band.deviation]
    assert np.all(np.abs(np.subtract(told, [6.24, 0.98, 0.31, 14.0])) < [1e-5, 0.02, 0.1, 4.0])
    assert band.exceeds
    check = checks_of(result)["lack of fit"]
    assert check.status == "note"
    assert finding_of(check, ResidualAtRepeats).nature == "systematic"


def move(length: float, samples: int = 400) -> Array:
    phase = np.linspace(0, np.pi, samples, endpoint=False)
    return np.asarray(length * (1 - np.cos(phase)) / 2)


ONCE = np.concatenate([move(1.0), 1.0 - move(0.4), 0.6 + move(0.3), 0.9 - move(0.9)])


def test_the_period_is_that_of_the_reference() -> None:
    assert repeated_part(np.tile(ONCE, 4)) == (0, 4 * len(ONCE), len(ONCE))


@pytest.mark.parametrize("period", [57.3, 100.5, 142.857])
def test_a_period_may_be_of_parts_of_a_sample(period: float) -> None:
    assert repeated_part(np.sin(2 * np.pi * np.arange(20_000) / period)) == (
        *(0, 20_000),
        pytest.approx(period, abs=1 / 150),
    )


def test_last_digits_do_not_matter(rng: np.random.Generator) -> None:
    reference = np.round(np.tile(ONCE, 3), 5) + 1e-6 * rng.normal(size=3 * len(ONCE))
    first, stop, period = repeated_part(reference)
    assert period == pytest.approx(len(ONCE), abs=2)
    assert stop - first > 0.9 * len(reference)


def test_what_repeats_may_be_a_part() -> None:
    head = [move(0.2), 0.2 - move(0.2), move(0.7), 0.7 - move(0.7)]
    first, stop, period = repeated_part(np.concatenate([*head, ONCE, ONCE, 0.5 * move(1.0)]))
    assert (first, stop, period) == (
        pytest.approx(4 * 400, abs=50),
        pytest.approx(4 * 400 + 2 * len(ONCE), abs=50),
        len(ONCE),
    )


HILLS = [scale * np.concatenate([move(1.0), 1.0 - move(1.0)]) for scale in (1.0, 1.1, 1.2)]


@pytest.mark.parametrize(
    "reference",
    [
        np.concatenate(HILLS),
        np.zeros(500),
        np.full(500, np.nan),
        np.arange(500.0),
        np.cumsum(np.random.default_rng(13).normal(size=3000)) * 1e-6,
    ],
)
def test_no_motion_noise_and_moves_of_other_sizes_repeat_nothing(reference: Array) -> None:
    assert repeated_part(reference) is None


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
