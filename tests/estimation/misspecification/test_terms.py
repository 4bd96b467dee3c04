"""Forces along a motion, as they are declared, and tests of columns beside a model."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.stats import kstest

from axisid.estimation.misspecification.scores import RecordScores
from axisid.estimation.misspecification.terms import TERMS, Along, behind_spring
from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array

_PERIOD = 1e-3


def _along(frequency: float = 2.0) -> Along:
    time = _PERIOD * np.arange(3000)
    rate = 2 * np.pi * frequency
    position = 0.1 * np.sin(rate * time)
    velocity = 0.1 * rate * np.cos(rate * time)
    return Along(
        time=time,
        position=position,
        velocity=velocity,
        acceleration=-(rate**2) * position,
        direction=np.sign(velocity),
        force=5 * velocity,
        spans=[(0, 3000)],
        period=_PERIOD,
        row_period=_PERIOD,
    )


@pytest.mark.parametrize("frequency", [6.0, 20.0])
def test_a_load_behind_a_spring_follows_a_slow_swing_a_little_too_far(frequency: float) -> None:
    """As an undamped oscillator below its resonance does: by ``1 / (1 - r^2)``, nearly."""
    s, ratio = _along(2.0), 2.0 / frequency
    (column,) = behind_spring(s, np.array([frequency])).T
    settled = slice(2000, None)
    expected = ratio**2 / (1 - ratio**2) * s.acceleration[settled]
    error = np.linalg.norm(column[settled] - expected) / np.linalg.norm(expected)
    assert error < 0.1 + ratio  # the rest is its damping


def test_a_load_much_faster_than_a_motion_takes_its_fourth_derivative_away() -> None:
    s = _along(2.0)
    (column,) = behind_spring(s, np.array([80.0])).T
    fourth = (2 * np.pi * 2.0) ** 4 * s.position
    held = column[2000:] @ fourth[2000:] / (fourth[2000:] @ fourth[2000:])
    assert held == pytest.approx(-1 / (2 * np.pi * 80.0) ** 2, rel=0.05)


def test_each_stretch_is_by_itself() -> None:
    s, delay = replace(_along(), spans=[(0, 1000), (1000, 2500)]), TERMS["delay"]
    jumps = replace(s, force=s.force + np.where(s.time < 1.0, 100.0, 0.0))
    found, other = (delay.columns(each, np.zeros(1))[:, 0, 0] for each in (s, jumps))
    np.testing.assert_allclose(found, other, atol=1e-8)
    assert not found[2500:].any()
    apart = replace(s, acceleration=np.where(s.time < 1.0, 1e3, s.acceleration))
    late = behind_spring(apart, np.array([20.0]))[1000:2500]
    np.testing.assert_allclose(late, behind_spring(s, np.array([20.0]))[1000:2500])


def test_waves_are_of_every_period_that_rows_can_tell() -> None:
    s = _along(0.4)
    periods = TERMS["place"].places(s)
    assert periods[0] == pytest.approx(0.2, rel=1e-4)
    assert np.all(periods > np.median(np.abs(s.velocity)) * 4 * s.row_period)
    assert len(TERMS["place"].places(replace(s, row_period=0.1))) < len(periods)
    for true in (0.03, 0.0131, 0.051):
        at = float(periods[np.argmin(np.abs(1 / periods - 1 / true))])
        between = TERMS["place"].between
        assert np.abs(between(periods, at) / true - 1).min() < 0.02


def test_what_is_commanded_beyond_a_limit_is_lost_and_its_factor_is_one(
    rng: np.random.Generator,
) -> None:
    force = np.repeat(rng.uniform(-1.0, 1.0, 60), 50)
    s = replace(_along(), force=force)
    term, levels = TERMS["saturation"], TERMS["saturation"].places(s)
    assert 0.0 < levels[0] < 0.1 < 0.8 < levels[-1] < np.abs(force).max()
    columns = term.columns(s, np.array([0.6]))[:, 0]
    assert np.clip(force, -0.6, 0.6) == pytest.approx(force - columns[:, 0])
    between = term.between(levels, math.nan)
    lost = (force - np.clip(force, -0.6, 0.6))[:, None]
    tested = scores_of(lost, s.velocity[:, None]).test(term.columns(s, between))
    assert between[np.argmax(tested.whole_powers)] == pytest.approx(0.6, abs=0.02)


ROWS, PARAMETERS = 300, 3


def coloured(random: np.random.Generator, several: int) -> Array:
    """Noise with a memory of three rows, (n, several)."""
    noise = random.standard_normal((ROWS + 3, several))
    return noise[3:] + 0.8 * noise[2:-1] + 0.5 * noise[1:-2] + 0.2 * noise[:-3]


def scores_of(errors: Array, X: Array) -> RecordScores:
    """Of least squares, errors (n, 1 + R) of a record and its twins."""
    basis = np.linalg.qr(X)[0]
    sampling = SimpleNamespace(neighbours=RowTimes.consecutive(len(X)))
    return RecordScores(
        basis=basis,
        columns=X,
        free=np.arange(X.shape[1]),
        regressor=X,
        residuals=errors - basis @ (basis.T @ errors),
        force=np.ones(len(X)),
        form=cast(Any, None),
        physical=np.zeros(X.shape[1]),
        signals=cast(Any, None),
        along=cast(Any, None),
        measured=cast(Any, None),
        data=cast(Any, SimpleNamespace(sampling=sampling)),
        quiet=cast(Any, None),
    )


@pytest.fixture(name="X")
def regressor(rng: np.random.Generator) -> Array:
    return rng.standard_normal((ROWS, PARAMETERS))


@pytest.mark.parametrize("width", [1, 2, 3])
def test_values_are_those_of_least_squares_with_the_columns_in_the_model(
    rng: np.random.Generator, X: Array, width: int
) -> None:
    columns, y = rng.standard_normal((ROWS, 4, width)), rng.standard_normal(ROWS)
    scores, alone = scores_of(y[:, None], X), sm.OLS(y, X).fit()
    tested = scores.test(columns)
    for place in range(4):
        both = sm.OLS(y, np.hstack([X, columns[:, place]])).fit()
        assert tested.values[place] == pytest.approx(both.params[PARAMETERS:])
        assert tested.powers[place] == pytest.approx((alone.ssr - both.ssr) / ROWS)
        moved = scores.moved_by(columns[:, place], tested.values[place])
        assert moved == pytest.approx(both.params[:PARAMETERS] - alone.params)
        then, more = scores.with_columns(columns[:, place]), columns[:, (place + 1) % 4]
        assert then.net_residuals[:, 0] == pytest.approx(both.resid)
        three = sm.OLS(y, np.hstack([X, columns[:, place], more])).fit()
        moved = then.moved_by(more, then.test(more[:, None]).values[0])
        assert moved == pytest.approx(three.params[:PARAMETERS] - both.params[:PARAMETERS])


@pytest.mark.parametrize("width", [1, 2, 3])
def test_by_twins_right_records_have_p_values_that_are_uniform(
    rng: np.random.Generator, X: Array, width: int
) -> None:
    """Whatever the colour of their noise."""
    columns, found = rng.standard_normal((ROWS, 1, width)), []
    for _ in range(300):
        scores = scores_of(coloured(rng, 25), X)
        found.append(float(scores.test(columns).p_values[0]))
    assert kstest(found, "uniform").pvalue > 1e-3


def test_what_every_twin_has_too_is_no_lack(rng: np.random.Generator, X: Array) -> None:
    column = rng.standard_normal(ROWS)
    errors = coloured(rng, 33)
    alike = scores_of(errors + 5 * column[:, None], X)
    own = scores_of(errors + 5 * np.outer(column, np.arange(33) == 0), X)
    assert alike.test(column[:, None, None]).p_values[0] > 1e-3
    assert own.test(column[:, None, None]).p_values[0] < 1e-9


def test_without_twins_a_column_is_told_from_coloured_noise(
    rng: np.random.Generator, X: Array
) -> None:
    column, alarms = np.repeat(rng.standard_normal(ROWS // 10), 10)[:, None, None], 0
    for _ in range(100):
        scores = scores_of(coloured(rng, 1), X)
        alarms += scores.test(column).p_values[0] < 0.05
    assert alarms <= 15
    there = scores_of(coloured(rng, 1) + 4 * column[:, 0], X)
    tested = there.test(column)
    assert tested.p_values[0] < 1e-4
    assert abs(tested.values[0, 0] - 4) < 4 * np.sqrt(tested.covariances[0, 0, 0])


def test_what_the_model_spans_is_not_tested(rng: np.random.Generator, X: Array) -> None:
    own = (X @ [1.0, 2.0, -1.0])[:, None, None]
    other = rng.standard_normal((ROWS, 1, 1))
    scores = scores_of(coloured(rng, 17), X)
    for columns in (own, np.zeros((ROWS, 1, 1)), np.concatenate([other, other], axis=2)):
        tested = scores.test(columns)
        assert tested.p_values[0] == 1
        assert not tested.values.any()


def test_a_place_is_told_by_the_measured_columns_through_their_instruments(
    rng: np.random.Generator, X: Array
) -> None:
    """Noise in the columns, or another phase of the loop's, does not mislead it."""
    time = np.linspace(0, 20, ROWS)[:, None]
    places = np.linspace(1.0, 3.0, 41)
    seen = np.sin(places * time)
    loop = np.sin(places * time + 0.4)
    errors = 3 * np.sin(2.0 * time) + 0.3 * rng.standard_normal((ROWS, 1))
    scores = scores_of(errors, X)
    noisy = seen + 0.2 * rng.standard_normal(seen.shape)
    found = places[scores.nearest(loop[:, :, None], noisy[:, :, None])]
    assert found == pytest.approx(2.0, abs=0.06)
