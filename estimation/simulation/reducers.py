"""What is kept of lanes in place of their signals: what a function makes of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError
from axisid.support.real_numbers import real_array
from axisid.support.user_values import quoted


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


def check_reducer(reducer: object, wanted: Sequence[str]) -> None:
    """Refuse what makes nothing of lanes, or of no signal.

    Raises
    ------
    UsageError
        It is no function, or no signal is wanted.
    """
    if not callable(reducer):
        raise UsageError(
            f"the batch is to be reduced by {quoted(reducer)}; give a function that takes a "
            "LaneBlock and gives arrays by name.",
            code="unknown-reducer",
        )
    if not wanted:
        raise UsageError(
            f"the batch is to be reduced by {quoted(reducer)}, and no signal is wanted; name "
            "signals.",
            code="reduce-nothing",
        )


def reduced(reducer: Reducer, block: LaneBlock) -> dict[str, Array]:
    """What a reducer makes of a block, (b, ...) arrays by name.

    Raises
    ------
    UsageError
        It gives what is no array for each lane by name.
    """
    given = reducer(block)
    if not (isinstance(given, Mapping) and all(isinstance(name, str) for name in given)):
        raise UsageError(
            f"the reducer gives {quoted(given)}; let it give arrays by name, such as "
            "{'overshoot': values}.",
            code="reduced-names",
        )
    made = {name: real_array(values, f"the reduced {name}") for name, values in given.items()}
    for name, values in made.items():
        if values.shape[:1] != (block.lanes,):
            raise UsageError(
                f"the reducer gives {name} of the shape {values.shape} for {block.lanes} lanes; "
                "let its first dimension be the lanes.",
                code="reduced-shape",
            )
    # A view would keep the signals of the block in memory.
    return {name: values.copy() for name, values in made.items()}


def joined(blocks: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """What was made of all blocks, the lanes one after the other.

    Raises
    ------
    UsageError
        A reducer gave other names, or other shapes, of another block.
    """
    shapes = [{name: values.shape[1:] for name, values in block.items()} for block in blocks]
    if other := next((each for each in shapes if each != shapes[0]), None):
        raise UsageError(
            f"the reducer gives {_told(shapes[0])} of one block of lanes and {_told(other)} of "
            "another; let it give the same names and shapes whatever the lanes are.",
            code="reduced-blocks",
        )
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


def _told(shapes: Mapping[str, tuple[int, ...]]) -> str:
    return (
        ", ".join(f"{name} of shape {('b', *shape)}" for name, shape in shapes.items()) or "nothing"
    )
