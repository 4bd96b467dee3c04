"""Moves are what a person would call so: one hill of speed each, whatever its last digits are."""

import numpy as np
import pytest

from axisid.estimation.moves.lack_of_fit import moves_of

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
