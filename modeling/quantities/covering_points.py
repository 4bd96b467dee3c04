"""Points that cover functions: over decades, on both sides of kinks, and in transitions.

Two functions that agree at a few points may differ elsewhere: ``tanh(dq/vs)`` is a constant to all
available digits unless the velocity is near ``vs``. A *feature* is a kink of a function or the
transition of a smooth one. For each feature, points that show it are found by solving for a symbol.
A feature for which no such point was found remains a doubt.
"""

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set as AbstractSet
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import sympy

from .features import Feature, apart, crossings, features_of
from .point_value import CANNOT, DrawnPoint, Points, Value, drawn, exactly, is_nothing, numbers
from .symbols import DIRECTION

#: Decades of the numbers that replace symbols, and the walk of the points through them.
_LOWEST, _DECADES = -9, 14
_STRIDES = (1, 3, 5, 9, 11, 13)
_GRID = tuple(numbers.mpf(x) for x in (1e-6, 1e-3, 0.03, 0.3, 1, 3, 30, 1e3, 1e5))
_FEW_PLACES = tuple(numbers.mpf(x) for x in (1e-4, 0.03, 10, 1e4))
_MOST_SOLVED = 12  # features of several symbols for which one cycle is solved, at least
_SOLVED_BITS = 160  # binary digits with which places are found
_TRANSITION = (0.1, 3.0)  # sizes of an argument within a smooth function's transition
_MODERATE = 40  # size of an argument up to which the transition is visible in many digits
_MOST_PLACES = 3  # places of one transition in one cycle
_SCALE = 10**6  # largest number of points of one cycle


class CoveringPoints:
    """Cycles of points, each of which covers a list of functions with new points.

    A point gives a number to each symbol. The *place* of a symbol is its number at a point that
    shows a feature.

    Parameters
    ----------
    points : Points
        Source of the numbers of the symbols.
    functions : sequence of sympy.Expr
    moderate : set of sympy.Symbol
        Symbols whose numbers stay of moderate size, so that their factors remain visible next to
        other terms.

    Attributes
    ----------
    features : tuple of Feature
        Features of all functions.
    symbols : list of sympy.Symbol
        Symbols of the functions, without those with given numbers.
    moderate : list of sympy.Symbol
        Symbols among them whose numbers stay of moderate size.
    """

    def __init__(
        self,
        points: Points,
        functions: Sequence[sympy.Expr],
        *,
        moderate: AbstractSet[sympy.Symbol] = frozenset(),
    ) -> None:
        self._points = points
        self._of = [list(dict.fromkeys(features_of(function))) for function in functions]
        found = dict.fromkeys(feature for own in self._of for feature in own)
        if points.velocity is not None and any(DIRECTION in f.free_symbols for f in functions):
            found[self._direction] = None
            for own, function in zip(self._of, functions, strict=True):
                if DIRECTION in function.free_symbols:
                    own.append(self._direction)
        self.features = tuple(found)
        self._symbols = {feature: self._solvable(feature) for feature in self.features}
        free = set().union(*(function.free_symbols for function in functions))
        self.symbols = self._ordered(self._without_direction(free))
        self.moderate = [symbol for symbol in self.symbols if symbol in moderate]
        self._kinks: dict[sympy.Symbol, list[Any]] = {}
        self._lines: dict[tuple[sympy.Symbol, int], list[Any]] = {}
        self._seen: dict[Feature, set[Any]] = {feature: set() for feature in self.features}

    @property
    def velocity(self) -> sympy.Symbol | None:
        """Return the symbol whose sign is the friction direction."""
        return self._points.velocity

    @property
    def _direction(self) -> Feature:
        """Return the friction direction as a feature: a jump where the velocity is 0."""
        velocity = self._points.velocity
        return Feature(DIRECTION, (velocity,), sharp=True, needed=True)

    def _without_direction(self, symbols: set[sympy.Symbol]) -> set[sympy.Symbol]:
        """Return the symbols whose numbers can be chosen.

        The velocity replaces the friction direction, which is its sign. Symbols with given numbers
        are omitted.
        """
        velocity = self._points.velocity
        if velocity is not None and DIRECTION in symbols:
            symbols = (symbols - {DIRECTION}) | {velocity}
        return symbols - self._points.given.keys()

    def _ordered(self, symbols: set[sympy.Symbol]) -> list[sympy.Symbol]:
        """Return symbols in an order that does not depend on their names."""
        return sorted(symbols, key=lambda symbol: self._points.places.get(symbol, -1))

    def _solvable(self, feature: Feature) -> list[sympy.Symbol]:
        """Return the symbols of a feature for which its equation can be solved.

        They are in the order of `_ordered`. Symbols with given numbers are omitted, and the
        velocity replaces the friction direction.
        """
        return self._ordered(self._without_direction(feature.symbols))

    def cycle(self, number: int, *, decimals: bool = False) -> Iterator[DrawnPoint]:
        """Yield the points of cycle `number`; each cycle has new points.

        First come points over the decades of all symbols, then points at the features of a single
        symbol, then points at the features of several symbols.

        Parameters
        ----------
        number : int
        decimals : bool
            Whether declared decimals are changed as by rounding, in the second value of each
            number.
        """
        first = turn = number * _SCALE
        for turn in range(first, first + _DECADES):
            yield self._drawn(turn, {}, decimals=decimals)
        for symbol in self.symbols:
            for place in self._places(symbol, number):
                turn += 1
                yield self._drawn(turn, {symbol: place}, decimals=decimals)
        for feature in self._of_several_symbols(number):
            for side in (1, -1):
                turn += 1
                placed = self._placed(feature, side, turn)
                if placed:
                    yield self._drawn(turn, placed, decimals=decimals)

    def _of_several_symbols(self, number: int) -> list[Feature]:
        """Return the features of several symbols for which one cycle finds points.

        These are 12 features, different ones in each cycle, and all features that no point has
        shown so far.
        """
        several = [feature for feature, symbols in self._symbols.items() if len(symbols) > 1]
        start = number * _MOST_SOLVED % max(len(several), 1)
        shown = [*several[start:], *several[:start]][:_MOST_SOLVED]
        return [*shown, *(f for f in several if f not in shown and not self._is_shown(f))]

    def observe(self, point: DrawnPoint) -> None:
        """Record which features a point shows, and on which side of a kink."""
        for feature, seen in self._seen.items():
            if not self._is_shown(feature):
                with contextlib.suppress(*CANNOT):
                    value = _value(point, feature)
                    size = numbers.re(value[0])
                    if feature.sharp and not is_nothing(value):
                        seen.add(numbers.sign(size))
                    elif not feature.sharp and abs(size) <= _MODERATE:
                        seen.add(numbers.one)

    def unresolved(self, columns: Iterable[int]) -> list[Feature]:
        """Return the features beyond which functions may still differ.

        These are features that points have not shown (`_is_shown`), and features whose kinks are at
        unknown places. A kink whose value never changes its sign is omitted.

        Parameters
        ----------
        columns : iterable of int
            Indices of the functions.
        """
        # A value may be 0 at several places or along a line, of which points show only some.
        needed = self.needed(columns)
        open_ = [f for f in needed if not (f.has_known_places and self._is_shown(f))]
        return [f for f in open_ if not (f.sharp and f.is_one_sided)]

    def needed(self, columns: Iterable[int]) -> list[Feature]:
        """Return the features beyond which functions may differ.

        Parameters
        ----------
        columns : iterable of int
            Indices of the functions.
        """
        own = dict.fromkeys(feature for j in columns for feature in self._of[j])
        return [feature for feature in own if feature.needed and self._symbols[feature]]

    def _is_shown(self, feature: Feature) -> bool:
        """Return whether points on both sides of a kink, or in a transition, were evaluated."""
        return len(self._seen[feature]) == (2 if feature.sharp else 1)

    def _drawn(self, turn: int, placed: dict[sympy.Symbol, Any], *, decimals: bool) -> DrawnPoint:
        """Return point number `turn`, with the given numbers of some symbols.

        The other symbols get numbers from `_anywhere`.
        """
        values = {symbol: exactly(place) for symbol, place in placed.items()}
        for symbol in self.symbols:
            if symbol not in values:
                values[symbol] = exactly(self._anywhere(symbol, turn))
        return DrawnPoint(self._points, turn, values, decimals=decimals)

    def _anywhere(self, symbol: sympy.Symbol, turn: int) -> Any:
        """Return a number of a symbol for point number `turn`, chosen at random.

        It is a place of one of the symbol's features, a number of moderate size, or a number of any
        decade.
        """
        if symbol in self.moderate:
            return self._points.generic(symbol, turn)
        about = str(self._points.places.get(symbol, -1))
        order = int(about) % len(_STRIDES)
        kind = drawn(turn, "kind", about)
        if turn % _SCALE >= _DECADES:
            if kind < 1:
                places = self._places(symbol, turn // _SCALE)
                if places:
                    return places[int(1000 * drawn(turn, "place", about)) % len(places)]
            if kind < 1.3:
                return self._points.generic(symbol, turn)
        decade = _LOWEST + (turn % _SCALE * _STRIDES[order] + int(about)) % _DECADES
        size = numbers.mpf(10) ** (decade + drawn(turn, "size in decade", about) - 0.5)
        turned = not symbol.is_positive and drawn(turn, "sign in decade", about) < 1
        return -size if turned else size

    def _places(self, symbol: sympy.Symbol, number: int) -> list[Any]:
        """Return numbers of a symbol that show the features of this symbol alone, for one cycle."""
        key = (symbol, number)
        if key not in self._lines:
            own = [f for f, symbols in self._symbols.items() if symbols == [symbol]]
            with numbers.workprec(_SOLVED_BITS):
                self._lines[key] = self._along(symbol, own, number) if own else []
        return self._lines[key]

    def _along(self, symbol: sympy.Symbol, own: Sequence[Feature], number: int) -> list[Any]:
        """Return numbers of a symbol between its kinks, and in the transitions of smooth functions.

        Parameters
        ----------
        symbol : sympy.Symbol
        own : sequence of Feature
            Features that have no other symbol.
        number : int
            Number of the cycle.
        """
        if symbol not in self._kinks:
            self._kinks[symbol] = self._found_kinks(symbol, own)
        kinks, turn = self._kinks[symbol], number * _SCALE
        found: list[Any] = []
        for low, high in pairwise([None, *kinks, None]):
            share = drawn(turn, "share", str(len(found)))
            found += _inside(low, high, share, middle=number % 2 == 0)
        spots = self._spots(symbol, _grid(kinks))
        for feature in own:
            if not feature.sharp:
                for sign in (1, -1):
                    found += self._solved(feature, spots, _target(turn, sign))[:_MOST_PLACES]
        return found

    def _found_kinks(self, symbol: sympy.Symbol, own: Sequence[Feature]) -> list[Any]:
        """Return the numbers of a symbol at which there are kinks of the given features.

        After each feature with kinks, the grid of the search is extended by the kinks found.
        """
        kinks: list[Any] = []
        spots = self._spots(symbol, _grid(()))
        for feature in own:
            if feature.sharp:
                found = self._solved(feature, spots)
                more = [place for place in apart([*kinks, *found]) if place not in kinks]
                if more:
                    kinks = apart([*kinks, *more])
                    places = spots.points.keys() | set(_grid(kinks))
                    spots = self._spots(symbol, sorted(places), spots)
        return kinks

    def _spots(
        self,
        symbol: sympy.Symbol,
        grid: Iterable[Any],
        before: "_Spots | None" = None,
        placed: Mapping[sympy.Basic, Value] | None = None,
        turn: int = 0,
    ) -> "_Spots":
        """Return points at which a symbol has the numbers of a grid; several features use them.

        Parameters
        ----------
        symbol : sympy.Symbol
        grid : iterable of number
        before : _Spots, optional
            Points that were evaluated earlier and are used again.
        placed : mapping, optional
            Numbers of other symbols.
        turn : int
            Number of the point, from which the remaining numbers are drawn.
        """
        known = before.points if before else {}
        fixed = placed or {}
        spots = _Spots(symbol, fixed, turn, {})
        for place in grid:
            if place > 0 or not symbol.is_positive:
                spots.points[place] = known.get(place) or self._spot(spots, place)
        return spots

    def _spot(self, spots: "_Spots", place: Any) -> DrawnPoint:
        """Return the point at which the symbol of `spots` has the number `place`."""
        placed = {**spots.placed, spots.symbol: exactly(place)}
        return DrawnPoint(self._points, spots.turn, placed, decimals=False)

    def _solved(self, feature: Feature, spots: "_Spots", target: Any = 0) -> list[Any]:
        """Return numbers of a symbol at which the value of a feature is `target`.

        They are searched between the points of `spots`. The list is empty if none is found.
        """

        def value(place: Any) -> Any:
            """Return the distance from the target; NaN if the feature has no real value."""
            there = spots.points.get(place) or self._spot(spots, place)
            try:
                number = _value(there, feature)[0]
            except CANNOT:
                return numbers.nan
            return numbers.nan if numbers.im(number) else numbers.re(number) - target

        with contextlib.suppress(*CANNOT):
            return crossings(value, list(spots.points), curved=not feature.is_piecewise_linear)
        return []

    def _placed(self, feature: Feature, side: int, turn: int) -> dict[sympy.Symbol, Any]:
        """Return numbers of all symbols that show a feature of several symbols.

        The number of one symbol is solved for, the numbers of the others are random. For a kink,
        the solved number is moved a little to the given side. The result is empty if no number is
        found.

        Parameters
        ----------
        feature : Feature
        side : int
            1 or -1: side of the kink, or sign of the value in the transition.
        turn : int
            Number of the point.
        """
        symbols = self._symbols[feature]
        values = {s: self._anywhere(s, turn) for s in self.symbols}
        order = sorted(symbols, key=lambda s: drawn(turn, "solved", str(self._points.places[s])))
        with numbers.workprec(_SOLVED_BITS):
            target = 0 if feature.sharp else _target(turn, side)
            for symbol in order:
                fixed = {s: exactly(x) for s, x in values.items() if s != symbol}
                near = self._points.generic(symbol, turn)
                grid = sorted({near, -near, *_FEW_PLACES, *(-x for x in _FEW_PLACES)})
                found = self._solved(feature, self._spots(symbol, grid, None, fixed, turn), target)
                if found:
                    place = found[int(1000 * drawn(turn, "crossing")) % len(found)]
                    if feature.sharp:
                        step = numbers.mpf(10) ** (-7 * (drawn(turn, "step") - 0.5))
                        place += side * step * (abs(place) or 1)
                    return {**values, symbol: place}
        return {}


@dataclass(frozen=True, slots=True)
class _Spots:
    """Points that differ in the number of one symbol, by this number.

    Attributes
    ----------
    symbol : sympy.Symbol
    placed : mapping of sympy.Basic to Value
        Numbers of other symbols, the same at all points.
    turn : int
        Number of the point, from which the remaining numbers are drawn.
    points : dict of number to DrawnPoint
    """

    symbol: sympy.Symbol
    placed: Mapping[sympy.Basic, Value]
    turn: int
    points: dict[Any, DrawnPoint]


def _value(point: DrawnPoint, feature: Feature) -> Value:
    """Return the value of a feature at a point, and the value as changed by rounding."""
    if len(feature.parts) == 1:
        return point(feature.parts[0])
    (one, one_off), (other, other_off) = map(point, feature.parts)
    return one - other, one_off - other_off


def _grid(kinks: Iterable[Any]) -> list[Any]:
    """Return numbers of all decades and both signs, the kinks, and the middles between kinks."""
    between = [(low + high) / 2 for low, high in pairwise(kinks)]
    return sorted({numbers.zero, *_GRID, *(-x for x in _GRID), *kinks, *between})


def _target(turn: int, sign: int) -> Any:
    """Return a random argument of given sign at which a smooth function is in its transition."""
    low, high = (numbers.log(size) for size in _TRANSITION)
    return sign * numbers.exp(low + (high - low) * (drawn(turn, "target", str(sign)) - 0.5))


def _inside(low: Any, high: Any, share: Any, *, middle: bool) -> list[Any]:
    """Return two numbers between two neighbouring kinks, or beyond the outermost one.

    Parameters
    ----------
    low, high : number or None
        The neighbouring kinks; None beyond the outermost one.
    share : number
        Random number between 1/2 and 3/2 that decides the distances from the kinks.
    middle : bool
        Whether one of the two numbers is in the middle between two kinks.
    """
    if low is None and high is None:
        return []
    if low is not None and high is not None:
        inner = numbers.mpf(1) / 2 if middle else 0.1 + 0.8 * (share - 0.5)
        edge = 1e-3 * share
        edge = edge if int(1000 * share) % 2 else 1 - edge
        return [low + inner * (high - low), low + edge * (high - low)]
    sign, end = (1, low) if high is None else (-1, high)
    size = abs(end) or numbers.one
    return [end + sign * 1e-3 * share * size, end + sign * share * (size + 1)]
