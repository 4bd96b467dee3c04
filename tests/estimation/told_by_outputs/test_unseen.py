"""What no output shows is named, alone or together."""

import numpy as np

from axisid.estimation.told_by_outputs.unseen import unseen_directions

NAMES = ("M", "Fv", "m")


def test_what_is_shown_is_not_named(rng: np.random.Generator) -> None:
    J = rng.standard_normal((50, 3)) * [1e-3, 1.0, 1e3]
    assert not len(unseen_directions(J, np.ones(3)).moves)


def test_a_parameter_that_changes_nothing_is_named(rng: np.random.Generator) -> None:
    J = rng.standard_normal((50, 3)) * [1.0, 0.0, 1.0]
    found = unseen_directions(J, np.ones(3))
    assert found.texts(NAMES) == ("Fv at all",)


def test_parameters_that_only_a_sum_of_is_shown_are_named_with_it(
    rng: np.random.Generator,
) -> None:
    J = rng.standard_normal((50, 3))
    J[:, 2] = 2 * J[:, 0]
    for scale in (np.ones(3), np.array([100.0, 1.0, 0.1])):
        (said,) = unseen_directions(J, scale).texts(NAMES)
        assert said == "M and m apart (+1 of M, -0.5 of m together change nothing)"
