"""What a fit is judged from, once it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.predictions import Predictions
from axisid.estimation.told_by_outputs import Left
from axisid.support.arrays import Array

from .search import Found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitBasis:
    """What a fit is judged from.

    Attributes
    ----------
    axes : tuple of GeneratedAxis
        By record.
    predictions : Predictions
    best : Found
        The search that is told.
    ends : tuple of Found
        All searches.
    influence : (P, n) array
        Of the errors on the parameters.
    beyond : mapping of str to float
        How far beyond its bound each parameter at one would be without it, in deviations.
    left : Left
        Errors at the end.
    asked : Predictions
        Those whose errors are asked what the model lacks.
    asked_left : Left
        Their errors.
    known : tuple of str
        Names of what was known of each record.
    alone : mapping of str to (float, float)
        What the records say, with deviations, of what was known before; empty where they do not
        show every parameter.
    moved : (P,) array or None
        What noise in the loop moved the parameters by, and was taken off.
    of_start : (P,) array of bool
        Which parameters are first positions and velocities of loops.
    """

    axes: tuple[GeneratedAxis, ...]
    predictions: Predictions
    best: Found
    ends: tuple[Found, ...]
    influence: Array
    beyond: Mapping[str, float]
    left: Left
    asked: Predictions
    asked_left: Left
    known: tuple[str, ...]
    alone: Mapping[str, tuple[float, float]]
    moved: Array | None
    of_start: NDArray[np.bool_]
