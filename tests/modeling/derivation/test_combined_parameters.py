"""What a base parameter that combines others starts from, and what bounds it has."""

import math
from dataclasses import replace

import pytest

from axisid import Axis, Parameter, derive, fix
from axisid.modeling.derivation.base_model import base_model
from tests.axes.bodies import J, M, body

a = Parameter("a", "N", nominal=2.0, lower=0.0, upper=5.0)
b = Parameter("b", "N", nominal=3.0, lower=1.0, upper=4.0)


def added(weight: int, *forces: Parameter) -> Axis:
    one, two = forces
    return body(one.symbol, weight * two.symbol, parameters=forces)


def combined(axis: Axis) -> Parameter:
    (found,) = (p for p, _ in base_model(axis).combined)
    return found


def test_a_sum_starts_from_the_sum_of_the_nominal_values() -> None:
    assert combined(added(2, a, b)).nominal == 8.0
    assert combined(added(-2, a, b)).nominal == -4.0


def test_a_sum_starts_from_what_is_known_of_its_parts() -> None:
    assert combined(fix(added(2, a, b), b=1.5)).nominal == 5.0


def test_a_sum_has_the_bounds_of_its_parts() -> None:
    found = combined(added(2, a, b))
    assert (found.lower, found.upper) == (2.0, 13.0)
    assert combined(added(2, replace(a, upper=math.inf), b)).upper == math.inf


@pytest.mark.parametrize("weight", [-1, -2])
def test_a_difference_has_no_bounds(weight: int) -> None:
    found = combined(added(weight, a, b))
    assert (found.lower, found.upper) == (-math.inf, math.inf)


def test_a_part_that_may_be_negative_leaves_no_bounds() -> None:
    found = combined(added(2, replace(a, lower=-1.0), b))
    assert (found.lower, found.upper) == (-math.inf, math.inf)


def test_the_pivot_of_the_direct_map_is_an_inertia_without_other_forces() -> None:
    model = derive(body(9.81 * M, inertia=M + 4 * J, parameters=(M, J)))
    assert model.ddm.intercept == 0
    heavy = model.parameter_map.forward[1]
    assert heavy == M.symbol / (M + 4 * J)
