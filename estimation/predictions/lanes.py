"""Predictions side by side, one column for each parameter set."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from axisid.support.arrays import Array


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


class Predictions(Protocol):
    """An output as parameters predict it, at the samples of all records."""

    @property
    def spans(self) -> tuple[tuple[slice, ...], ...]:
        """Rows of each stretch without a gap, by record."""

    @property
    def measured(self) -> Array:
        """What was recorded, (n,)."""

    @property
    def counted(self) -> Array:
        """1 for rows that count, 0 for those that are no measurements, (n,)."""

    def settle(self, physical: Array) -> None:
        """Settle at parameters (P,) what is to be the same for all lanes about them.

        Raises
        ------
        EstimationError
            They cannot be simulated.
        """

    def __call__(self, physical: Array) -> Lanes:
        """Errors of parameters (B, P)."""
