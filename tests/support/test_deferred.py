"""Values that are worked out when they are first asked for."""

import copy
import pickle

import numpy as np

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
