"""Parameters by name."""

from typing import Any

import numpy as np
import pytest

from axisid import simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import simulate_batch
from tests.refusals import refuses

TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}
REFERENCE = 0.01 * np.sin(np.arange(200) / 20.0)


def test_parameters_by_name_are_those_in_order(emps2015: GeneratedAxis) -> None:
    ordered = [TRUTH[name] for name in emps2015.names]
    turned = dict(reversed(TRUTH.items()))
    assert simulate(emps2015, turned, REFERENCE, 1e-3) == simulate(
        emps2015, ordered, REFERENCE, 1e-3
    )


def test_lanes_by_name_share_what_is_one_number(emps2015: GeneratedAxis) -> None:
    lanes = np.tile([TRUTH[name] for name in emps2015.names], (3, 1))
    lanes[:, 2] = masses = np.array([20.0, 24.8, 30.0])
    made = simulate_batch(emps2015, {**TRUTH, "Fc": masses}, REFERENCE, 1e-3)
    wanted = simulate_batch(emps2015, lanes, REFERENCE, 1e-3)
    np.testing.assert_array_equal(made["position"], wanted["position"])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"M": 100.0, "Fv": 200.0}, "Fc is missing"),
        ({**TRUTH, "m": 1.0}, "'m' is no parameter; give a value of each of M, Fv, Fc"),
        ({}, "M, Fv, Fc is missing"),
    ],
)
def test_names_that_are_not_those_of_the_axis_are_refused(
    emps2015: GeneratedAxis, given: dict[str, float], says: str
) -> None:
    with refuses("parameter-names", says=says):
        simulate(emps2015, given, REFERENCE, 1e-3)


def test_lanes_of_several_lengths_are_refused(emps2015: GeneratedAxis) -> None:
    given: dict[str, Any] = {**TRUTH, "M": np.ones(2), "Fc": np.ones(3)}
    with refuses("parameter-shapes", says=r"M \(2,\), Fv \(\), Fc \(3,\)"):
        simulate_batch(emps2015, given, REFERENCE, 1e-3)
