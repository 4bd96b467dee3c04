"""Friction with internal states, as programs: a step of motion and states, and their rates.

Bristles are stiff: with the inertia M and the stiffness s0 they oscillate at ``sqrt(s0/M)``, and
while the axis slides they relax within some micrometres. A step is a step of Rodas4
[HairerWanner1996]_, which is of fourth order and L-stable: fast components that have decayed do not
require short steps. Friction direction and side of each limit are constant within a step, so that
motion and states are smooth.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy

from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import DIRECTION, FORCE, slope

from .expressions import Arguments
from .program import Builder, Program
from .switching import Switching

#: Name of the vector of the internal states.
STATES = "states"

_TINY = 1e-150  # 1/s; added to the damping, so that it is never 0
# Coefficients of Rodas4: weights of earlier stages in the argument of a stage, and in its
# right-hand side over the step.
_GAMMA = 0.25
_STAGES = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0),
)
_ADDED = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616),
    (
        8.083246795921522,
        -7.981132988064893,
        -31.52159432874371,
        16.31930543123136,
        -6.058818238834054,
    ),
)

Vector = tuple[int, ...]


def state_start(model: AxisModel, found: Switching) -> Program:
    """Return the program of the states' start values and the index of the first side of a limit."""
    arguments = Arguments().vector_of("parameters", [p.symbol for p in model.axis.parameters])
    builder = arguments.lower(states=[[state.start] for state in model.states])
    builder.output("first_limit", [[builder.constant(len(found.sides) - len(found.limits))]])
    return builder.program("state_start", "Internal states at the first sample.")


def state_dynamics(model: AxisModel, found: Switching) -> Program:
    """Return the program of acceleration and state rates in one mode, and of their derivatives.

    The derivatives (``slopes``) are by position, velocity and states, one row for the acceleration
    and one for each state. ``curvature`` is the derivative of the states' relaxation by the
    velocity.
    """
    q = model.axis.coordinate
    arguments = Arguments(reciprocals=True).scalars(q.symbol, q.velocity, FORCE, DIRECTION)
    with_mode(arguments, model, found)
    rates = (found.acceleration, *found.rates)
    symbols = tuple(state.symbol for state in model.states)
    moved = (q.symbol, q.velocity, *symbols)
    relaxing = [
        sympy.Abs(slope(slope(rate, z, "a state"), q.velocity, "a state"))
        for rate, z in zip(found.rates, symbols, strict=True)
    ]
    return arguments.lower(
        rates=[[rate] for rate in rates],
        slopes=[[slope(rate, by, "the motion") for by in moved] for rate in rates],
        curvature=[[sympy.Add(*relaxing)]],
    ).program("state_dynamics", "Acceleration and rates of the states, and slopes.")


def with_mode(arguments: Arguments, model: AxisModel, found: Switching) -> Arguments:
    """Declare the further arguments of a motion in one mode, and return the arguments.

    These are the vector of sides (of kinks, jumps and limits) and the vector of internal states,
    each omitted if empty, and the vector of parameters.
    """
    return (
        arguments.vector_if_any("sides", found.sides)
        .vector_if_any(STATES, [state.symbol for state in model.states])
        .vector_of("parameters", [p.symbol for p in model.axis.parameters])
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Remembering:
    """Integrator of motion and internal states together, in one mode.

    Attributes
    ----------
    builder : Builder
        Builder of the program. Each int below is the index of one of its operations.
    dynamics : Program
        Program of `state_dynamics`.
    force : int
        The force, which is constant during the step.
    mode : tuple of tuple of int
        The friction direction, and the sides if there are any.
    parameters : tuple of int
    limited : tuple of ((int, int) or None)
        For each state, the side of its limit and the limit; None for a state without a limit.
    """

    builder: Builder
    dynamics: Program
    force: int
    mode: tuple[Vector, ...]
    parameters: Vector
    limited: tuple[tuple[int, int] | None, ...]

    def _at(self, motion: Sequence[int]) -> dict[str, Vector]:
        """Return the outputs of `state_dynamics` at a motion (position, velocity, states)."""
        q, dq, *states = motion
        state = (*self.mode, tuple(states), self.parameters)
        return self.builder.inline(self.dynamics, (q,), (dq,), (self.force,), *state)

    def rate(self, motion: Sequence[int]) -> int:
        """Return the operation of the largest relevant rate of motion and states, 1/s.

        It is ``max(min(sqrt(S), S/T), sqrt(R))``, with

        - ``S = |a_q + sum_i (a_i g_i,v - a_v g_i,i)|``,
        - ``T = |a_v| + sum_i |g_i,i|``, to which a tiny number is added in the quotient,
        - ``R = |a| sum_i |g_i,iv|``.

        Here a is the acceleration, g_i the rate of state z_i, and the sums are over all states. An
        index after these names is a derivative: q by the position, v by the velocity, i by z_i.

        With a single state, the rates r of the motion solve ``r**2 + T r + S = 0``, except for the
        signs. If T is small, velocity and state oscillate with ``sqrt(S)``. Otherwise one rate is
        about T, whose component decays within a step and is not counted, and the other is ``S/T``.
        R is the relaxation term: a state relaxes with the rate ``|g_i,i|``, which is zero at a
        velocity reversal, and changes with the velocity by ``|g_i,iv|``, and so in time by R.

        Parameters
        ----------
        motion : sequence of int
            Operations of position, velocity and states.
        """
        build, found, width = self.builder.apply, self._at(motion), len(motion)
        # `slopes` has one row for the acceleration, then one for each state; the entries of a row
        # are the derivatives by position, velocity and states.
        slopes = found["slopes"]
        by_velocity = slopes[1]
        # S and T.
        stiffness, damping = slopes[0], build("abs", by_velocity)
        for j in range(2, width):
            row = slopes[(j - 1) * width : j * width]
            stiffness = build("add", stiffness, build("mul", slopes[j], row[1]))
            stiffness = build("sub", stiffness, build("mul", by_velocity, row[j]))
            damping = build("add", damping, build("abs", row[j]))
        stiffness = build("abs", stiffness)
        slow = build("div", stiffness, build("add", damping, self.builder.constant(_TINY)))
        swinging = build("min", build("sqrt", stiffness), slow)
        # R; the first of the rates is the acceleration.
        relaxing = build("mul", build("abs", found["rates"][0]), found["curvature"][0])
        return build("max", swinging, build("sqrt", relaxing))

    def step(self, motion: Vector, step: int) -> Vector:
        """Return position, velocity and states after `step` seconds, by one step of Rodas4.

        Each stage solves a linear system with the same matrix, from the derivatives at the start.
        """
        # `made` has the solutions of the stages so far; `at` is the motion at which a stage is
        # evaluated.
        build, number = self.builder.apply, self.builder.constant
        here = self._at(motion)
        solve = self._solver(here["slopes"], step, len(motion))
        over = build("div", number(1), step)
        made: list[Vector] = []
        at = motion
        for weights, added in zip(_STAGES, _ADDED, strict=True):
            at = self._plus(motion, weights, made)
            found = here if not made else self._at(at)
            right = (at[1], *found["rates"])
            scaled = [tuple(build("mul", over, value) for value in each) for each in made]
            made.append(solve(self._plus(right, added, scaled)))
        end = self._plus(at, (1.0,), made[-1:])
        states = [self._kept(z, i) for i, z in enumerate(end[2:])]
        return (*end[:2], *states)

    def _kept(self, state: int, index: int) -> int:
        """Return the operation of state number `index` after a step: its limit if it slips."""
        limited = self.limited[index]
        if limited is None:
            return state
        build, (side, limit) = self.builder.apply, limited
        slips = build("lt", side, self.builder.constant(0))
        return build("select", slips, build("mul", self.mode[0][0], limit), state)

    def _plus(self, start: Vector, weights: Sequence[float], made: Sequence[Vector]) -> Vector:
        """Return a vector plus the weighted sum of the vectors in `made`."""
        build, number = self.builder.apply, self.builder.constant
        for weight, each in zip(weights, made, strict=True):
            start = tuple(
                build("add", value, more if weight == 1 else build("mul", number(weight), more))
                for value, more in zip(start, each, strict=True)
            )
        return start

    def _solver(self, slopes: Vector, step: int, width: int) -> Callable[[Vector], Vector]:
        """Return a function that solves ``(1/(gamma h) - J) u = right`` for the stages of a step.

        The position is replaced by the velocity, whose integral it is. The remaining system is
        solved by Gaussian elimination without pivoting, the states first: their pivots are positive
        because they relax.

        Parameters
        ----------
        slopes : tuple of int
            The matrix J, row by row, without the row of the position.
        step : int
            h.
        width : int
            Number of unknowns: position, velocity and states.
        """
        build, number = self.builder.apply, self.builder.constant
        short = build("mul", number(_GAMMA), step)
        scale, none = build("div", number(1), short), number(0)
        # Order of the unknowns: the states, then the velocity.
        order = (*range(2, width), 1)
        rows = [[slopes[(r - 1) * width + c] for c in order] for r in order]
        by_position = [slopes[(r - 1) * width] for r in order]
        # The coefficient of the position in each row is added to that of the velocity.
        matrix = [[none if x == none else build("neg", x) for x in row] for row in rows]
        for i, row in enumerate(matrix):
            row[i] = build("sub", scale, rows[i][i])
            if by_position[i] != none:
                row[-1] = build("sub", row[-1], build("mul", short, by_position[i]))
        factors = self._eliminate(matrix, none)

        def solve(right: Vector) -> Vector:
            """Return the solution for a right-hand side: position, velocity and states."""
            # Forward elimination of the right-hand side, then back substitution.
            values = [right[r] for r in order]
            for i, slope_of in enumerate(by_position):
                if slope_of != none:
                    moved = build("mul", build("mul", short, slope_of), right[0])
                    values[i] = build("add", values[i], moved)
            for (i, k), factor in factors.items():
                values[i] = build("sub", values[i], build("mul", factor, values[k]))
            found = list(values)
            for i in reversed(range(len(values))):
                for j in range(i + 1, len(values)):
                    if matrix[i][j] != none:
                        found[i] = build("sub", found[i], build("mul", matrix[i][j], found[j]))
                found[i] = build("div", found[i], matrix[i][i])
            *states, velocity = found
            return (build("mul", short, build("add", right[0], velocity)), velocity, *states)

        return solve

    def _eliminate(self, matrix: list[list[int]], none: int) -> dict[tuple[int, int], int]:
        """Make a matrix upper triangular, in place; return the multipliers by (row, pivot row).

        `none` is the operation of the constant 0; entries equal to it are skipped.
        """
        build, factors = self.builder.apply, {}
        for k in range(len(matrix)):
            for i in range(k + 1, len(matrix)):
                if matrix[i][k] == none:
                    continue
                factors[i, k] = factor = build("div", matrix[i][k], matrix[k][k])
                for j in range(k + 1, len(matrix)):
                    if matrix[k][j] != none:
                        less = build("mul", factor, matrix[k][j])
                        matrix[i][j] = build("sub", matrix[i][j], less)
        return factors
