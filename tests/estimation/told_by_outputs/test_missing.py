"""What errors ask for is told from chance, and is not guessed where too few windows tell it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid.estimation.told_by_outputs.colour import autoregression_of
from axisid.estimation.told_by_outputs.missing import Left, lacking_of
from axisid.support.arrays import Array

_WINDOWS, _LONG, _KNOWN = 12, 40, 3
_LEVEL = 0.002


def _left(random: np.random.Generator, added: Array | float = 0.0, *, by_windows: bool) -> Left:
    """White noise of a right model with three parameters, and what is added to it."""
    rows = _WINDOWS * _LONG
    J = random.standard_normal((rows, _KNOWN))
    inverse = np.linalg.inv(J.T @ J)
    errors = random.standard_normal(rows) + added
    return Left(
        errors=errors - J @ (inverse @ (J.T @ errors)),
        weights=np.ones(rows),
        curvature=np.ones(rows),
        jacobian=J,
        inverse=inverse,
        known=np.zeros((0, _KNOWN)),
        counted=np.ones(rows, dtype=bool),
        spans=(tuple(slice(i * _LONG, (i + 1) * _LONG) for i in range(_WINDOWS)),),
        periods=(1e-2,),
        by_windows=by_windows,
    )


def _column(random: np.random.Generator, active: int) -> Array:
    """Of a force that acts in so many windows."""
    values = random.standard_normal((_WINDOWS, _LONG))
    values[active:] = 0.0
    return values.reshape(-1, 1)


@pytest.mark.parametrize(("active", "told"), [(1, 0), (2, 0), (4, 0), (8, 0), (12, 1)])
def test_a_force_in_few_windows_is_not_told_from_chance(
    rng: np.random.Generator, active: int, told: int
) -> None:
    runs = [
        lacking_of(_left(rng, by_windows=True), _column(rng, active), 1, _LEVEL) for _ in range(50)
    ]
    assert all(len(found) == told for found in runs)
    assert not any(each.chance <= _LEVEL for found in runs for each in found)


def test_a_force_in_enough_windows_is_told(rng: np.random.Generator) -> None:
    column = _column(rng, _WINDOWS)
    (found,) = lacking_of(_left(rng, column[:, 0], by_windows=True), column, 1, _LEVEL)
    assert found.chance < 1e-4
    assert abs(-found.factor - 1) < 4 * found.deviation


def test_an_order_beyond_short_stretches_has_its_uncertainty(rng: np.random.Generator) -> None:
    pieces = [0.5 * np.sin(np.arange(30) / 3 + a) for a in rng.uniform(0, 6, 200)]
    model = autoregression_of(pieces, 1e-4)
    longer = replace(
        model,
        coefficients=np.r_[1.0, -0.5, np.zeros(78)],
        covariances=0.5 ** np.arange(80.0) / 0.75,
        variance=1.0,
    )
    assert longer.order > 2 * max(map(len, pieces))
    assert np.isfinite(longer.uncertainty(pieces, 6000))


def test_how_sure_a_variance_of_one_output_is_follows_from_its_errors() -> None:
    column = np.random.default_rng(0).normal(size=300)
    variances, claimed = [], []
    for seed in range(150):
        e = lfilter([1.0], [1.0, -1.2, 0.5], np.random.default_rng(seed).normal(size=3000))
        model = autoregression_of([e], 1e-3)
        variances.append(model.coloured(column[:, None])[0, 0])
        claimed.append(model.uncertainty([column], 3000))
    scatter = np.var(variances, ddof=1) / np.mean(variances) ** 2
    assert np.mean(claimed) == pytest.approx(scatter, rel=0.3)
