"""A segment of a record, and what its loop is simulated from."""

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
    measured : (N,) array
        The recorded output.
    counted : (N,) array of bool
        Which samples are measurements.
    noise : float
        Standard deviation of the recorded position's noise.
    step : float
        Of the encoder; 0 where nothing is known of it.
    """

    axis: GeneratedAxis
    record: int
    segment: int
    inputs: LoopInputs
    measured: Array
    counted: NDArray[np.bool_]
    noise: float
    step: float
