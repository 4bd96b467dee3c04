"""Predictions side by side, one column for each parameter set."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.records import Record
from axisid.support.arrays import Array

from .added_slopes import Motion

#: The code of an error where no loop can be simulated.
LANE_LOST = "fit-lane"


@dataclass(frozen=True, slots=True, kw_only=True)
class Lanes:
    """Predicted less recorded outputs.

    Attributes
    ----------
    errors : (n, B) array
        One column a lane; NaN where its simulation ended early.
    failures : mapping of int to str
        Why, by lane.
    """

    errors: Array
    failures: Mapping[int, str]


def whole_lanes(lanes: Array) -> Array:
    """Those of lanes (n, B) that could be simulated to their end."""
    return np.asarray(lanes[:, np.isfinite(lanes).all(axis=0)])


class Predictions(Protocol):
    """An output as parameters predict it, at the samples of all records.

    Attributes
    ----------
    spans : tuple of tuple of slice
        Rows of each stretch without a gap, by record.
    samples : tuple of array of int
        Which sample of its record each row is, or each of several outputs' rows, by record.
    units : tuple of str
        Of each output; the rows of a sample are neighbours, one of each.
    step : float
        Of the coarsest encoder; 0 where nothing is known of any.
    measured : (n,) array
        What was recorded.
    counted : (n,) array
        1 for rows that count, 0 for those that are no measurements.
    """

    spans: tuple[tuple[slice, ...], ...]
    samples: tuple[NDArray[np.intp], ...]
    units: tuple[str, ...]
    step: float
    measured: Array
    counted: Array

    def settle(self, physical: Array) -> None:
        """Settle at parameters (P,) what is to be the same for all lanes about them.

        Raises
        ------
        EstimationError
            They cannot be simulated.
        """

    def __call__(self, physical: Array) -> Lanes:
        """Errors of parameters (B, P)."""

    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Rows that the errors of other records of the same samples would have less of, (n,).

        Of each the output, or how far it is from a prediction by parameters (P,) that follows it.
        """

    def by_noise(
        self, physical: Array, count: int, random: np.random.Generator, factor: float = 1.0
    ) -> Array:
        """What errors of the measured position, as the records have them, change, (n, B).

        Times a factor: -1 with the same draws is the other half of antithetic pairs.
        """

    def slopes_by_start(self, physical: Array) -> tuple[tuple[slice, Array], ...]:
        """Rows of each stretch that begins in motion, and slopes of its errors there, (n, 2).

        By its first position and velocity, which are those of the record; none where they are
        parameters.
        """

    def slopes_by_law(self, physical: Array) -> Mapping[str, Array]:
        """Slopes of the errors by a factor of each term of the law, (n,), by its gains."""

    def motions(self, physical: Array) -> tuple[Motion, ...] | None:
        """Of parameters (P,), in the order of the rows; None where they cannot be simulated."""

    def slopes_by_added(self, physical: Array, added: Sequence[Array]) -> Array | None:
        """Slopes of the errors by factors of added controls, (n, k), that are (N, k) by motion."""


def record_rows(spans: Sequence[slice], place: int = 0, outputs: int = 1) -> slice:
    """Rows of a record by its stretches: all, or those of the output at a place of so many."""
    return slice(spans[0].start + place, spans[-1].stop, outputs)
