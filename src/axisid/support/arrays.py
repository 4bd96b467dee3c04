"""Arrays, exact equality of objects that contain arrays, and values computed on demand.

Dimensions: N samples of a record, n rows of a regression, p physical parameters, m parameters of
the direct model. msgspec writes, reads and describes documents as JSON. `to_json`, `from_json` and
`schema_of_kind` are its functions for types that JSON does not have: arrays, and numbers that are
not finite.
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
    """Return values rounded to 24 binary digits, as an array of the same shape.

    The last digits of a computed value depend on the machine. Without the rounding, a loop that
    quantises its measurement would give other results on another machine. Values near the middle
    between two rounded values may still differ.
    """
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.rint(np.ldexp(mantissa, 24)), exponent - 24), dtype=float)


def relative_error_percent(error: Array, signal: Array) -> float:
    """Return ``100 ||error|| / ||signal||``, in per cent; not finite if the signal is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return 100.0 * float(np.linalg.norm(error) / np.linalg.norm(signal))


def column_sizes(columns: Array) -> Array:
    """Return the norm of each column of an (n, k) array, (k,); 1 for a column of zeros.

    Columns are divided by these norms before a regression.
    """
    sizes = np.linalg.norm(columns, axis=0)
    return np.where(sizes > 0, sizes, 1.0)


def finite_or_none(value: float) -> float | None:
    """Return a number for JSON: a float, or None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def runs(chosen: NDArray[np.bool_], start: int = 0) -> tuple[tuple[int, int], ...]:
    """Return (first, end) of each run of consecutive true values; `end` is the last index plus 1.

    `start` is the index of the first element of `chosen`.
    """
    edges = start + np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    return tuple((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))


def mask_of(spans: Iterable[tuple[int, int]], size: int) -> NDArray[np.bool_]:
    """Return a mask, (size,), that is true within spans (first, end), where `end` is excluded."""
    inside = np.zeros(size, dtype=bool)
    for start, stop in spans:
        inside[start:stop] = True
    return inside


class Exact:
    """Base of a dataclass with exact equality by `same`; the dataclass is declared ``eq=False``.

    The generated equality of a dataclass fails with NumPy arrays, whose ``==`` returns an array. An
    object that comes back from another process or a pickle is equal to the original. Objects are
    not hashable.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return same(self, other) if type(other) is type(self) else NotImplemented

    __hash__ = None  # type: ignore[assignment]


def same(a: Any, b: Any) -> bool:
    """Return True if two objects are of one type and equal to the last bit; NaN equals NaN.

    Arrays are compared by dtype, shape and bytes. Structs, dataclasses, mappings, tuples and lists
    are compared recursively, by their members in order.
    """
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return bool(a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes())
    if isinstance(a, msgspec.Struct):
        return all(same(getattr(a, name), getattr(b, name)) for name in a.__struct_fields__)
    # A dataclass by its fields, unless its class defines __eq__.
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
        """Annotation of a float that is NaN where JSON has null."""

    class MaybeInfinite(Real):
        """Annotation of a float that is infinite where JSON has null."""

    MaybeNan.register(float)
    MaybeInfinite.register(float)

#: Value in Python of a null in JSON, by the annotation of the number.
OF_NULL: dict[Any, float] = {MaybeInfinite: math.inf, MaybeNan: math.nan, float: math.nan}


def to_json(value: Any) -> Any:
    """Return a NumPy number or array as a Python number or list."""
    return value.tolist()


def from_json(kind: Any, value: Any) -> Any:
    """Return a JSON value as a float if `kind` is in `OF_NULL`, otherwise as an array of floats.

    Raises
    ------
    ValueError
        The value cannot be converted.
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
    """A value that is computed once, when it is first requested.

    A pickle or a copy contains the value, not the function. Two objects are equal if their values
    are the same (`same`).

    Parameters
    ----------
    make : callable
        Function that computes the value; the reference to it is deleted afterwards.
    """

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make

    @classmethod
    def of(cls, value: T) -> "Deferred[T]":
        """Return a `Deferred` whose value is already known."""
        return cls(lambda: value)

    @cached_property
    def value(self) -> T:
        """The value. If the function raises an exception, every request calls it again."""
        value = self._make()
        del self._make
        return value

    def __reduce__(self) -> tuple[Any, ...]:
        return Deferred.of, (self.value,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Deferred) and same(self.value, other.value)

    __hash__ = None  # type: ignore[assignment]


class Uncached:
    """Base of a dataclass whose pickle contains its fields but no cached properties."""

    __slots__ = ()

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}  # type: ignore[arg-type]


def least_squares_step(columns: Array, off: Array, least: float) -> tuple[Array, int]:
    """Return the least-squares solution, (k,), and the effective rank.

    The columns are scaled to norm 1 for the solution, so that their units do not matter.

    Parameters
    ----------
    columns : (n, k) array
        A column with a number that is not finite is replaced by zeros.
    off : (n,) array
        The right-hand side.
    least : float
        Singular values of the scaled columns below this share of the largest one are ignored.
    """
    columns = np.where(np.isfinite(columns).all(axis=0), columns, 0.0)
    scale = column_sizes(columns)
    step, _, rank, _ = np.linalg.lstsq(columns / scale, off, rcond=least)
    return step / scale, int(rank)
