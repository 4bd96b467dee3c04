"""Whether the programs of an axis give the declared force, in sixty digits at a few points.

All targets are printed from the same programs, so that no comparison of targets shows what went
wrong before: terms that were multiplied out, and lose their digits where they cancel. So the points
lie near the zeros of the sums that were declared, beside some that lie anywhere. A program may be
off by what rounding explains: that of the expression as it was declared, and that of adding up the
columns.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from axisid.modeling import DIRECTION, FORCE, Axis, AxisModel, ModelError, Parameter, with_numbers

from .arguments import Array
from .evaluate import evaluate
from .oracle import Oracle, UndecidedError, Value
from .program import Program

Motion = tuple[float, float]  # position and velocity, SI

_ANYWHERE = ((0.3, 0.7), (-0.8, -0.2), (0.011, -0.013))
_ACCELERATION = -1.1
_BESIDE = (0.5, -1e-3)  # values of a sum near its zero
_MOST_SUMS = 3  # whose zeros are tried; powers of sums lose most digits, so they come first
# What is allowed: times the rounding of the declared expression, and of what the columns add up.
_TIMES, _SHARE = 1e3, 1e-12


def check_programs(model: AxisModel, programs: Sequence[Program]) -> None:
    """Compare the programs of both dynamics with the equation of motion as it was declared.

    Points where the declared force has no value in double precision, or jumps, are left out.

    Raises
    ------
    ModelError
        A program gives something else.
    """
    declared = model.base.declared
    values = {p.symbol: _value(p) for p in declared.parameters}
    force = with_numbers(declared.force / declared.drive.profile)
    points = _points(force, declared, values, _motions(force, declared, values))
    if points is None:
        return
    own = model.base.at(list(values.values()))
    check = _Check(
        axis=declared.name,
        points=points,
        programs={program.name: program for program in programs},
        elements={
            **points.elements(declared),
            **{
                p.name: np.full(len(points.force), value)
                for p, value in zip(model.axis.parameters, own, strict=True)
            },
        },
    )
    check.inverse(np.array(own))
    check.direct()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Points:
    """Motions, and the declared force there, over the drive's profile.

    Attributes
    ----------
    motion : array, (N, 2)
        Position and velocity.
    force, rest : array, (N,)
        With the acceleration that is tried, and without any.
    error : array, (N,)
        How far the two together may be off in double precision.
    """

    motion: Array
    force: Array
    rest: Array
    error: Array

    def elements(self, axis: Axis) -> dict[str, Array]:
        """The motion by the names of the programs' arguments."""
        q, (position, velocity) = axis.coordinate, self.motion.T
        return {
            q.name: position,
            str(q.velocity): velocity,
            str(q.acceleration): np.full(len(position), _ACCELERATION),
            str(DIRECTION): np.sign(velocity),
            str(FORCE): self.force,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class _Check:
    """Programs of an axis, and the arguments and results that they should have."""

    axis: str
    points: _Points
    programs: Mapping[str, Program]
    elements: Mapping[str, Array]

    def inverse(self, parameters: Array) -> None:
        """Inverse dynamics, and its regressor with its parameters."""
        row, known = self._run("idm_regressor")
        parts = np.column_stack([row * parameters, known])
        allowed = self.points.error + _SHARE * np.sum(np.abs(parts), axis=1)
        for name, got in (
            ("inverse_dynamics", self._run("inverse_dynamics")[0][:, 0]),
            ("idm_regressor", np.sum(parts, axis=1)),
        ):
            self._compare(name, got, self.points.force, allowed)

    def direct(self) -> None:
        """Direct dynamics and its regressor, as the forces that their accelerations need."""
        points = self.points
        inertia = (points.force - points.rest) / _ACCELERATION
        sizes = np.abs(points.force) + np.abs(points.rest)
        results = {"direct_dynamics": self._run("direct_dynamics")[0]}
        if "ddm_regressor" in self.programs:
            row, known = self._run("ddm_regressor")
            parameters = self._run("ddm_from_physical")[0]
            results["ddm_regressor"] = np.column_stack([row * parameters, known])
        for name, parts in results.items():
            spent = inertia[:, None] * parts
            allowed = points.error + _SHARE * (sizes + np.sum(np.abs(spent), axis=1))
            some = np.abs(inertia * _ACCELERATION) > points.error  # else there is no inertia
            got = points.rest + np.sum(spent, axis=1)
            self._compare(name, np.where(some, got, points.force), points.force, allowed)

    def _run(self, name: str) -> list[Array]:
        return list(evaluate(self.programs[name], self.elements).values())

    def _compare(self, name: str, got: Array, wanted: Array, allowed: Array) -> None:
        wrong = ~(np.abs(got - wanted) <= allowed)
        if not np.any(wrong):
            return
        i = int(np.argmax(wrong))
        position, velocity = self.points.motion[i]
        raise ModelError(
            f"axis {self.axis!r}: at position {position:g} and velocity {velocity:g} the generated "
            f"{name} gives a force of {got[i]:.9g} where the equation of motion gives "
            f"{wanted[i]:.9g}, which is a fault of the program; report it with the axis, and write "
            "the equation of motion in another form."
        )


def _value(parameter: Parameter) -> float:
    """The nominal value, or one of moderate size within the bounds."""
    return parameter.nominal or min(max(1.0, parameter.lower), parameter.upper)


def _oracle(axis: Axis, values: Mapping[sympy.Symbol, float], *motion: float) -> Oracle:
    q = axis.coordinate
    symbols = (q.symbol, q.velocity, q.acceleration)
    return Oracle({**values, **dict(zip(symbols, motion, strict=True))})


def _points(
    force: sympy.Expr,
    axis: Axis,
    values: Mapping[sympy.Symbol, float],
    motions: Sequence[Motion],
) -> _Points | None:
    """The force where it has a value; None if it has one nowhere."""
    found: list[tuple[Motion, Value, Value]] = []
    for motion in motions:
        try:
            moving, still = (_oracle(axis, values, *motion, a)(force) for a in (_ACCELERATION, 0.0))
        except UndecidedError:
            continue
        found.append((motion, moving, still))
    if not found:
        return None
    return _Points(
        motion=np.array([motion for motion, _, _ in found]),
        force=np.array([float(moving.exact) for _, moving, _ in found]),
        rest=np.array([float(still.exact) for _, _, still in found]),
        error=_TIMES * np.array([float(a.error + b.error) for _, a, b in found]),
    )


def _motions(force: sympy.Expr, axis: Axis, values: Mapping[sympy.Symbol, float]) -> list[Motion]:
    """Motions anywhere, and beside the zeros of sums of the position or the velocity."""
    sums = _sums(force, axis)
    start = np.array(_ANYWHERE[0])
    here = _oracle(axis, values, *start, _ACCELERATION)
    found = list(_ANYWHERE)
    for direction in np.eye(2):
        there = _oracle(axis, values, *(start + direction), _ACCELERATION)
        for node in sums:
            for step in _steps(node, here, there):
                position, velocity = start + step * direction
                found.append((float(position), float(velocity)))
    return found


def _sums(force: sympy.Expr, axis: Axis) -> list[sympy.Expr]:
    """Some of the sums in a force that the motion makes large or small."""
    moving = {axis.coordinate.symbol, axis.coordinate.velocity}
    nodes = list(sympy.preorder_traversal(force))[1:]
    raised = [node.base for node in nodes if node.is_Pow]
    sums = dict.fromkeys(node for node in [*raised, *nodes] if node.is_Add)
    return [node for node in sums if node.free_symbols & moving][:_MOST_SUMS]


def _steps(node: sympy.Expr, here: Oracle, there: Oracle) -> Iterator[float]:
    """How far a sum is from where it is almost 0, if it is affine; `there` it is one step on."""
    try:
        start, slope = here(node).exact, there(node).exact - here(node).exact
    except UndecidedError:
        return
    if slope:
        yield from (float((value - start) / slope) for value in _BESIDE)
