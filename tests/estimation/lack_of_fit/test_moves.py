"""Moves are what a person would call so, and repeats are found in the reference alone."""

import numpy as np
import pytest

from axisid.estimation.lack_of_fit.repeated_phases import Repeats, _period, moves_of, repeats_of
from axisid.support.arrays import Array

HILL = np.concatenate([np.linspace(0, 1, 40), np.ones(100), np.linspace(1, 0, 40)])
REST = np.zeros(30)


def test_each_hill_of_speed_is_a_move_and_rests_are_in_none() -> None:
    velocity = np.concatenate([REST, HILL, -0.5 * HILL, REST, 0.52 * HILL, REST])
    moves = moves_of(velocity)
    assert moves.speeds == pytest.approx([1.0, -0.5, 0.52])
    assert list(moves.levels) == [1, 0, 0]
    assert moves.starts == pytest.approx([30, 210, 420], abs=2)
    assert moves.stops == pytest.approx([210, 390, 600], abs=2)


def test_noise_on_a_cruise_makes_no_moves(rng: np.random.Generator) -> None:
    velocity = np.concatenate([HILL, -HILL]) + 1e-3 * rng.normal(size=2 * len(HILL))
    assert len(moves_of(velocity)) == 2


def test_last_digits_of_a_plateau_make_no_moves() -> None:
    velocity = np.concatenate([HILL, HILL])
    velocity[60] = velocity[100] = 1.0 + 1e-15
    assert len(moves_of(velocity)) == 2


def test_an_axis_at_rest_has_no_moves() -> None:
    assert len(moves_of(np.zeros(100))) == 0


def move(length: float, samples: int = 400) -> Array:
    phase = np.linspace(0, np.pi, samples, endpoint=False)
    return np.asarray(length * (1 - np.cos(phase)) / 2)


ONCE = np.concatenate([move(1.0), 1.0 - move(0.4), 0.6 + move(0.3), 0.9 - move(0.9)])


def found(reference: Array) -> Repeats:
    return repeats_of(reference, ((0, len(reference)),))


def test_the_period_is_that_of_the_reference() -> None:
    repeats = found(np.tile(ONCE, 4))
    assert repeats.period == len(ONCE)
    assert repeats.times == 4
    first, last = np.flatnonzero(repeats.move >= 0)[[0, -1]]
    assert 0 < first <= len(ONCE)  # what is before the first move is not known
    assert last == pytest.approx(4 * len(ONCE), abs=5)


def test_samples_of_one_phase_have_one_number() -> None:
    repeats = found(np.tile(ONCE, 3))
    n = len(ONCE)
    later = slice(n + 500, 2 * n - 10)
    after = slice(2 * n + 500, 3 * n - 10)
    assert np.all(repeats.move[later] >= 0)
    assert np.array_equal(repeats.move[later], repeats.move[after])
    assert np.array_equal(repeats.offset[later], repeats.offset[after])


def test_last_digits_do_not_matter(rng: np.random.Generator) -> None:
    reference = np.round(np.tile(ONCE, 3), 5)
    exact, rounded = (
        found(np.tile(ONCE, 3)),
        found(reference + 1e-6 * rng.normal(size=len(reference))),
    )
    assert rounded.period == pytest.approx(len(ONCE), abs=2)
    assert np.mean(rounded.move >= 0) > 0.9 * np.mean(exact.move >= 0)


def test_rests_of_any_length_may_part_repeats(rng: np.random.Generator) -> None:
    pieces = []
    for rest in (50, 170, 90, 230):
        pieces += [np.zeros(rest), ONCE]
    repeats = found(np.concatenate([*pieces, np.zeros(40)]))
    assert repeats.period is None
    assert repeats.times >= 3
    assert np.sum(repeats.move >= 0) > 2.9 * len(ONCE)


def test_part_of_a_record_may_repeat(rng: np.random.Generator) -> None:
    others = [move(length) for length in (0.2, 0.7)]
    head = np.concatenate([others[0], 0.2 - 0.2 * move(1.0), others[1], 0.7 - 0.7 * move(1.0)])
    repeats = found(np.concatenate([head, np.tile(ONCE, 2), 0.5 * move(1.0)]))
    assert np.flatnonzero(repeats.move >= 0)[0] >= len(head)
    assert repeats.period == len(ONCE)


def test_moves_of_other_sizes_do_not_repeat() -> None:
    pieces = [scale * np.concatenate([move(1.0), 1.0 - move(1.0)]) for scale in (1.0, 1.1, 1.2)]
    reference = np.concatenate(pieces)
    assert repeats_of(reference, ((0, len(reference)),)) is None


@pytest.mark.parametrize("reference", [np.zeros(500), np.full(500, np.nan), np.arange(500.0)])
def test_no_motion_repeats_nothing(reference: Array) -> None:
    assert repeats_of(reference, ((0, len(reference)),)) is None


def test_no_repeat_goes_across_a_gap() -> None:
    reference = np.tile(ONCE, 2)
    whole = repeats_of(reference, ((0, len(reference)),))
    middle = len(ONCE) + 600
    parted = repeats_of(reference, ((0, middle), (middle, len(reference))))
    assert parted is None or np.sum(parted.move >= 0) < np.sum(whole.move >= 0)


@pytest.mark.slow
def test_a_reference_of_noise_has_no_period_and_no_fault() -> None:
    """Moves that are the same but for a shift may begin at the same sample."""
    rng = np.random.default_rng(13)
    reference = np.cumsum(rng.normal(size=3000)) * 1e-6
    for noise in (0.0, 1e-7, 1e-6):
        found = repeats_of(reference + noise * rng.normal(size=3000), ((0, 3000),))
        assert found is None or found.period is None or found.period > 0
    assert _period(np.ones(50), {0, 50, 60}, 0.1) is None
