"""Values that are worked out when they are first asked for."""

import copy
import pickle

import numpy as np
import pytest

from axisid.support.deferred import Deferred


def test_nothing_is_worked_out_before_it_is_asked_for_and_then_once() -> None:
    made: list[int] = []
    deferred = Deferred(lambda: made.append(1) or len(made))
    assert not made
    assert [deferred.value, deferred.value] == [1, 1]


def test_a_pickle_has_the_value_and_not_the_way_to_it() -> None:
    deferred = Deferred(lambda: np.arange(3.0))  # no function without a name can be pickled
    again = pickle.loads(pickle.dumps(deferred))  # noqa: S301
    assert np.array_equal(again.value, [0.0, 1.0, 2.0])
    assert again == deferred == copy.deepcopy(deferred)


def test_others_of_another_value_are_not_equal() -> None:
    assert Deferred.of(np.array([1.0])) != Deferred.of(np.array([2.0]))
    assert Deferred.of(1.0) != 1.0


def test_what_cannot_be_worked_out_is_said_again() -> None:
    deferred: Deferred[float] = Deferred(lambda: 1 / 0)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            _ = deferred.value
