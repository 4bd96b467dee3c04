"""What the law as the records have it moves a fit by."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.fitting.law_moves import move_by_record, moves_of_all
from axisid.support.arrays import Array
from axisid.support.missing import Missing


def _law(kp: float) -> LawCheck:
    return LawCheck(
        factors={"kp": kp},
        residual_percent=1.0,
        fitted_residual_percent=0.1,
        delay=0,
        passed=False,
        meaning="",
    )


MOVES = ({"kp": np.array([2.0, 0.0])}, {"kp": np.array([1.0, 3.0])})


def _move(of_records: Sequence[Mapping[str, Array]], laws: Sequence[LawCheck | Missing]) -> Array:
    found = move_by_record(of_records, laws)
    assert found is not None
    return found[0]


def test_each_record_moves_the_parameters_by_its_own_factors() -> None:
    """Of factors of 1.1 and 0.9 the mean is 1, and what they move is not nothing."""
    moved = _move(MOVES, [_law(1.1), _law(0.9)])
    assert moved == pytest.approx([10.0, -30.0])
    alike = _move(MOVES, [_law(1.1), _law(1.1)])
    assert alike == pytest.approx(10 * moves_of_all(MOVES)["kp"])


def test_a_record_that_does_not_tell_is_taken_for_the_others() -> None:
    moved = _move(MOVES, [_law(1.1), Missing("it is too short")])
    assert moved == pytest.approx([30.0, 30.0])
    assert move_by_record(MOVES, [Missing("it is too short")] * 2) is None
