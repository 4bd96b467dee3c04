"""What is computed once for an axis and a record, and kept as long as the record is alive."""

import weakref
from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import Record

P = ParamSpec("P")
V = TypeVar("V")


def cached_per_record(
    function: Callable[Concatenate[GeneratedAxis, Record, P], V],
) -> Callable[Concatenate[GeneratedAxis, Record, P], V]:
    """A function of an axis and a record that is asked in every iteration, and computed once.

    What it gives is kept as long as the record is alive.
    """
    cache = dict[int, dict[tuple[object, ...], V]]()

    @wraps(function)
    def cached(axis: GeneratedAxis, record: Record, /, *rest: P.args, **named: P.kwargs) -> V:
        if id(record) not in cache:
            cache[id(record)] = {}
            weakref.finalize(record, cache.pop, id(record), None)
        of_record, key = cache[id(record)], (axis, *rest, *sorted(named.items()))
        if key not in of_record:
            of_record[key] = function(axis, record, *rest, **named)
        return of_record[key]

    return cached
