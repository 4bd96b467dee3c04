"""What tests of fits make records by, and what they ask of a result."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid import Record, simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.output_error import OutputFit
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array

#: Of the axis `emps2015`.
TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}


def looped(
    axis: GeneratedAxis,
    theta: Sequence[float] | Array,
    reference: Array,
    noise: float,
    *,
    seed: int = 5,
    unseen: float = 0.0,
    first: int = 0,
) -> tuple[Record, Simulation]:
    """A record, from a sample on, of a loop with noise of its position and a force in no log."""
    white = np.random.default_rng(seed).normal(scale=noise, size=len(reference))
    injected, period = np.full(len(reference), unseen), axis.axis.control.period  # type: ignore[union-attr]
    loop = simulate(axis, theta, reference, period, position_noise=white, injected=injected)
    record = Record(
        time=loop.time[first:],
        position=loop.measured_position[first:],
        reference=reference[first:],
        control=(loop.control - unseen)[first:],
    )
    return record, loop


def off(found: OutputFit, truth: Mapping[str, float] = TRUTH) -> Array:
    """How far parameters are from their true values, in their deviations."""
    return np.array([(found[n].value - value) / found[n].deviation for n, value in truth.items()])
