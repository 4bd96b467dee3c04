"""Arrays, equality to the last bit of objects that contain them, and values computed on demand.

Dimensions: N samples of a record, n rows of a regression, p physical parameters, m parameters of
the direct model. A dataclass whose members JSON represents differently (numbers that are not
finite, and arrays) is its own document: msgspec writes, reads and describes it, with the functions
`to_json`, `from_json` and `schema_of_kind` for the types that it does not know.
"""

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
IntArray: TypeAlias = NDArray[np.integer[Any]]
ComplexArray: TypeAlias = NDArray[np.complex128]


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy of values as floats."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def in_few_digits(values: ArrayLike) -> Array:
    """Return values rounded to 24 binary digits, so that their last digits have no effect.

    The last digits depend on the machine, and a loop that rounds its measurement would take other
    steps because of them. Values near an edge of the rounding may still differ.
    """
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.rint(np.ldexp(mantissa, 24)), exponent - 24), dtype=float)


def relative_error_percent(error: Array, signal: Array) -> float:
    """Return ``100 ||error|| / ||signal||``; not finite if the signal is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return 100.0 * float(np.linalg.norm(error) / np.linalg.norm(signal))


def column_sizes(columns: Array) -> Array:
    """Return the norm of each column, by which columns are scaled; 1 for a column of zeros."""
    sizes = np.linalg.norm(columns, axis=0)
    return np.where(sizes > 0, sizes, 1.0)


def finite_or_none(value: float) -> float | None:
    """Return a number for JSON: None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def runs(chosen: NDArray[np.bool_], start: int = 0) -> tuple[tuple[int, int], ...]:
    """Return the runs of true values: the first index and the one after the last of each.

    `start` is the index of the first value.
    """
    edges = start + np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    return tuple((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))


def mask_of(spans: Iterable[tuple[int, int]], size: int) -> NDArray[np.bool_]:
    """Return a mask, (size,), that is true within spans given as first index and end."""
    inside = np.zeros(size, dtype=bool)
    for start, stop in spans:
        inside[start:stop] = True
    return inside


class Exact:
    """Base of a dataclass, declared with ``eq=False``, that is equal to another one bit by bit.

    NumPy's ``==`` returns an array, which the equality of a dataclass cannot use. An object that
    comes back from another process or a pickle is equal. There is no hash.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return same(self, other) if type(other) is type(self) else NotImplemented

    __hash__ = None  # type: ignore[assignment]


def same(a: Any, b: Any) -> bool:
    """Return whether two objects are equal to the last bit, recursively; NaN equals NaN."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return bool(a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes())
    if isinstance(a, msgspec.Struct):
        return all(same(getattr(a, name), getattr(b, name)) for name in a.__struct_fields__)
    # A dataclass by its fields, unless it has an equality that it wrote itself.
    if dataclasses.is_dataclass(a) and (
        a.__dataclass_params__.eq or type(a).__eq__ in (object.__eq__, Exact.__eq__)  # type: ignore[union-attr]
    ):
        return all(
            same(getattr(a, field.name), getattr(b, field.name))
            for field in dataclasses.fields(a)
            if field.compare
        )
    if isinstance(a, Mapping):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float):
        return a == b or (a != a and b != b)
    return bool(a == b)


if TYPE_CHECKING:
    MaybeNan: TypeAlias = float
    MaybeInfinite: TypeAlias = float
else:

    class MaybeNan(Real):
        """A float; JSON's null is not a number."""

    class MaybeInfinite(Real):
        """A float; JSON's null is infinite."""

    MaybeNan.register(float)
    MaybeInfinite.register(float)

#: Value of a number that is null in JSON, by its annotation.
OF_NULL: dict[Any, float] = {MaybeInfinite: math.inf, MaybeNan: math.nan, float: math.nan}


def to_json(value: Any) -> Any:
    """Return a number or an array of NumPy as a number or a list of Python."""
    return value.tolist()


def from_json(kind: Any, value: Any) -> Any:
    """Return a value of JSON as a float for `MaybeNan` and `MaybeInfinite`, or as an array.

    Raises
    ------
    ValueError
        It cannot be converted.
    """
    try:
        if kind in OF_NULL:
            return OF_NULL[kind] if value is None else msgspec.convert(value, float)
        return np.array(msgspec.convert(value, list[float | None]), dtype=float)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def schema_of_kind(kind: Any) -> dict[str, Any]:
    """Return the JSON schema of `MaybeNan`, `MaybeInfinite` or an array."""
    number = {"type": ["number", "null"]}
    return number if kind in OF_NULL else {"type": "array", "items": number}


T = TypeVar("T")


class Deferred(Generic[T]):
    """A value that is computed when it is first requested, and only once.

    A pickle or a copy contains the value, not the function. Two are equal if their values are.

    Parameters
    ----------
    make : callable
        Function that computes the value; it is released afterwards.
    """

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make

    @classmethod
    def of(cls, value: T) -> "Deferred[T]":
        """Return a deferred object for a value that is known already."""
        return cls(lambda: value)

    @cached_property
    def value(self) -> T:
        """The value; an exception of the function is raised at every request."""
        value = self._make()
        del self._make
        return value

    def __reduce__(self) -> tuple[Any, ...]:
        return Deferred.of, (self.value,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Deferred) and same(self.value, other.value)

    __hash__ = None  # type: ignore[assignment]


class Uncached:
    """Base of a dataclass that is pickled by its fields, without cached properties."""

    __slots__ = ()

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}  # type: ignore[arg-type]


def least_squares_step(columns: Array, off: Array, least: float) -> tuple[Array, int]:
    """Return the least-squares solution, (k,), with scaled columns, and the effective rank.

    Parameters
    ----------
    columns : (n, k) array
        A column with a number that is not finite counts as 0.
    off : (n,) array
        The right-hand side.
    least : float
        Singular values below this share of the largest one are ignored.
    """
    columns = np.where(np.isfinite(columns).all(axis=0), columns, 0.0)
    scale = column_sizes(columns)
    step, _, shown, _ = np.linalg.lstsq(columns / scale, off, rcond=least)
    return step / scale, int(shown)
