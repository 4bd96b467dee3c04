"""Kinks and jumps of the acceleration between samples, and its scale of variation.

The acceleration has a kink or jump where a *switching function* of the motion is zero: the argument
of an ``Abs``, or the difference of the arguments of a ``Max``. The *side* is the sign of this
function, +1 or -1. With given sides the acceleration is smooth everywhere. The sides, together with
the friction direction, are one *mode* of the motion. The time loop finds when a side changes. A
recorded signal that is linear between samples moves a kink between samples; a held signal moves it
at the samples.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import AxisModel, motion_point
from axisid.modeling.quantities import (
    Signal,
    at_start,
    float_at,
    multiplied_out,
    signals_in,
    with_numbers,
)

from .expressions import Arguments, Lowering
from .loop_interface import PHASE_PER_STEP, RESOLVED
from .program import Program

_RELATIONS = (
    sympy.StrictLessThan,
    sympy.LessThan,
    sympy.StrictGreaterThan,
    sympy.GreaterThan,
)
_PERIODIC = (sympy.sin, sympy.cos, sympy.tan)
_HIGHEST_DEGREE = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Switching:
    """The acceleration of an axis, with sides instead of its kinks and jumps.

    Attributes
    ----------
    acceleration : sympy.Expr
        Acceleration as a function of the motion and the sides.
    sides : tuple of sympy.Symbol
        Symbol of the side of each switching function; empty if the acceleration is smooth over the
        position.
    functions : tuple of sympy.Expr
        The switching functions, whose signs are the sides. A function may depend on earlier sides.
    wave_numbers, by_velocity : tuple of sympy.Expr
        Reciprocals of distances, and of changes of the velocity, over which the acceleration may
        vary; the largest value counts.
    moved_by : tuple of Signal
        Recorded signals in the switching functions.
    rates : tuple of sympy.Expr
        Rates of the internal states, as functions of the sides of their limits.
    limits : mapping of int to sympy.Symbol
        Side of each state that has a limit, by the index of the state: +1 within the limit, -1
        while the state slips. These sides are the last ones in `sides`.
    """

    acceleration: sympy.Expr
    sides: tuple[sympy.Symbol, ...]
    functions: tuple[sympy.Expr, ...]
    wave_numbers: tuple[sympy.Expr, ...]
    by_velocity: tuple[sympy.Expr, ...]
    moved_by: tuple[Signal, ...] = ()
    rates: tuple[sympy.Expr, ...] = ()
    limits: Mapping[int, sympy.Symbol] = field(default_factory=dict)


def switching(model: AxisModel) -> Switching:
    """Return the acceleration of an axis with sides instead of its kinks and jumps."""
    q, acceleration = model.axis.coordinate, with_numbers(model.acceleration)
    sides: dict[sympy.Expr, sympy.Symbol] = {}
    running = {signal.symbol for signal in model.axis.signals if not signal.is_held}
    moving = {q.symbol} | running
    deciding = acceleration.atoms(sympy.Abs, sympy.sign, sympy.Heaviside, Max, Min, *_RELATIONS)
    # A function with a kink that depends on the position or a signal that changes between samples,
    # or on the velocity together with a signal, has a kink between samples.
    if any(
        moving & node.free_symbols or (q.velocity in node.free_symbols and signals_in(node))
        for node in deciding
    ):
        acceleration = _Sides(moving, q.velocity, sides)(acceleration)
    on_one_side = acceleration.replace(sympy.Abs, lambda inside: inside)
    on_one_side = on_one_side.replace(sympy.sign, lambda _: 1)
    moved_by = signals_in(*sides)
    rates, limits = _with_limits(model, sides)
    return Switching(
        acceleration=acceleration,
        sides=tuple(sides.values()),
        functions=tuple(sides),
        wave_numbers=_wave_numbers((acceleration, *sides), q.symbol),
        by_velocity=_wave_numbers((on_one_side,), q.velocity),
        moved_by=tuple(signal for signal in model.axis.signals if signal.symbol in moved_by),
        rates=rates,
        limits=limits,
    )


def _with_limits(
    model: AxisModel, sides: dict[sympy.Expr, sympy.Symbol]
) -> tuple[tuple[sympy.Expr, ...], dict[int, sympy.Symbol]]:
    """Return the rates of the internal states, and the side of each limit by the state's index.

    The rate of a slipping state is 0. The side of each limit is added to `sides`, by its switching
    function. This function is exactly 0 at the limit, and the state slips while the motion is
    outwards.
    """
    rates, limits = list[sympy.Expr](), dict[int, sympy.Symbol]()
    for i, state in enumerate(model.states):
        rate = state.rate
        if state.limit is not None:
            limits[i] = sympy.Symbol(f"side{len(sides) + 1}", real=True)
            sides[(state.limit - state.symbol) * (state.limit + state.symbol)] = limits[i]
            rate = sympy.Piecewise((rate, limits[i] > 0), (0, True))
        rates.append(rate)
    return tuple(rates), limits


class _Sides:
    """Rewrites expressions with sides instead of kinks and jumps, and collects the sides.

    Kinks that depend only on the sign of the velocity are kept, because the friction direction
    describes them.

    Parameters
    ----------
    running : set of sympy.Symbol
        Symbols, except the velocity, that change between samples.
    velocity : sympy.Symbol
    sides : dict of sympy.Expr to sympy.Symbol
        Sides by their switching function; new ones are added.
    """

    def __init__(
        self,
        running: set[sympy.Symbol],
        velocity: sympy.Symbol,
        sides: dict[sympy.Expr, sympy.Symbol],
    ) -> None:
        self._motion, self._velocity, self._sides = {*running, velocity}, velocity, sides
        self._memo: dict[sympy.Basic, sympy.Basic] = {}

    def __call__(self, node: sympy.Basic) -> sympy.Basic:
        """Return an expression with sides instead of its kinks and jumps."""
        if not node.args or not node.free_symbols & self._motion:
            return node
        if node not in self._memo:
            self._memo[node] = self._rewritten(node, [self(argument) for argument in node.args])
        return self._memo[node]

    def _rewritten(self, node: sympy.Basic, arguments: list[sympy.Basic]) -> sympy.Basic:
        """Return a node with rewritten arguments, itself rewritten if it has a kink or a jump."""
        if isinstance(node, (Max, Min)):
            ordered = sorted(arguments, key=sympy.default_sort_key)
            return reduce(partial(self._chosen, kind=type(node)), ordered)
        side = None
        if isinstance(node, (sympy.Abs, sympy.sign, sympy.Heaviside)):
            side = self._side(arguments[0])
        elif isinstance(node, _RELATIONS):
            side = self._side(arguments[0] - arguments[1])
        if side is not None:
            return self._decided(node, arguments[0], side)
        if arguments == list(node.args):
            return node
        if node.is_Pow and not node.exp.is_Integer and node.base.is_nonnegative:
            # A step may go slightly beyond the kink, where the base would be negative.
            return Max(0, arguments[0]) ** arguments[1]
        return node.func(*arguments)

    def _decided(self, node: sympy.Basic, inside: sympy.Expr, side: sympy.Expr) -> sympy.Basic:
        """Return Abs, sign, Heaviside or a comparison with `side` as the sign of its argument.

        `inside` is the rewritten first argument of the node.
        """
        if isinstance(node, sympy.Abs):
            return side * inside
        if isinstance(node, sympy.Heaviside):
            return (1 + side) / 2
        return side if isinstance(node, sympy.sign) else node.func(side, 0)

    def _chosen(self, a: sympy.Expr, b: sympy.Expr, kind: type[sympy.Basic]) -> sympy.Expr:
        """Return the larger (`kind` Max) or smaller of two expressions, selected by their side."""
        side = self._side(a - b if kind is Max else b - a)
        return kind(a, b) if side is None else sympy.Piecewise((a, side > 0), (b, True))

    def _side(self, value: sympy.Expr) -> sympy.Expr | None:
        """Return the side of a switching function; None if it needs no side.

        A function needs no side if it does not depend on the motion, or is the velocity times a
        constant factor. A new symbol is made unless the function, or its negative, already has a
        side.
        """
        if not value.free_symbols & self._motion:
            return None
        slope = value.diff(self._velocity)
        rest = multiplied_out(value - slope * self._velocity)
        if rest == 0 and not slope.free_symbols & self._motion:
            return None
        if -value in self._sides:
            return -self._sides[-value]
        if value not in self._sides:
            self._sides[value] = sympy.Symbol(f"side{len(self._sides) + 1}", real=True)
        return self._sides[value]


def wave_number(model: AxisModel, found: Switching) -> Program:
    """Return the program of the largest wave number, from position, signals and parameters.

    The largest wave number is the reciprocal of the shortest distance over which the acceleration
    varies.
    """
    axis = model.axis
    arguments = Arguments().scalars(axis.coordinate.symbol, *axis.signal_symbols)
    arguments.vector_of("parameters", [p.symbol for p in axis.parameters])
    arguments.output("wave_number", [[largest_wave(arguments, found.wave_numbers)]])
    return arguments.program(
        "wave_number", "Reciprocal of the shortest way on which the acceleration varies."
    )


def largest_wave(arguments: Arguments, numbers: Iterable[sympy.Expr]) -> int:
    """Return the operation of the largest of the wave numbers."""
    lowering = Lowering(arguments, arguments.values)
    return reduce(partial(arguments.apply, "max"), map(lowering, numbers))


def _wave_numbers(values: Iterable[sympy.Expr], position: sympy.Symbol) -> tuple[sympy.Expr, ...]:
    """Return the wave numbers of the parts of expressions that are not polynomials of `position`.

    `position` is the symbol of the position, or of the velocity.
    """
    nodes = (node for value in values for node in dict.fromkeys(sympy.preorder_traversal(value)))
    depending = (node for node in nodes if position in node.free_symbols)
    found = dict.fromkeys(number for node in depending for number in _of_node(node, position))
    return tuple(number for number in found if number != 0)


def _of_node(node: sympy.Basic, position: sympy.Symbol) -> Iterator[sympy.Expr]:
    """Yield the wave numbers of a function, a root or a quotient; none for any other node."""
    if isinstance(node, _PERIODIC):
        yield sympy.Abs(node.args[0].diff(position))
    elif isinstance(node, sympy.Function) and not isinstance(node, (Max, Min, sympy.Piecewise)):
        yield from (_width(inside, position) for inside in node.args)
    elif node.is_Pow and position in node.exp.free_symbols:
        yield _width(node.exp * sympy.log(node.base), position)
    elif node.is_Pow and not (node.exp.is_Integer and node.exp > 0):
        base = node.base
        if base.is_polynomial(position):  # nodes inside it have wave numbers of their own
            first, second = base.diff(position), base.diff(position, 2)
            yield sympy.Abs(first / base)
            yield sympy.sqrt(sympy.Abs(second / base))


def _width(inside: sympy.Expr, position: sympy.Symbol) -> sympy.Expr:
    """Return the reciprocal of the width over which a function of the argument `inside` varies.

    For a polynomial argument the highest derivative gives the width, for instance that of
    ``exp(-((q - q0)/w)**2)``, also at positions where lower derivatives are 0.
    """
    slope = inside
    for degree in range(1, _HIGHEST_DEGREE + 1):
        slope = slope.diff(position)
        if position not in slope.free_symbols:
            return sympy.Abs(slope / sympy.factorial(degree)) ** sympy.Rational(1, degree)
    return sympy.Abs(inside.diff(position)) + sympy.sqrt(sympy.Abs(inside.diff(position, 2)))


def stiffest_term(
    axis: Axis, parameters: Sequence[float], motion: tuple[float, float], recorded: Sequence[float]
) -> tuple[str, float]:
    """Return the term of the equation of motion with the shortest steps, and its steps per second.

    Parameters
    ----------
    axis : Axis
    parameters : sequence of float
        Length p, finite.
    motion : tuple of float
        Position and velocity.
    recorded : sequence of float
        Values of the recorded signals, in the axis's order.
    """
    q = axis.coordinate
    point = motion_point(axis, parameters, motion, recorded)
    force = with_numbers(at_start(axis.force))
    inertia = _size(force.diff(q.acceleration), point)

    def steps(term: sympy.Expr) -> float:
        by_speed, by_way = (_size(term.diff(by), point) for by in (q.velocity, q.symbol))
        waves = max([_size(each, point) for each in _wave_numbers((term,), q.symbol)], default=0.0)
        rate = max(by_speed / inertia, math.sqrt(by_way / inertia)) if inertia else 0.0
        return max(rate / RESOLVED, waves * abs(motion[1]) / PHASE_PER_STEP)

    terms = sympy.Add.make_args(axis.force)
    found = [(str(term), steps(with_numbers(at_start(term)))) for term in terms]
    return max(found, key=lambda pair: pair[1])


def _size(value: sympy.Expr, point: dict[sympy.Symbol, float]) -> float:
    """Return the absolute value of an expression at a point; 0 if it is not a number.

    Delta functions, the derivatives of jumps, are replaced by 0.
    """
    smooth = value.replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)
    size = abs(float_at(smooth, point))
    return 0.0 if math.isnan(size) else size
