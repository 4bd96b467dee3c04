"""Points at which two expressions seem to differ, searched for in floating point.

Along one symbol a function is looked at in many random places over the decades. Where what decides
changes its sign, or comes near 0, is found by halving and by thirds. What seems to differ between
two such places is no proof: it is looked at again in many digits.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from .covering_points import CoveringPoints
from .features import Feature
from .point_value import DrawnPoint, exactly, numbers
from .symbols import DIRECTION

_Numbers: TypeAlias = NDArray[np.float64]

_SEED = 20_000
_LOWEST, _HIGHEST = -7.0, 6.5  # decades of the places
_PLACES = 600  # of a line, of each sign
_LINES = 4  # along each symbol, in each of two rounds
_MOST_EDGES = 400  # that are found along one symbol in one round
_HALVINGS, _THIRDS = 45, 30
_SHOWS = (-0.5, 0.5)  # arguments at which smooth functions show
_DIFFERENT = 1e-8  # share of the terms beyond which expressions seem to differ
_MOST_SUSPECTS = 60


def suspects(
    covering: CoveringPoints,
    declared: sympy.Expr,
    reduced: sympy.Expr,
    given: Mapping[sympy.Symbol, sympy.Expr],
) -> Iterator[DrawnPoint]:
    """Points at which a sum and another expression seem to differ, the clearest first.

    Parameters
    ----------
    covering : CoveringPoints
        Of both.
    declared, reduced : sympy.Expr
    given : mapping of sympy.Symbol to sympy.Expr
        Symbols of the other expression, by those of the sum.
    """
    try:
        scan = _Scan.of(covering, declared, reduced, given)
        places = scan.places()
        shares = scan.differences(places)
    except (ArithmeticError, AttributeError, NameError, NotImplementedError, TypeError):
        return  # a function has no value in floating point
    clearest = np.argsort(-shares)[:_MOST_SUSPECTS]
    for turn, i in enumerate(clearest):
        if shares[i] > _DIFFERENT:
            placed = {s: exactly(numbers.mpf(float(column[i]))) for s, column in places.items()}
            yield covering.placed(_SEED + turn, {**scan.parameters, **placed})


@dataclass(frozen=True)
class _Scan:
    """Expressions in floating point, and where the features are near 0."""

    covering: CoveringPoints
    symbols: tuple[sympy.Symbol, ...]
    parameters: Mapping[sympy.Symbol, Any]
    terms: Any
    values: Mapping[tuple[sympy.Expr, ...], Any]
    features: tuple[Feature, ...]
    rng: np.random.Generator

    @classmethod
    def of(
        cls,
        covering: CoveringPoints,
        declared: sympy.Expr,
        reduced: sympy.Expr,
        given: Mapping[sympy.Symbol, sympy.Expr],
    ) -> "_Scan":
        """Expressions, with numbers in place of the parameters."""
        point = covering.placed(_SEED, {})
        parameters = {s: point(s) for s in covering.moderate}
        fixed = {s: sympy.Float(str(x)) for s, (x, _) in parameters.items()}
        made = {s: sympy.Float(str(point(value)[0])) for s, value in given.items()}
        symbols = tuple(s for s in covering.symbols if s not in fixed and s not in made)
        arguments = (*symbols, DIRECTION)
        one = [term.xreplace(fixed) for term in sympy.Add.make_args(declared)]
        both = [*one, reduced.xreplace({**fixed, **made})]
        values: dict[tuple[sympy.Expr, ...], Any] = {}
        for feature in covering.features:
            if feature.node != DIRECTION and feature.parts not in values:
                value = feature.parts[0]
                value = value - feature.parts[1] if len(feature.parts) > 1 else value
                values[feature.parts] = sympy.lambdify(arguments, value.xreplace(fixed), "numpy")
        features = tuple(f for f in covering.features if f.parts in values)
        terms = sympy.lambdify(arguments, both, "numpy", cse=True)
        rng = np.random.default_rng(_SEED)
        return cls(covering, symbols, parameters, terms, values, features, rng)

    def places(self) -> dict[sympy.Symbol, _Numbers]:
        """Points beside the edges of features, and between them."""
        known: dict[sympy.Symbol, _Numbers] = {}
        found: list[dict[sympy.Symbol, _Numbers]] = []
        for _ in range(2):
            for symbol in self.symbols:
                more = self._along(symbol, known)
                found.append(more)
                known[symbol] = np.concatenate([known.get(symbol, more[symbol]), more[symbol]])
        if not found:
            return {}
        return {s: np.concatenate([each[s] for each in found]) for s in self.symbols}

    def differences(self, places: Mapping[sympy.Symbol, _Numbers]) -> _Numbers:
        """The share of the terms by which the expressions differ, 0 where there is no value."""
        if not places:
            return np.zeros(0)
        with np.errstate(all="ignore"):
            *terms, other = self._evaluated(self.terms, places)
            size = np.sum(np.abs(terms), axis=0)
            share = np.abs(np.sum(terms, axis=0) - other) / size
        return np.where(np.isfinite(share), share, 0.0)

    def _evaluated(self, function: Any, places: Mapping[sympy.Symbol, _Numbers]) -> Any:
        """Real values of one or several expressions at points; not a number where not real."""
        columns = [places[s] for s in self.symbols]
        velocity = self.covering.velocity
        direction = np.sign(places[velocity]) if velocity in places else np.zeros(1)
        with np.errstate(all="ignore"):
            values = function(*columns, direction)
        listed = values if isinstance(values, list) else [values]
        size = columns[0].shape
        real = [np.broadcast_to(np.asarray(value), size) for value in listed]
        real = [np.where(np.iscomplex(x), np.nan, np.real(x)).astype(float) for x in real]
        return real if isinstance(values, list) else real[0]

    def _sizes(self, count: int, *, positive: bool) -> _Numbers:
        """Numbers over the decades."""
        sizes = 10 ** self.rng.uniform(_LOWEST, _HIGHEST, count)
        return sizes if positive else sizes * self.rng.choice([-1.0, 1.0], count)

    def _others(
        self, symbol: sympy.Symbol, known: Mapping[sympy.Symbol, _Numbers]
    ) -> dict[sympy.Symbol, _Numbers]:
        """Numbers of the other symbols on each line, some of them at their own edges."""
        fixed = {}
        for other in self.symbols:
            if other != symbol:
                column = self._sizes(_LINES, positive=bool(other.is_positive))
                if other in known and len(known[other]):
                    chosen = self.rng.choice(known[other], _LINES)
                    column = np.where(self.rng.random(_LINES) < 0.7, chosen, column)
                fixed[other] = column
        return fixed

    def _along(
        self, symbol: sympy.Symbol, known: Mapping[sympy.Symbol, _Numbers]
    ) -> dict[sympy.Symbol, _Numbers]:
        """Points on lines along a symbol: between the edges of the features, and beside them."""
        fixed = self._others(symbol, known)
        positive = bool(symbol.is_positive)
        grid = np.sort(self._sizes(_PLACES * (1 if positive else 2), positive=positive))
        lines = {s: np.repeat(column, len(grid)) for s, column in fixed.items()}
        lines[symbol] = np.tile(grid, _LINES)
        edges = [(np.arange(_LINES), np.zeros(_LINES))]
        for feature in self.features:
            if symbol in feature.symbols:
                value = self._evaluated(self.values[feature.parts], lines).reshape(_LINES, -1)
                edges += [
                    self._edges(feature, target, value - target, grid, symbol, fixed)
                    for target in ((0.0,) if feature.sharp else _SHOWS)
                ]
        line = np.concatenate([each for each, _ in edges])
        place = np.concatenate([each for _, each in edges])
        order = np.lexsort((place, line))
        line, place = line[order], place[order]
        same = np.flatnonzero(line[1:] == line[:-1])
        low, high = place[same], place[same + 1]
        share = self.rng.uniform(0.05, 0.95, len(same))
        near = 10 ** self.rng.uniform(-6, -1, len(same))
        inside = [low + share * (high - low), low + near * (high - low), high - near * (high - low)]
        step = 10 ** self.rng.uniform(-4, 0.5, len(place))
        beyond = place + step * np.where(place == 0, 1.0, place)
        placed = np.concatenate([*inside, beyond])
        on = np.concatenate([line[same]] * 3 + [line])
        points = {s: column[on] for s, column in fixed.items()}
        points[symbol] = placed
        return points

    def _edges(
        self,
        feature: Feature,
        target: float,
        value: _Numbers,
        grid: _Numbers,
        symbol: sympy.Symbol,
        fixed: Mapping[sympy.Symbol, _Numbers],
    ) -> tuple[NDArray[np.intp], _Numbers]:
        """Where a feature changes its sign or comes near 0, by line."""

        def at(line: NDArray[np.intp], place: _Numbers) -> _Numbers:
            points = {s: column[line] for s, column in fixed.items()}
            points[symbol] = place
            found: _Numbers = self._evaluated(self.values[feature.parts], points) - target
            return found

        line, i = self._some(value[:, :-1] * value[:, 1:] < 0)
        low, high, side = grid[i], grid[i + 1], np.sign(value[line, i])
        size = np.abs(value)
        dips = (size[:, 1:-1] < size[:, :-2]) & (size[:, 1:-1] < size[:, 2:])
        dips &= (value[:, 1:-1] * value[:, :-2] > 0) & (value[:, 1:-1] * value[:, 2:] > 0)
        dip, k = self._some(dips)
        left, right, sign = grid[k], grid[k + 2], np.sign(value[dip, k])
        start, end = left, right
        for _ in range(_THIRDS if len(dip) else 0):
            one, other = left + (right - left) / 3, right - (right - left) / 3
            lower = sign * at(dip, one) < sign * at(dip, other)
            left, right = np.where(lower, left, one), np.where(lower, other, right)
        lowest = (left + right) / 2
        crossed = (sign * at(dip, lowest) < 0) if len(dip) else np.zeros(0, bool)
        line = np.concatenate([line, dip[crossed], dip[crossed]])
        low = np.concatenate([low, start[crossed], lowest[crossed]])
        high = np.concatenate([high, lowest[crossed], end[crossed]])
        side = np.concatenate([side, sign[crossed], -sign[crossed]])
        for _ in range(_HALVINGS if len(line) else 0):
            middle = (low + high) / 2
            before = at(line, middle) * side > 0
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return np.concatenate([line, dip]), np.concatenate([(low + high) / 2, lowest])

    def _some(self, wanted: NDArray[np.bool_]) -> Sequence[NDArray[np.intp]]:
        """Places in a table, a part of them if they are many."""
        line, i = np.nonzero(wanted)
        if len(line) > _MOST_EDGES:
            chosen = np.sort(self.rng.choice(len(line), _MOST_EDGES, replace=False))
            return line[chosen], i[chosen]
        return line, i
