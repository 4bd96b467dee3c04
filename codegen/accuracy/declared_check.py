"""Whether the programs of an axis give the declared force, in sixty digits at a few points.

All targets are printed from the same programs, so that no comparison of targets shows what went
wrong before: terms that were multiplied out, and lose their digits where they cancel. So most of
the points lie near the zeros of the sums that were declared, where only the term with that sum and
the inertia are there, lest another term hides it. A program may be off by what rounding explains:
that of the expression as it was declared, and that of adding up the columns.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from axisid.codegen.lowering import Program
from axisid.codegen.thresholds.generation import MAX_DECLARED_ROUNDING, MAX_SUMMED_DIFFERENCE
from axisid.modeling.algebra import joined_exponential
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import DIRECTION, FORCE, Parameter, at_start, with_numbers
from axisid.support.arrays import Array
from axisid.support.errors import ModelError

from .evaluate import evaluate
from .oracle import Oracle, UndecidedError

Point = dict[sympy.Symbol, float]  # motion, declared parameters and recorded signals, SI

# Position, velocity and acceleration, SI; slow and fast, and of no simple ratio to any period.
_ANYWHERE = ((0.317, 0.73, -1.1), (-0.8137, -0.21, 0.6), (0.0113, -0.013, 2.0), (2.71, -31.0, 90.0))
_RECORDED = (0.731, 0.113)  # of the first signal, and by how much more the others are
_BESIDE = (0.5, -1e-3)  # values of a sum near its zero
# Whose zeros are tried. What an exponential holds may be lost altogether, and powers of sums lose
# most digits, so they come first.
_MOST_SUMS = 3


def check_programs(model: AxisModel, programs: Sequence[Program]) -> None:
    """Compare the programs of both dynamics with the equation of motion as it was declared.

    Points where the declared force has no value in double precision, or jumps, are left out.

    Raises
    ------
    ModelError
        A program gives something else.
    """
    points = list(_points(model))
    declared = _declared(model, points)
    if declared is None:
        return
    check = _Check(
        axis=model.base.declared.name,
        declared=declared,
        programs={program.name: program for program in programs},
    )
    check.inverse()
    check.direct()


@dataclass(frozen=True, slots=True, kw_only=True)
class _DeclaredForce:
    """The declared force at N points, over the drive's profile.

    Attributes
    ----------
    elements : mapping of str to (N,) array
        Motion and own parameters by the names of the programs' arguments.
    parameters : array, (N, p)
        The own parameters, those of the axis as it was derived.
    force, inertia : array, (N,)
    acceleration : array, (N,)
    error : array, (N,)
        How far the force may be off in double precision, many times.
    """

    elements: Mapping[str, Array]
    parameters: Array
    force: Array
    inertia: Array
    acceleration: Array
    error: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class _Check:
    """Programs of an axis, and what they should give."""

    axis: str
    declared: _DeclaredForce
    programs: Mapping[str, Program]

    def inverse(self) -> None:
        """Inverse dynamics, and its regressor with its parameters."""
        parts = self._columns()
        allowed = self.declared.error + _sum_of_sizes(parts)
        self._compare("inverse_dynamics", self._run("inverse_dynamics")[0][:, 0], allowed)
        if "idm_regressor" in self.programs:
            self._compare("idm_regressor", np.sum(parts, axis=1), allowed)

    def direct(self) -> None:
        """Direct dynamics and its regressor, as the forces that their accelerations need.

        Both add up the columns of the inverse regressor too, and some of these may cancel: there is
        one for each product of declared parameters.
        """
        declared = self.declared
        sizes = _sum_of_sizes(
            np.column_stack(
                [self._columns(), declared.force, declared.inertia * declared.acceleration]
            )
        )
        results = {"direct_dynamics": self._run("direct_dynamics")[0]}
        if "ddm_regressor" in self.programs:
            row, intercept = self._run("ddm_regressor")
            results["ddm_regressor"] = np.column_stack(
                [row * self._run("ddm_from_physical")[0], intercept]
            )
        with np.errstate(invalid="ignore"):
            for name, parts in results.items():
                spent = declared.inertia[:, None] * parts
                more = np.sum(spent, axis=1) - declared.inertia * declared.acceleration
                allowed = declared.error + sizes + _sum_of_sizes(spent)
                got = np.where(declared.inertia == 0, 0.0, more) + declared.force
                self._compare(name, got, allowed)

    def _columns(self) -> Array:
        """What the inverse regressor adds up: its columns times their parameters, and the rest."""
        if "idm_regressor" not in self.programs:
            return self._run("inverse_dynamics")[0]
        row, intercept = self._run("idm_regressor")
        return np.column_stack([row * self.declared.parameters, intercept])

    def _run(self, name: str) -> list[Array]:
        return list(evaluate(self.programs[name], self.declared.elements).values())

    def _compare(self, name: str, got: Array, allowed: Array) -> None:
        wanted = self.declared.force
        wrong = ~(np.abs(got - wanted) <= allowed)
        if not np.any(wrong):
            return
        i = int(np.argmax(wrong))
        where = ", ".join(
            f"{name} = {values[i]:.6g}" for name, values in self.declared.elements.items()
        )
        raise ModelError(
            f"axis {self.axis!r}: the generated {name} gives a force of {got[i]:.9g} where the "
            f"equation of motion gives {wanted[i]:.9g}, a fault of the program; report it with the "
            f"axis, and write the equation of motion in another form. It was seen at {where}.",
            code="generated-force-differs",
        )


def _sum_of_sizes(parts: Array) -> Array:
    """What rounding makes of a sum of parts, (N, parts); 0 where it has no value."""
    sizes: Array = MAX_SUMMED_DIFFERENCE.value * np.sum(np.abs(parts), axis=1)
    return np.where(np.isfinite(sizes), sizes, 0.0)


def _declared(model: AxisModel, points: Sequence[Point]) -> _DeclaredForce | None:
    """The force where it has a value; None if it has one nowhere."""
    axis = model.base.declared
    q = axis.coordinate
    force = with_numbers(at_start(axis.force) / axis.drive.profile)
    inertia = force.diff(q.acceleration)
    rows: list[list[float]] = []
    for point in points:
        oracle = Oracle(point)
        try:
            whole, slope = oracle(force), oracle(inertia)
        except UndecidedError:
            continue
        error = MAX_DECLARED_ROUNDING.value * (
            whole.error + abs(point[q.acceleration]) * slope.error
        )
        own = model.base.at([point[p.symbol] for p in axis.parameters])
        motion = [point[s] for s in (q.symbol, q.velocity, q.acceleration)]
        rows.append([*motion, *map(float, (whole.exact, slope.exact, error)), *own])
    recorded = {s.name: np.full(len(rows), value) for s, value in _recorded(model)}
    if not rows:
        return None
    position, velocity, acceleration, exact, slopes, errors, *values = np.array(rows).T
    return _DeclaredForce(
        elements={
            q.name: position,
            str(q.velocity): velocity,
            str(q.acceleration): acceleration,
            str(DIRECTION): np.sign(velocity),
            str(FORCE): exact,
            **recorded,
            **{p.name: x for p, x in zip(model.axis.parameters, values, strict=True)},
        },
        parameters=np.array(values).T,
        force=exact,
        inertia=slopes,
        acceleration=acceleration,
        error=errors,
    )


def _points(model: AxisModel) -> Iterator[Point]:
    """Motions anywhere, and beside the zeros of sums of the position or the velocity."""
    axis = model.base.declared
    q = axis.coordinate
    symbols = (q.symbol, q.velocity, q.acceleration)
    values = {p.symbol: _value(p) for p in axis.parameters}
    recorded = dict(_recorded(model))
    for motion in _ANYWHERE:
        yield {**dict(zip(symbols, motion, strict=True)), **values, **recorded}
    start = {**dict(zip(symbols, _ANYWHERE[0], strict=True)), **values, **recorded}
    here = Oracle(start)
    inertial = axis.force.diff(q.acceleration).free_symbols | set(model.idm.nonlinear)
    for moved in symbols[:2]:
        there = Oracle({**start, moved: start[moved] + 1})
        for node, term in _sums(with_numbers(at_start(axis.force)), moved):
            present = term.free_symbols | inertial
            some = {p: value if p in present else 0.0 for p, value in values.items()}
            if q.acceleration not in term.free_symbols:
                some[q.acceleration] = 0.0
            for step in _steps(node, here, there):
                point = {**start, **some, moved: start[moved] + step}
                if point[q.velocity]:  # at rest the direction may be any
                    yield point


def _recorded(model: AxisModel) -> list[tuple[sympy.Symbol, float]]:
    first, step = _RECORDED
    return [(s, first + i * step) for i, s in enumerate(model.axis.signal_symbols)]


def _value(parameter: Parameter) -> float:
    """The nominal value, or one of moderate size within the bounds."""
    return parameter.nominal or min(max(1.0, parameter.lower), parameter.upper)


def _sums(force: sympy.Expr, moved: sympy.Symbol) -> list[tuple[sympy.Expr, sympy.Expr]]:
    """Some of the sums in the terms of a force that depend on a symbol, each with its term."""
    exponents: dict[sympy.Expr, sympy.Expr] = {}
    raised: dict[sympy.Expr, sympy.Expr] = {}
    other: dict[sympy.Expr, sympy.Expr] = {}
    for term in sympy.Add.make_args(force):
        for node in sympy.preorder_traversal(term):
            joined = joined_exponential(node) if node.is_Mul else None
            if joined is not None and moved in joined[1].free_symbols:
                exponents.setdefault(joined[1], term)
            elif node.is_Pow and node.base.is_Add and moved in node.free_symbols:
                raised.setdefault(node.base, term)
            elif node.is_Add and moved in node.free_symbols:
                other.setdefault(node, term)
    return list({**exponents, **raised, **other}.items())[:_MOST_SUMS]


def _steps(node: sympy.Expr, here: Oracle, there: Oracle) -> Iterator[float]:
    """How far a sum is from where it is almost 0, if it is affine; `there` it is one step on."""
    try:
        start, slope = here(node).exact, there(node).exact - here(node).exact
    except UndecidedError:
        return
    if slope:
        yield from (float((value - start) / slope) for value in _BESIDE)
