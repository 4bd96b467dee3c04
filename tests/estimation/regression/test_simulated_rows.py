"""Rows of simulated loops, against what the motion of a free mass says by itself."""

import numpy as np

from axisid import build, simulate
from axisid.estimation.regression import InverseForm
from axisid.estimation.regression.simulated_rows import loop_equations
from tests.axes.bodies import body, force_law

PERIOD = 1e-3


def test_a_held_force_moves_a_free_mass_by_the_mean_of_both_its_sides(
    rng: np.random.Generator,
) -> None:
    axis = build(body(control=force_law(PERIOD)), native=False)
    force = rng.normal(size=30)
    loop = simulate(axis, [2.0], force, PERIOD, start=0.0)
    rows = loop_equations(InverseForm(axis), loop, np.array([2.0]), "zoh")
    central = (loop.velocity[2:] - loop.velocity[:-2]) / (2 * PERIOD)
    np.testing.assert_allclose(rows.regressor[1:-1, 0], central, rtol=0, atol=1e-11)
    np.testing.assert_allclose(rows.left[1:], (force[1:] + force[:-1]) / 2, rtol=1e-12)
