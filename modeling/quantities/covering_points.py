"""Points that cover functions: over decades, on both sides of kinks, between them, in transitions.

Two functions that agree at a few points may differ elsewhere: ``tanh(dq/vs)`` is a constant to all
digits that there are unless the velocity is near ``vs``. So for each kink and each smooth function
places are found at which it shows, by solving for a symbol. A kink or a transition for which no
such point was found leaves a doubt.
"""

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from .features import Feature, crossings, features_of
from .point_value import CANNOT, Drawn, Points, Value, drawn, exactly, is_nothing, numbers
from .symbols import DIRECTION

#: Decades of the numbers in place of symbols, and how the points walk through them.
_LOWEST, _DECADES = -9, 14
_STRIDES = (1, 3, 5, 9, 11, 13)
_GRID = tuple(numbers.mpf(x) for x in (1e-6, 1e-3, 0.03, 0.3, 1, 3, 30, 1e3, 1e5))
_AROUND = tuple(numbers.mpf(x) for x in (1e-9, 1e-7, 1e-5, 1e-3, 1e-1))
_SOLVED_BITS = 160  # digits in which places are found
_TRANSITION = (0.1, 3.0)  # sizes of an argument between which a smooth function shows
_MODERATE = 40  # up to which it still does, in many digits
_MOST_PLACES = 3  # of one transition, at one time
_BENT = (sympy.Abs, sympy.sign, sympy.Heaviside, sympy.Piecewise, Max, Min)
_SCALE = 10**6  # points of one cycle, at most


class CoveringPoints:
    """Points of which each cycle covers a list of functions anew.

    Parameters
    ----------
    points : Points
        Of the functions.
    functions : sequence of sympy.Expr

    Attributes
    ----------
    features : tuple of Feature
        Of all functions.
    """

    def __init__(self, points: Points, functions: Sequence[sympy.Expr]) -> None:
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
        self._free = self._ordered(self._without_direction(free))
        self._lines: dict[sympy.Symbol, list[Any]] = {}
        self._seen: dict[Feature, set[Any]] = {feature: set() for feature in self.features}

    @property
    def _direction(self) -> Feature:
        velocity = self._points.velocity
        return Feature(DIRECTION, (velocity,), sharp=True, needed=True)

    def _without_direction(self, symbols: set[sympy.Symbol]) -> set[sympy.Symbol]:
        velocity = self._points.velocity
        if velocity is not None and DIRECTION in symbols:
            symbols = (symbols - {DIRECTION}) | {velocity}
        return symbols - self._points.given.keys()

    def _ordered(self, symbols: set[sympy.Symbol]) -> list[sympy.Symbol]:
        return sorted(symbols, key=lambda symbol: self._points.places.get(symbol, -1))

    def _solvable(self, feature: Feature) -> list[sympy.Symbol]:
        return self._ordered(self._without_direction(feature.symbols))

    def cycle(self, number: int, *, decimals: bool = False) -> Iterator[Drawn]:
        """Points over the decades, and some at each feature; other ones in each cycle."""
        first = turn = number * _SCALE
        for turn in range(first, first + _DECADES):
            yield self._drawn(turn, {}, decimals=decimals)
        for symbol in self._free:
            for place in self._places(symbol, number):
                turn += 1
                yield self._drawn(turn, {symbol: place}, decimals=decimals)
        for feature, symbols in self._symbols.items():
            if len(symbols) > 1:
                for side in (1, -1):
                    turn += 1
                    placed = self._placed(feature, side, turn)
                    if placed:
                        yield self._drawn(turn, placed, decimals=decimals)

    def observe(self, point: Drawn) -> None:
        """Keep which features a point shows."""
        for feature, seen in self._seen.items():
            if feature.needed and len(seen) < 1 + feature.sharp:
                with contextlib.suppress(*CANNOT):
                    value = _value(point, feature)
                    size = numbers.re(value[0])
                    if feature.sharp and not is_nothing(value):
                        seen.add(numbers.sign(size))
                    elif not feature.sharp and abs(size) <= _MODERATE:
                        seen.add(numbers.one)

    def unresolved(self, columns: Iterable[int]) -> list[Feature]:
        """Features of some of the functions which no point has shown so far."""
        own = dict.fromkeys(feature for j in columns for feature in self._of[j])
        open_ = [f for f in own if f.needed and len(self._seen[f]) < 1 + f.sharp]
        return [f for f in open_ if self._symbols[f] and not (f.sharp and f.is_one_sided)]

    def _drawn(self, turn: int, placed: dict[sympy.Symbol, Any], *, decimals: bool) -> Drawn:
        """A point at which some symbols have a place; the others may have one too."""
        values = {symbol: exactly(place) for symbol, place in placed.items()}
        for symbol in self._free:
            if symbol not in values:
                values[symbol] = exactly(self._anywhere(symbol, turn))
        return Drawn(self._points, turn, values, decimals=decimals)

    def _anywhere(self, symbol: sympy.Symbol, turn: int) -> Any:
        """A number of a symbol: at a place of its own, of moderate size, or of any decade."""
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
        """Places of the features that a symbol alone decides, other ones in each cycle."""
        key = (symbol, number)
        if key not in self._lines:
            own = [f for f, symbols in self._symbols.items() if symbols == [symbol]]
            with numbers.workprec(_SOLVED_BITS):
                self._lines[key] = self._along(symbol, own, number) if own else []
        return self._lines[key]

    def _along(self, symbol: sympy.Symbol, own: Sequence[Feature], number: int) -> list[Any]:
        kinks = self._kinks(symbol, own)
        turn = number * _SCALE
        found: list[Any] = []
        for low, high in zip([None, *kinks], [*kinks, None], strict=True):
            if low is None and high is None:
                break
            share = drawn(turn, "share", str(len(found)))
            found += _inside(low, high, share, middle=number % 2 == 0)
        grid = _grid(kinks)
        for feature in own:
            if not feature.sharp:
                for sign in (1, -1):
                    target = sign * self._target(turn, feature, sign)
                    found += self._solved(feature, symbol, target, grid, {}, turn)[:_MOST_PLACES]
        return found

    def _kinks(self, symbol: sympy.Symbol, own: Sequence[Feature]) -> list[Any]:
        """Where the features that a symbol alone decides are 0, inner ones first."""
        kinks: list[Any] = []
        for feature in own:
            if feature.sharp:
                bent = any(part.has(*_BENT) for part in feature.parts)
                grid = _grid(kinks if bent else [])
                kinks = _joined(kinks, self._solved(feature, symbol, 0, grid, {}, 0))
        return kinks

    def _target(self, turn: int, feature: Feature, sign: int) -> Any:
        low, high = (numbers.log(size) for size in _TRANSITION)
        return numbers.exp(low + (high - low) * (drawn(turn, "target", str(sign)) - 0.5))

    def _solved(
        self,
        feature: Feature,
        symbol: sympy.Symbol,
        target: Any,
        grid: Sequence[Any],
        placed: dict[sympy.Basic, Value],
        turn: int,
    ) -> list[Any]:
        """Places of a symbol at which a feature has a value, the others having numbers."""

        def value(place: Any) -> Any:
            there = Drawn(self._points, turn, {**placed, symbol: exactly(place)}, decimals=False)
            try:
                number = _value(there, feature)[0]
            except CANNOT:
                return numbers.nan
            return numbers.nan if numbers.im(number) else numbers.re(number) - target

        if symbol.is_positive:
            grid = [place for place in grid if place > 0]
        with contextlib.suppress(*CANNOT):
            return crossings(value, grid)
        return []

    def _placed(self, feature: Feature, side: int, turn: int) -> dict[sympy.Symbol, Any]:
        """A point beside a kink or in a transition that several symbols decide."""
        symbols = self._symbols[feature]
        values = {s: self._anywhere(s, turn) for s in self._free}
        order = sorted(symbols, key=lambda s: drawn(turn, "solved", str(self._points.places[s])))
        with numbers.workprec(_SOLVED_BITS):
            target = 0 if feature.sharp else side * self._target(turn, feature, side)
            for symbol in order:
                fixed = {s: exactly(x) for s, x in values.items() if s != symbol}
                grid = _grid([self._points.generic(symbol, turn)])
                found = self._solved(feature, symbol, target, grid, fixed, turn)
                if found:
                    place = found[int(1000 * drawn(turn, "crossing")) % len(found)]
                    if feature.sharp:
                        step = numbers.mpf(10) ** (-7 * (drawn(turn, "step") - 0.5))
                        place += side * step * (abs(place) or 1)
                    return {**values, symbol: place}
        return {}


def _value(point: Drawn, feature: Feature) -> Value:
    """The value of a feature, and off by rounding."""
    if len(feature.parts) == 1:
        return point(feature.parts[0])
    (one, one_off), (other, other_off) = map(point, feature.parts)
    return one - other, one_off - other_off


def _grid(around: Sequence[Any]) -> list[Any]:
    """Places over the decades, of both signs, and closer ones around some."""
    places = {numbers.zero, *_GRID, *(-x for x in _GRID)}
    for place in around:
        places |= {place, *(place + s * step for step in _AROUND for s in (1, -1))}
    return sorted(places)


def _joined(places: Sequence[Any], more: Sequence[Any]) -> list[Any]:
    """Places in ascending order, each once."""
    found: list[Any] = []
    for place in sorted([*places, *more]):
        if not found or place - found[-1] > 1e-15 * max(abs(place), abs(found[-1])):
            found.append(place)
    return found


def _inside(low: Any, high: Any, share: Any, *, middle: bool) -> list[Any]:
    """Places between two neighbouring kinks, or beyond the last one.

    Parameters
    ----------
    low, high : number or None
        None beyond the last.
    share : number
        Between 1/2 and 3/2.
    middle : bool
        Whether one of them is in the middle.
    """
    if low is not None and high is not None:
        inner = numbers.mpf(1) / 2 if middle else 0.1 + 0.8 * (share - 0.5)
        edge = 1e-3 * share
        edge = edge if int(1000 * share) % 2 else 1 - edge
        return [low + inner * (high - low), low + edge * (high - low)]
    sign, end = (1, low) if high is None else (-1, high)
    size = abs(end) or numbers.one
    return [end + sign * 1e-3 * share * size, end + sign * share * (size + 1)]
