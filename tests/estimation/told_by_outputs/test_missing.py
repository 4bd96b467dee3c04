"""What errors ask for is told from chance, and is not guessed where too few windows tell it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import f

from axisid.estimation.told_by_outputs.colour import autoregression_of
from axisid.estimation.told_by_outputs.missing import Asking, Left, lacking_of
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


def _two(random: np.random.Generator, ratios: Sequence[float]) -> tuple[Left, Array]:
    """Errors that ask for a force, and for what is held, by so many deviations."""
    left = _left(random, by_windows=False)
    whole = np.column_stack([left.jacobian, random.standard_normal((len(left.errors), 2))])
    columns = np.linalg.qr(whole)[0][:, _KNOWN:]
    errors = left.errors - columns @ (columns.T @ left.errors)
    return replace(left, errors=errors + columns @ np.array(ratios)), columns


@pytest.mark.parametrize(("ratios", "first"), [((5.5, 2.9), 0), ((9.0, 7.0), 1)])
def test_what_is_held_comes_before_a_force_where_it_is_more_than_chance(
    rng: np.random.Generator, ratios: tuple[float, float], first: int
) -> None:
    left, columns = _two(rng, ratios)
    found = lacking_of(left, columns, 1, _LEVEL, held=1)
    assert found[0].number == first
    assert found[0].chance <= _LEVEL


@pytest.mark.parametrize("freedom", [5.0, 200.0])
def test_two_columns_of_one_force_are_as_often_chance_as_f_says(freedom: float) -> None:
    found = Asking(width=2).chance(1.0, 3.0, freedom)
    assert found == pytest.approx(float(f.sf(3.0**2 / 2, 2, freedom)))
    assert Asking(width=2, tried=7).chance(1.0, 3.0, freedom) == pytest.approx(min(7 * found, 1.0))


@pytest.mark.slow
def test_the_best_of_a_grid_is_told_of_noise_no_more_often_than_is_said(
    rng: np.random.Generator,
) -> None:
    """Of 20 places: at 10 % no more than 25 of 150 right records, 1 chance in 100."""
    told = 0
    for _ in range(150):
        left = _left(rng, by_windows=False)
        columns = rng.standard_normal((len(left.errors), 20))
        best = np.argmax(np.abs(left.beside(columns)[0].T @ left.errors))
        asking = [Asking(tried=20)]
        (found,) = lacking_of(left, columns[:, [best]], 1, _LEVEL, asking=asking)
        told += found.chance <= 0.1
    assert 2 < told <= 25


def test_beside_what_is_last_nothing_is_told(rng: np.random.Generator) -> None:
    left, columns = _two(rng, (12.0, 9.0))
    assert len(lacking_of(left, columns, 2, _LEVEL)) == 2
    asking = [Asking(is_last=True), Asking()]
    assert len(lacking_of(left, columns, 2, _LEVEL, asking=asking)) == 1


def test_a_force_of_the_wrong_sign_is_none(rng: np.random.Generator) -> None:
    left, columns = _two(rng, (12.0, 0.0))
    (found,) = lacking_of(left, columns[:, :1], 1, _LEVEL)
    sign = np.sign(found.factor)
    for side, chance in ((sign, found.chance), (-sign, 1.0)):
        asking = [Asking(is_positive=True)]
        (one,) = lacking_of(left, side * columns[:, :1], 1, _LEVEL, asking=asking)
        assert one.chance == pytest.approx(chance)


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
