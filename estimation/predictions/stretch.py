"""A segment of a record, and what its loop is simulated from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.simulation import LoopInputs
from axisid.support.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """A segment of a record, and what its loop is simulated from.

    Attributes
    ----------
    axis : GeneratedAxis
    record : int
        Of the records, from 0.
    segment : int
        Of the record, from 0.
    inputs : LoopInputs
    outputs : tuple of str
        What is followed, as `Simulation` names it; of several the rows of a sample are neighbours.
    measured : (n,) array
        The recorded outputs, a row for each output of each sample.
    counted : (n,) array of bool
        Which rows are measurements.
    noise : float
        Standard deviation of the recorded position's noise.
    step : float
        Of the encoder; 0 where nothing is known of it.
    """

    axis: GeneratedAxis
    record: int
    segment: int
    inputs: LoopInputs
    outputs: tuple[str, ...]
    measured: Array
    counted: NDArray[np.bool_]
    noise: float
    step: float

    @property
    def samples(self) -> int:
        """How many."""
        return len(self.measured) // len(self.outputs)

    def rows(self, values: Callable[[str], Array]) -> Array:
        """Rows of what each output has at the samples, (N, B): (n, B)."""
        return interleaved([values(name) for name in self.outputs])


def interleaved(columns: Sequence[Array]) -> Array:
    """Values (N, ...) of each output as rows, those of a sample neighbours, (n, ...)."""
    if len(columns) == 1:
        return columns[0]
    whole = np.stack(columns, axis=1)
    return whole.reshape(-1, *whole.shape[2:])
