"""Mechanisms of the textbooks are derived, and give the force that their places give."""

import mpmath
import numpy as np
import pytest
import sympy

from axisid import derive
from axisid.modeling.quantities import with_numbers
from axisid.modeling.quantities.symbols import DIRECTION
from tests.axes.mechanisms import MECHANISMS

_FAST = ("cardan", "oval_gears", "governor", "toggle", "spring_between_points", "scotch_yoke")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in _FAST else pytest.mark.slow) for n in MECHANISMS],
)
def test_force_is_that_of_the_places_in_as_few_parameters_as_these_tell_apart(name: str) -> None:
    mechanism = MECHANISMS[name]()
    model = derive(mechanism.axis(name))
    q = mechanism.coordinate
    motion = (q.symbol, q.velocity, q.acceleration, DIRECTION)
    columns = sympy.lambdify(motion, list(map(with_numbers, model.idm.columns)), "mpmath")
    theta = [mpmath.mpf(2 * i + 3) / (i + 2) for i in range(len(model.base.declared.parameters))]
    beta = model.base.at(list(map(float, theta)))
    rows, rng = [], np.random.default_rng(3)
    with mpmath.workdps(40):
        for _ in range(12):
            position = float(rng.uniform(mechanism.lowest, mechanism.highest))
            velocity, acceleration = map(float, rng.normal(size=2))
            expected = mechanism.columns(mpmath.mpf(position), velocity, acceleration)
            row = columns(position, velocity, acceleration, np.sign(velocity))
            force = mpmath.fsum(map(float.__mul__, beta, map(float, row)))
            size = mpmath.fsum(abs(t * c) for t, c in zip(theta, expected, strict=True))
            assert abs(force - mpmath.fdot(theta, expected)) < 1e-11 * size
            rows.append([float(c) for c in expected])
    scaled = np.array(rows) / np.linalg.norm(rows, axis=0)
    assert len(model.axis.parameters) == np.linalg.matrix_rank(scaled, tol=1e-9)
