"""Cache values as long as the object from which they were computed."""

import weakref
from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

S = TypeVar("S")
T = TypeVar("T")
P = ParamSpec("P")
V = TypeVar("V")


def cached_while_alive(
    function: Callable[Concatenate[S, T, P], V],
) -> Callable[Concatenate[S, T, P], V]:
    """Return a function whose values are cached until its second argument is deleted.

    The second argument, the owner of the values, is recognised by its identity. The other arguments
    must be hashable.
    """
    cache = dict[int, dict[tuple[object, ...], V]]()

    @wraps(function)
    def cached(first: S, owner: T, /, *rest: P.args, **named: P.kwargs) -> V:
        if id(owner) not in cache:
            cache[id(owner)] = {}
            weakref.finalize(owner, cache.pop, id(owner), None)
        of_owner, key = cache[id(owner)], (first, *rest, *sorted(named.items()))
        if key not in of_owner:
            of_owner[key] = function(first, owner, *rest, **named)
        return of_owner[key]

    return cached
