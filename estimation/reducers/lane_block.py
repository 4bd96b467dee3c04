"""Lanes that are simulated and reduced together."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from numpy.typing import ArrayLike

from axisid.support.arrays import Array, Exact


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneBlock(Exact):
    """Some of the lanes of a batch, simulated.

    Attributes
    ----------
    first : int
        The first of them, counted in the batch.
    parameters : (b, p) array
    reference : (N,) or (N, b) array
        Shared, or one column a lane.
    period : float
        Of the samples, s.
    signals : dict of str to (N, b) array
        What is wanted, by name; NaN from the sample on at which a simulation ended early.
    """

    first: int
    parameters: Array
    reference: Array
    period: float
    signals: dict[str, Array]

    @property
    def lanes(self) -> int:
        """How many."""
        return len(self.parameters)


#: Makes of a block arrays by name, (b, ...) each: one row a lane, and the same names each time.
Reducer: TypeAlias = Callable[[LaneBlock], Mapping[str, ArrayLike]]
