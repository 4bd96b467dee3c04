"""Find where functions change: kinks, edges of roots, transitions of smooth functions.

A *feature* is the value that decides how a function behaves: the argument of ``Abs``, the
difference of two arguments of ``Max``, the argument of ``tanh``. At a kink, this value is 0. A
smooth function such as ``tanh`` is almost constant unless its argument is of moderate size.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

_SIGNED = (sympy.Abs, sympy.sign, sympy.Heaviside)
#: Functions that are almost constant, or larger than any other term, unless the argument is small.
_FLAT = (sympy.tanh, sympy.sinh, sympy.cosh)
_OTHER = (sympy.sin, sympy.cos, sympy.tan, sympy.atan, sympy.asin, sympy.acos, sympy.log)
_STEPS = 100  # largest number of steps to a crossing
_CLOSE = 1e-24  # relative accuracy of a crossing
_TOUCH = 1e-18  # value, as a share of the values around it, up to which a function touches 0
_SAME = 1e-15  # relative difference up to which two places are the same
_PARABOLAS = 12  # largest number of steps by parabolas


@dataclass(frozen=True, slots=True)
class Feature:
    """A value that decides the branch or the transition of a function.

    Attributes
    ----------
    node : sympy.Basic
        The function.
    parts : tuple of one or two sympy.Expr
        The value, or two expressions whose difference is the value.
    sharp : bool
        Whether the function may have a kink, a jump or an edge where the value is 0. Otherwise it
        is smooth, and has its transition where the value is of moderate size.
    needed : bool
        Whether two functions may differ only on the other side of the kink, or only in the
        transition, so that points must be evaluated there.
    """

    node: sympy.Basic
    parts: tuple[sympy.Expr, ...]
    sharp: bool
    needed: bool

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """Return the symbols of the value."""
        return set().union(*(part.free_symbols for part in self.parts))

    @property
    def has_known_places(self) -> bool:
        """Return whether the search finds all kinks of the function.

        True for a smooth function, which has no kink, and for the angle of a point (atan2), which
        is one function. Otherwise each part must be piecewise linear or quadratic in one symbol, or
        linear in each of several symbols.
        """
        if not self.sharp or isinstance(self.node, sympy.atan2):
            return True
        return all(map(_has_known_places, self.parts))

    @property
    def is_piecewise_linear(self) -> bool:
        """Return whether the value is piecewise linear, so that it touches 0 only at kinks."""
        return all(map(_is_piecewise_linear, self.parts))

    @property
    def is_one_sided(self) -> bool:
        """Return whether the value never changes its sign, as far as SymPy knows."""
        value = self.parts[0] - self.parts[1] if len(self.parts) > 1 else self.parts[0]
        return bool(value.is_nonnegative or value.is_nonpositive)


def _has_known_places(part: sympy.Expr) -> bool:
    """Return whether all zeros of one part of a feature's value can be found."""
    symbols = part.free_symbols
    if len(symbols) > 1:
        return part.is_polynomial(*symbols) and all(_degree_is(1, part, s) for s in symbols)
    return _is_piecewise_linear(part) or all(
        part.is_polynomial(s) and _degree_is(2, part, s) for s in symbols
    )


def _degree_is(most: int, part: sympy.Expr, symbol: sympy.Symbol) -> bool:
    """Return whether the degree of a polynomial in a symbol is at most `most`."""
    return bool(sympy.degree(part, symbol) <= most)


def _is_piecewise_linear(node: sympy.Basic) -> bool:
    """Return whether an expression is made of symbols, numbers, sums, Abs, Max, Min and sign."""
    if node.is_Symbol or not node.free_symbols:
        return True
    if node.is_Mul:
        moving = [factor for factor in node.args if factor.free_symbols]
        return len(moving) == 1 and _is_piecewise_linear(moving[0])
    if node.is_Add or isinstance(node, (sympy.Abs, sympy.Max, sympy.Min, sympy.sign)):
        return all(map(_is_piecewise_linear, node.args))
    return False


def features_of(expression: sympy.Basic) -> Iterator[Feature]:
    """Yield the features of an expression, those of inner functions first; some may repeat."""
    for node in _once(expression):
        yield from (feature for feature in _features(node) if feature.symbols)


def _once(expression: sympy.Basic) -> Iterator[sympy.Basic]:
    """Yield the nodes of an expression, each once, inner nodes first."""
    seen: set[sympy.Basic] = set()
    stack = [(expression, False)]
    while stack:
        node, ready = stack.pop()
        if ready:
            yield node
        elif node not in seen:
            seen.add(node)
            stack.append((node, True))
            stack.extend((argument, False) for argument in node.args)


def _features(node: sympy.Basic) -> Iterator[Feature]:
    """Yield the features of a single function, without those of its arguments."""
    if isinstance(node, _SIGNED):
        yield from _edges(node, needed=True)
    elif isinstance(node, (Max, Min)):
        yield from (
            Feature(node, pair, sharp=True, needed=True) for pair in combinations(node.args, 2)
        )
    elif isinstance(node, sympy.Piecewise):
        for relation in sorted(node.atoms(Relational), key=sympy.default_sort_key):
            yield Feature(node, (relation.lhs, relation.rhs), sharp=True, needed=True)
    elif isinstance(node, sympy.exp):
        yield Feature(node, (node.args[0],), sharp=False, needed=True)
    elif node.is_Mul:
        yield from _scaled_exponentials(node)
    elif node.is_Pow:
        if not node.exp.is_Integer:
            yield from _edges(node, needed=False)
    elif isinstance(node, sympy.Function):
        yield from _of_function(node)


def _of_function(node: sympy.Function) -> Iterator[Feature]:
    """Yield the features of a smooth function, and the edges of log, asin and acos."""
    if isinstance(node, sympy.atan2):
        for argument in node.args:
            yield Feature(node, (argument,), sharp=True, needed=argument == node.args[0])
        return
    if isinstance(node, sympy.log):
        yield from _edges(node, needed=False)
    elif isinstance(node, (sympy.asin, sympy.acos)):
        for edge in (sympy.S.One, sympy.S.NegativeOne):
            yield Feature(node, (node.args[0], edge), sharp=True, needed=True)
    if isinstance(node, (*_FLAT, *_OTHER)):
        yield Feature(node, (node.args[0],), sharp=False, needed=isinstance(node, _FLAT))


def _edges(node: sympy.Expr, *, needed: bool) -> Iterator[Feature]:
    """Yield one feature for each factor of a function's argument, with a kink where it is 0."""
    for factor in _factors(node.args[0]):
        yield Feature(node, (factor,), sharp=True, needed=needed)


def _scaled_exponentials(product: sympy.Mul) -> Iterator[Feature]:
    """Yield the transition of an exponential with a factor, as in ``exp(x - 3000.0)``.

    SymPy writes it as a number times ``exp(x)``.
    """
    number = product.args[0]
    if number.is_Number:
        for factor in product.args:
            if isinstance(factor, sympy.exp):
                offset = -sympy.log(abs(number))
                yield Feature(product, (factor.args[0], offset), sharp=False, needed=True)


def _factors(argument: sympy.Expr) -> Iterator[sympy.Expr]:
    """Yield the factors of a product that can be 0, without their exponents."""
    for factor in sympy.Mul.make_args(argument):
        base, exponent = factor.as_base_exp()
        yield base if exponent.is_Number else factor


def crossings(
    value: Callable[[Any], Any], grid: Sequence[Any], *, curved: bool = True
) -> list[Any]:
    """Return arguments at which a function changes its sign or touches 0, in ascending order.

    Parameters
    ----------
    value : callable
        The function; NaN where it has no value.
    grid : sequence of number
        Arguments, ascending, between which zeros are searched; two zeros between neighbours are
        found only if a parabola leads there.
    curved : bool
        Whether the function may touch 0 between two arguments of the grid.
    """
    sizes = [value(place) for place in grid]
    found = [place for place, size in zip(grid, sizes, strict=True) if size == 0]
    # A change of sign between neighbours is a zero.
    for low, high in pairwise(zip(grid, sizes, strict=True)):
        if low[1] * high[1] < 0:
            found.append(_between(value, low, high))
    # At a local minimum of the absolute value without a change of sign, the function may touch 0.
    for i in range(1, len(grid) - 1) if curved else ():
        before, here, after = (abs(size) for size in sizes[i - 1 : i + 2])
        if here and here <= before and here <= after and before != after:
            same_sign = sizes[i - 1] * sizes[i] > 0 and sizes[i] * sizes[i + 1] > 0
            if same_sign:
                found += _by_parabola(value, grid[i - 1 : i + 2], sizes[i - 1 : i + 2])
    return apart(found)


def _between(value: Callable[[Any], Any], low: tuple[Any, Any], high: tuple[Any, Any]) -> Any:
    """Return the argument of a change of sign, by the Illinois method with bisections.

    Parameters
    ----------
    value : callable
    low, high : (number, number)
        Argument and value on both sides of the change of sign.
    """
    (a, at_a), (b, at_b) = low, high
    side = 0
    for step in range(_STEPS):
        if abs(b - a) <= _CLOSE * max(abs(a), abs(b)):
            break
        middle = (a + b) / 2 if step % 4 == 3 else (a * at_b - b * at_a) / (at_b - at_a)
        at_middle = value(middle)
        if at_middle == 0 or at_middle != at_middle:
            return middle
        if at_middle * at_b > 0:
            b, at_b = middle, at_middle
            at_a = at_a / 2 if side == -1 else at_a
            side = -1
        else:
            a, at_a = middle, at_middle
            at_b = at_b / 2 if side == 1 else at_b
            side = 1
    return (a + b) / 2


def _by_parabola(
    value: Callable[[Any], Any], places: Sequence[Any], sizes: Sequence[Any]
) -> list[Any]:
    """Return zeros of a function near a minimum of its size, by parabolas through three points.

    Parameters
    ----------
    value : callable
    places, sizes : sequence of number
        Three arguments and the values there.
    """
    # The parabola through the three points, offset + slope x + bend x**2.
    (x0, x1, x2), (y0, y1, y2) = places, sizes
    largest = max(abs(y0), abs(y1), abs(y2))
    first = (y1 - y0) / (x1 - x0)
    bend = ((y2 - y1) / (x2 - x1) - first) / (x2 - x0)
    if bend == 0 or bend != bend:
        return []
    slope = first - bend * (x0 + x1)
    offset = y0 - first * x0 + bend * x0 * x1
    # Its two zeros; its vertex if it does not reach 0, or hardly.
    lowest = -slope / (2 * bend)
    room = lowest**2 - offset / bend
    if room <= _TOUCH * (lowest**2 + abs(offset / bend)):
        roots = [lowest]
    else:
        roots = [lowest - room**0.5, lowest + room**0.5]
    polished = [_polished(value, root, x1 - x0) for root in roots]
    return [root for root in polished if _is_zero(value, root, largest)]


def _polished(value: Callable[[Any], Any], place: Any, width: Any) -> Any:
    """Return an argument closer to a zero of a function, by repeated parabolas.

    Parameters
    ----------
    value : callable
    place : number
        The argument to start from.
    width : number
        Distance of neighbouring arguments.
    """
    step = abs(width) * 1e-3
    for _ in range(_PARABOLAS):
        below, here, above = value(place - step), value(place), value(place + step)
        if here == 0 or here != here or below != below or above != above:
            break
        slope, bend = (above - below) / (2 * step), (above - 2 * here + below) / step**2
        if bend and (slope**2 <= 2 * abs(bend * here) * (1 + 1e-9)):
            move = -slope / bend  # to the vertex, the only place at which the parabola may touch 0
        elif slope:
            move = -here / slope
        else:
            break
        place, step = place + move, max(min(step, abs(move)) / 8, step * 1e-4)
        if abs(move) <= _CLOSE * abs(place):
            break
    return place


def _is_zero(value: Callable[[Any], Any], place: Any, largest: Any) -> bool:
    """Return whether the value at an argument is negligible next to the `largest` nearby value."""
    size = value(place)
    return bool(abs(size) <= _TOUCH * largest)


def apart(places: Iterable[Any]) -> list[Any]:
    """Return arguments in ascending order; arguments equal up to rounding are kept once."""
    found: list[Any] = []
    for place in sorted(places):
        if not found or place - found[-1] > _SAME * max(abs(place), abs(found[-1])):
            found.append(place)
    return found
