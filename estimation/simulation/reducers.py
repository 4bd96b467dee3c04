"""What is kept of lanes in place of their signals: by a name, or by any function."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError
from axisid.support.real_numbers import real_array
from axisid.support.user_values import is_among, quoted


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


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=1)))


def _peak(values: Array) -> Array:
    return np.asarray(np.abs(values).max(axis=1))


#: Of (b, N) values, a row for each lane, so that a lane is summed alike in whatever company.
_OF_SIGNALS: dict[str, Callable[[Array], Array]] = {
    "final": lambda values: values[:, -1],
    "mean": lambda values: np.asarray(values.mean(axis=1)),
    "rms": _rms,
    "peak": _peak,
    "span": lambda values: np.asarray(np.ptp(values, axis=1)),
}
_OF_TRACKING = {"max_tracking_error": _peak, "rms_tracking_error": _rms}
NAMES = (*_OF_SIGNALS, *_OF_TRACKING)


def checked_reducers(
    given: str | Reducer | Sequence[str | Reducer],
) -> tuple[str | Reducer, ...]:
    """One reducer or several, as several.

    Raises
    ------
    UsageError
        There is none, or one is neither a name that is known nor callable.
    """
    reducers: tuple[str | Reducer, ...] = ()
    if isinstance(given, str) or callable(given):
        reducers = (given,)
    elif isinstance(given, Iterable):
        reducers = tuple(given)
    if not reducers or not all(is_among(each, NAMES) or callable(each) for each in reducers):
        raise UsageError(
            f"the batch is to be reduced by {quoted(given)}; give one or several of "
            f"{', '.join(NAMES)}, or a function that takes a LaneBlock and gives arrays by name.",
            code="unknown-reducer",
        )
    return reducers


def check_wanted(reducers: Sequence[str | Reducer], wanted: Sequence[str]) -> None:
    """Refuse to reduce signals where none is wanted.

    Raises
    ------
    UsageError
        A reducer is of signals, and there are none.
    """
    of_signals = [each for each in reducers if callable(each) or each in _OF_SIGNALS]
    if of_signals and not wanted:
        raise UsageError(
            f"the batch is to be reduced by {quoted(of_signals[0])}, and no signal is wanted; name "
            f"signals, or reduce by {' or '.join(_OF_TRACKING)}.",
            code="reduce-nothing",
        )


def needed_signals(reducers: Sequence[str | Reducer]) -> tuple[str, ...]:
    """The signals that reducers take beside those that are wanted."""
    return ("position",) if {*_OF_TRACKING} & {r for r in reducers if isinstance(r, str)} else ()


def reduced(
    reducers: Sequence[str | Reducer], block: LaneBlock, beside: Mapping[str, Array]
) -> dict[str, Array]:
    """What reducers make of a block, (b, ...) arrays by name.

    Parameters
    ----------
    reducers : sequence of str or callable
    block : LaneBlock
        With the signals that are wanted.
    beside : mapping of str to (N, b) array
        All that was simulated, `needed_signals` among it.

    Raises
    ------
    UsageError
        A reducer gives what is no array for each lane by name, or a name that another gave.
    """
    found: dict[str, Array] = {}
    for reducer in reducers:
        if callable(reducer):
            made = _called(reducer, block)
        elif reducer in _OF_TRACKING:
            made = {reducer: _OF_TRACKING[reducer](_by_lane(_tracking_error(block, beside)))}
        else:
            of = _OF_SIGNALS[reducer]
            made = {f"{reducer}_{s}": of(_by_lane(v)) for s, v in block.signals.items()}
        if twice := found.keys() & made.keys():
            raise UsageError(
                f"{', '.join(sorted(twice))} comes from two reducers; give each once, and other "
                "names in a function.",
                code="reduced-twice",
            )
        # A view would keep the signals of the block in memory.
        found |= {name: values.copy() for name, values in made.items()}
    return found


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


def _called(reducer: Reducer, block: LaneBlock) -> dict[str, Array]:
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
    return made


def _tracking_error(block: LaneBlock, beside: Mapping[str, Array]) -> Array:
    reference = block.reference
    return np.asarray(
        beside["position"] - (reference if reference.ndim > 1 else reference[:, None])
    )


def _by_lane(values: Array) -> Array:
    return np.ascontiguousarray(values.T)
