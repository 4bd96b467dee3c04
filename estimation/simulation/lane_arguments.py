"""What a batch of loops is given, checked, and what is kept of its lanes.

Lanes side by side, gains, signals by name, threads; and in place of the lanes' signals what a
function makes of them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence, ValuesView
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import SIGNALS
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError, first_of, is_whole, quoted, real_array

_MOST_THREADS = 1024


def check_lanes(parameters: Array, reference: Array) -> None:
    """Refuse arrays that are no lanes side by side."""
    lanes = len(parameters)
    if parameters.ndim != 2 or reference.shape[1:] not in ((), (lanes,)):
        raise UsageError(
            f"parameters have the shape {parameters.shape} and the reference {reference.shape}; "
            "give (B, p) and (N,) or (N, B).",
            code="simulation-input",
        )
    if not lanes:
        raise UsageError(
            "no parameter set was given; give at least one lane.", code="simulation-input"
        )


def check_threads(threads: int | None) -> None:
    """Refuse what is no number of threads."""
    if threads is not None and not (is_whole(threads) and 1 <= threads <= _MOST_THREADS):
        raise UsageError(
            f"the threads are {quoted(threads)}; give a whole number from 1 to {_MOST_THREADS}."
        )


def checked_array(values: ArrayLike, what: str, shapes: Sequence[tuple[int, ...]]) -> Array:
    """What is given for the samples or the lanes of loops: finite numbers of one of some shapes.

    Raises
    ------
    UsageError
        It has another shape, or a number is not finite.
    """
    array = aligned(values, what)
    if array.shape not in shapes or not np.all(np.isfinite(array)):
        raise UsageError(
            f"{what} has the shape {array.shape}; give {' or '.join(map(str, shapes))}, "
            "all finite.",
            code="simulation-input",
        )
    return array


def optional_array(values: ArrayLike | None, what: str, *shapes: tuple[int, ...]) -> Array | None:
    """The same of what may be left out."""
    return None if values is None else checked_array(values, what, shapes)


def check_wanted(signals: Sequence[str]) -> None:
    """Refuse what are no names of signals of a simulation."""
    several = isinstance(signals, Iterable) and not isinstance(signals, str)
    if not several or not all(isinstance(name, str) for name in signals):
        raise UsageError(
            f"the wanted signals are {quoted(signals)}; give a list of names.",
            code="simulation-input",
        )
    if unknown := set(signals) - set(SIGNALS):
        raise UsageError(
            f"there is no signal {', '.join(sorted(unknown))}; there are {', '.join(SIGNALS)}.",
            code="simulation-input",
        )


def aligned(values: ArrayLike, what: str) -> Array:
    """The array itself, unless its floats do not lie on whole multiples of their size."""
    array = np.require(real_array(values, what), requirements=["A"])
    whole = all(stride % array.itemsize == 0 for stride in array.strides)
    return array if whole else array.copy()


def gains_by_lane(
    axis: GeneratedAxis, gains: Mapping[str, ArrayLike] | None, lanes: int
) -> Array | None:
    """All gains of the law for each lane, (B, g); None where no lane has another.

    Raises
    ------
    ModelError
        The axis has no law whose gains could change, or not that gain.
    UsageError
        There are not as many values as lanes, or they are not finite.
    """
    if not gains:
        return None
    _, law = axis.loop_with(gains)
    found, names = np.tile([*law.gains.values()], (lanes, 1)), [*law.gains]
    for name, given in gains.items():
        values = real_array(given, f"the gain {name}")
        if values.shape not in ((), (lanes,)) or np.asarray(given).dtype == bool:
            said = f"has the shape {values.shape}" if values.shape else f"is {quoted(given)}"
            raise UsageError(
                f"the gain {name} {said}; give a number, or one for each of {lanes} lanes.",
                code="simulation-input",
            )
        _check_gain(law, name, values)
        found[:, names.index(name)] = values
    return found


def _check_gain(law: ControlLaw, name: str, values: Array) -> None:
    """Refuse the first lane's value that the law cannot have.

    Raises
    ------
    UsageError
        There is one.
    """
    positive = name in law.positive
    bad = np.flatnonzero(~np.isfinite(values) | (positive & (values <= 0)))
    if bad.size:
        where = f" of lane {bad[0]}" if values.shape else ""
        raise UsageError(
            f"the gain {name}{where} is {float(values.flat[bad[0]]):g}; give "
            f"{'a finite number above 0' if positive else 'a finite number'}.",
            code="simulation-input",
        )


def axes_by_gains(axis: GeneratedAxis, gains: Array | None, lanes: int) -> list[GeneratedAxis]:
    """The axis of each lane, with its gains, (B, g); lanes with the same gains share one."""
    if gains is None or axis.axis.control is None:
        return [axis] * lanes
    names, made = [*axis.axis.control.gains], dict[tuple[float, ...], GeneratedAxis]()
    for own in map(tuple, gains.tolist()):
        if own not in made:
            made[own] = axis.with_gains(dict(zip(names, own, strict=True)))
    return [made[own] for own in map(tuple, gains.tolist())]


def in_order(
    axis: GeneratedAxis, parameters: ArrayLike | Mapping[str, ArrayLike]
) -> ArrayLike | Array:
    """Parameters that are given by name, in the axis's order; others as they are.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : array_like or mapping of str to array_like
        Of names a number each, or one for each lane, (B,).

    Returns
    -------
    (p,) or (B, p) array

    Raises
    ------
    UsageError
        A name is of no parameter, a parameter has none, or a value is True or False.
    """
    if truths := _truths(parameters):
        raise UsageError(
            f"the parameters of axis {axis.axis.name!r} have the truth value {truths[0]}; give "
            "numbers, SI.",
            code="simulation-input",
        )
    if not isinstance(parameters, Mapping):
        return parameters
    names = tuple(p.name for p in axis.axis.parameters)
    if {*parameters} != {*names}:
        unknown = [quoted(name) for name in parameters if name not in names]
        missing = [name for name in names if name not in parameters]
        wrong = f"{first_of(unknown)} is no parameter" if unknown else ""
        left = f"{first_of(missing)} is missing" if missing else ""
        raise UsageError(
            f"the parameters of axis {axis.axis.name!r} by name: "
            f"{' and '.join(filter(None, (wrong, left)))}; give a value of each of "
            f"{', '.join(names)}.",
            code="simulation-input",
        )
    values = [real_array(parameters[name], f"the values of {name}") for name in names]
    try:
        return np.stack(np.broadcast_arrays(*values), axis=-1)
    except ValueError as error:
        shapes = ", ".join(f"{n} {v.shape}" for n, v in zip(names, values, strict=True))
        raise UsageError(
            f"the parameters by name have the shapes {shapes}; give each one number, or one for "
            "each lane.",
            code="simulation-input",
        ) from error


def _truths(given: object) -> list[bool]:
    """Truth values among what is given, which would count as 1 and 0."""
    if isinstance(given, np.ndarray):
        return [bool(each) for each in given.ravel()[:1]] if given.dtype.kind == "b" else []
    if isinstance(given, (bool, np.bool_)):
        return [bool(given)]
    values = given.values() if isinstance(given, Mapping) else given
    if not isinstance(values, (list, tuple, ValuesView)):
        return []
    return [found for each in values for found in _truths(each)]


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
            code="simulation-input",
        )
    if not wanted:
        raise UsageError(
            f"the batch is to be reduced by {quoted(reducer)}, and no signal is wanted; name "
            "signals.",
            code="simulation-input",
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
            code="simulation-input",
        )
    made = {name: real_array(values, f"the reduced {name}") for name, values in given.items()}
    for name, values in made.items():
        if values.shape[:1] != (block.lanes,):
            raise UsageError(
                f"the reducer gives {name} of the shape {values.shape} for {block.lanes} lanes; "
                "let its first dimension be the lanes.",
                code="simulation-input",
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
            code="simulation-input",
        )
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


def _told(shapes: Mapping[str, tuple[int, ...]]) -> str:
    return (
        ", ".join(f"{name} of shape {('b', *shape)}" for name, shape in shapes.items()) or "nothing"
    )
