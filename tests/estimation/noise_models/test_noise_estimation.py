"""The parts of the measurement of noise, each against an independent reference."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from axisid.estimation.noise_models.noise_estimation import (
    _SQUARES_PER_POWER,
    RowSpectrum,
    _autoregressions,
    _independent_powers,
    _log_likelihood,
    _white_noise_level,
    power_about_another_mean,
)

DRAWS = 4000


@pytest.mark.parametrize("count", [2, 8])
def test_power_about_another_mean_is_that_of_a_further_series(
    rng: np.random.Generator, count: int
) -> None:
    *several, further = rng.normal(size=(count + 1, DRAWS * 10))
    mean = np.mean(several, axis=0)
    own = np.mean([np.var(each - mean) for each in several])
    assert power_about_another_mean(count) * own == pytest.approx(np.var(further - mean), rel=0.05)
    assert power_about_another_mean(1) == 2.0


def test_squares_of_second_differences_count_as_so_many_independent_powers(
    rng: np.random.Generator,
) -> None:
    """A mean of n exponential powers has the relative variance 1/n."""
    samples = 60
    means = np.mean(np.diff(rng.normal(size=(DRAWS, samples + 2)), 2) ** 2, axis=1)
    assert samples / _SQUARES_PER_POWER == pytest.approx(means.mean() ** 2 / means.var(), rel=0.1)


def test_twins_have_as_many_independent_powers_as_their_scatter_shows(
    rng: np.random.Generator,
) -> None:
    counts = np.array([50.0, 50.0, 5.0, 50.0])
    shapes = np.array([10.0, 1000.0, 10.0, 10.0])
    steps = rng.gamma(shapes, 3.0 / shapes, size=(DRAWS, 4))
    steps[:, 3] = 2.0  # that do not scatter
    found = _independent_powers(counts, steps)
    assert found == pytest.approx([10.0, 50.0, 5.0, 50.0], rel=0.06)
    two = np.array([[1.0], [3.0]])
    assert _independent_powers(np.array([50.0]), two) == pytest.approx([2.0], rel=1e-12)
    np.testing.assert_array_equal(_independent_powers(counts, steps[:1]), counts)


def test_the_likelihood_is_that_of_means_of_exponential_powers() -> None:
    power, counts = np.array([1.2, 0.4, 2.5]), np.array([3.0, 8.0, 20.0])
    units, known = np.array([[1.0, 0.5, 0.2], [0.1, 0.3, 1.0]]), np.array([0.2, 0.1, 0.05])
    sets = np.array([[1.0, 2.0], [0.3, 0.1], [0.0, 4.0]])
    expected = sets @ units + known
    wanted = stats.gamma.logpdf(power, counts, scale=expected / counts).sum(axis=1)
    found = _log_likelihood(sets, power, units, known, counts)
    assert found - found[0] == pytest.approx(wanted - wanted[0], rel=1e-9)


def test_autoregressions_are_those_that_a_band_shows() -> None:
    """One is left out that makes a thousandth of the power of every band, or less."""
    units = np.array([[1.0, 1.0], [2.0, 0.1], [1.0, 1.0]])
    power = np.array([4.0, 100.0])
    found = _autoregressions([0.0, 0.1, 0.2], units, power, np.array([9.0, 0.0021, 0.0039]))
    assert [time for time, _ in found] == [0.0, 0.1]
    assert [sd for _, sd in found] == pytest.approx([3.0, np.sqrt(0.0021)])


def test_white_noise_is_measured_within_the_pieces_of_a_record(rng: np.random.Generator) -> None:
    noise = 0.3 * rng.normal(size=20_000)
    noise[10_000:] += 1e3  # across the gap
    quiet = np.linspace(0.0, 50.0, 20_000) ** 2
    spans = ((0, 10_000), (10_000, 20_000))
    record: Any = SimpleNamespace(velocity=quiet + noise, acceleration=None, spans=spans)
    known: Any = SimpleNamespace(velocity=quiet, acceleration=None)
    assert _white_noise_level(record, known, "velocity") == pytest.approx(0.3, rel=0.03)
    assert _white_noise_level(record, known, "acceleration") is None
    short: Any = SimpleNamespace(velocity=noise[:2], spans=((0, 2),))
    assert _white_noise_level(short, SimpleNamespace(velocity=noise[:2]), "velocity") == 0.0  # type: ignore[arg-type]


def spectrum_of(rows: int, waves_a_record: tuple[int, ...]) -> RowSpectrum:
    """Of rows of which every tenth is missing, with columns of sines."""
    places = np.flatnonzero(np.arange(rows) % 10 != 3)
    waves = np.sin(np.outer(places, waves_a_record) * 2 * np.pi / rows)
    basis = np.linalg.qr(waves)[0]
    bands = np.array([1, 2, 4, 9, 20, 60, 120])
    return RowSpectrum(places=places, basis=basis, bands=bands, counts=np.ones(6)).counted()


def test_a_spectrum_of_rows_is_flat_for_white_noise_beside_its_columns(
    rng: np.random.Generator,
) -> None:
    rows = spectrum_of(400, (1, 10, 12, 14, 16, 25, 40))
    noise = rng.normal(size=(len(rows.places), DRAWS // 4))
    there = rows.power(noise)[2:]  # below, a column takes most of a band
    assert there == pytest.approx(np.ones(4), rel=0.03)
    assert rows.counts[3] < 0.9 * 11
    with_columns = noise + 50.0 * rows.basis[:, :1]
    assert rows.power(with_columns) == pytest.approx(rows.power(noise), rel=1e-9)
    other = rng.normal(size=noise.shape)
    assert rows.power(noise + other, other)[2:] == pytest.approx(np.ones(4), rel=0.05)
    assert np.all(np.abs(rows.power(noise, other)[2:]) < 0.05)
