"""What no output shows is named, alone or together."""

import numpy as np

from axisid.estimation.fitting.unseen import unseen_directions

NAMES = ("M", "Fv", "m")


def test_parameters_that_only_a_sum_of_is_shown_are_named_with_it(
    rng: np.random.Generator,
) -> None:
    J = rng.standard_normal((50, 3))
    J[:, 2] = 2 * J[:, 0]
    for scale in (np.ones(3), np.array([100.0, 1.0, 0.1])):
        (said,) = unseen_directions(J, scale).texts(NAMES)
        assert said == "M and m apart (+1 of M, -0.5 of m together change nothing)"
