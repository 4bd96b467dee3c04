"""The machines of the field move as the axes that are declared of them, faults apart."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import simulate
from benchmarks.machines import Machine, records

field: Any = import_module("field")


@pytest.mark.slow
@pytest.mark.parametrize(
    "machine",
    [
        Machine(coulomb=40.0),
        Machine(offset=150.0, coulomb=40.0),
        Machine(kp=25.0, kv=150.0, tn=0.05),
        Machine(kp=1200.0, ki=4000.0, kd=80.0),
        Machine(kp=15.0, kv=100.0, tn=0.1, period=5e-3),
    ],
    ids=["cascade", "weight", "P-PI", "PID", "P-PI, 5 ms"],
)
def test_a_machine_under_each_law_moves_and_rests_as_its_axis_is_simulated(
    machine: Machine,
) -> None:
    case = field.Case(machine=machine, declared=machine)
    reference = field.reference_of(case.motion, machine.period)[: round(3.2 / machine.period)]
    loop = simulate(case.axis, [*case.truth.values()], reference, machine.period)
    (columns,) = records(machine, reference, 1, seed=1)
    np.testing.assert_allclose(columns["position"], loop.position, atol=1e-7)
    np.testing.assert_allclose(columns["control"], loop.control, atol=2e-3)
