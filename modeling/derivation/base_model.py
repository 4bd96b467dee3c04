"""Base parameters: the smallest set of parameter combinations in which the force is linear.

Physical parameters enter the force as products (``m l``, ``m l**2``) and sums (``J + m l**2``), and
a record determines only these combinations. This module derives the combinations, the *base
parameters*, declares the axis again with them as its parameters, and keeps the map from the
declared parameters to them.

The force is ``sum of mu_j(parameters) f_j(motion)``, with a monomial mu_j of the parameters and a
function f_j of the motion. Let R be the reduced row echelon form of the matrix with the values of
the f_j, one column for each f_j and one row for each of many independent motions. ``R mu`` is then
the smallest set of combinations on which the force depends.
"""

import math
from collections.abc import Mapping, Sequence, Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import sympy
from sympy.core.expr import AtomicExpr

from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import (
    CANNOT,
    Coefficients,
    Exponents,
    NotRealError,
    Parameter,
    Row,
    check_size,
    fresh_name,
    product_of_powers,
    reduced_functions,
    rounded,
    unmerged,
    value_at,
    with_numbers,
)
from axisid.support.errors import ModelError

from .inverse import with_direction
from .null_space import NullSpaceVector, null_space


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The combinations of monomials of the parameters on which a force depends.

    Each combination is a row of weights, with one weight for each monomial.

    Attributes
    ----------
    monomials : tuple of tuple of int
        Distinct monomials, each as its exponents by parameter; those of the lowest degree first.
    rows : tuple of list of Fraction
        Weights of each combination, in reduced row echelon form, one column for each monomial.
    pivots : tuple of int
        For each row, the column of its leading 1, an index into `monomials`.
    nonlinear : frozenset of sympy.Symbol
        Parameters that do not enter by whole powers only. They are treated like quantities of the
        motion, and each has its own row and column.
    undecided : tuple of tuple of tuple of int
        Groups of monomials whose functions of the motion were linearly dependent at all evaluated
        points, although the dependence is not proved.
    rounded : bool
        Whether some functions are dependent only if rounding errors of declared decimals are
        ignored.
    """

    monomials: tuple[Exponents, ...]
    rows: tuple[Row, ...]
    pivots: tuple[int, ...]
    nonlinear: frozenset[sympy.Symbol]
    undecided: tuple[tuple[Exponents, ...], ...] = ()
    rounded: bool = False


def force_terms(
    force: sympy.Expr,
    velocity: sympy.Symbol,
    parameters: Sequence[sympy.Symbol],
    differing: Sequence[Mapping[sympy.Symbol, Any]] = (),
    *,
    merged: bool = True,
) -> Terms:
    """Return the combinations of monomials of the parameters on which a force depends.

    The force is expanded into monomials of the parameters, each times a function of the motion. The
    functions are reduced to independent functions. Each nonlinear parameter then gets its own
    monomial, row and column, and columns that are zero in every row are removed.

    Parameters
    ----------
    force : sympy.Expr
        Force with the friction direction in place of ``sign(dq)``.
    velocity : sympy.Symbol
    parameters : sequence of sympy.Symbol
    differing : sequence of mapping of sympy.Symbol to number
        Points at which functions that appeared equal are known to differ.
    merged : bool
        Whether a function that is a linear combination of other functions is merged with them.
        Otherwise all functions are kept, and such a combination is listed in `Terms.undecided`.

    Raises
    ------
    ModelError
        The force has too many products of parameters, or a part that is not a real number.
    """
    # Every part without symbols must be a finite real number.
    nodes = force.atoms(AtomicExpr, sympy.Pow, sympy.Function)
    for node in (n for n in nodes if not (n.is_Rational or n.free_symbols)):
        try:
            value_at(node, {})
        except CANNOT as error:
            raise NotRealError(
                f"{node} has no finite real value. Write a force that is finite and real."
            ) from error
    # Expand the force in the parameters that enter by whole powers.
    nonlinear = Coefficients(force, parameters).nonlinear
    terms = Coefficients(force, parameters, nonlinear).terms
    # The functions of the motion by their monomial, without the known part of the force.
    weights = {e: terms[e] for e in sorted(terms, key=_order) if any(e)}
    functions = list(weights.values())
    reduced = reduced_functions(functions, velocity, differing=differing)
    found, pivots, doubts, rounded = reduced if merged else unmerged(reduced, len(functions))
    # Append one monomial, and one row with a single 1, for each nonlinear parameter.
    own = [j for j, p in enumerate(parameters) if p in nonlinear]
    monomials = [*weights, *(tuple(int(i == j) for i in range(len(parameters))) for j in own)]
    units = [
        [Fraction(i == j) for i in range(len(monomials))]
        for j in range(len(weights), len(monomials))
    ]
    rows = [*([*row, *[Fraction(0)] * len(own)] for row in found), *units]
    # Keep the monomials that occur in some row, those of the lowest degree first.
    order = [
        j
        for j in sorted(range(len(monomials)), key=lambda j: _order(monomials[j]))
        if any(row[j] for row in rows)
    ]
    return Terms(
        monomials=tuple(monomials[j] for j in order),
        rows=tuple([row[j] for j in order] for row in rows),
        pivots=tuple(order.index(j) for j in (*pivots, *range(len(weights), len(monomials)))),
        nonlinear=frozenset(nonlinear),
        undecided=tuple(tuple(monomials[j] for j in columns) for columns in doubts),
        rounded=rounded,
    )


def _order(exponents: Exponents) -> tuple[int, tuple[int, ...]]:
    """Return the sorting key of a monomial: its degree, then its parameters in their order."""
    return sum(exponents), tuple(-e for e in exponents)


_LONGEST_NAME = 31


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseModel:
    """An axis in base parameters, ``beta = weights . monomials(parameters)``.

    Dimensions: p declared parameters, b base parameters, k monomials.

    Attributes
    ----------
    declared : Axis
        The axis as declared.
    axis : Axis
        The same axis, linear in its base parameters; `declared` itself if the declared parameters
        are base parameters.
    expressions : tuple of sympy.Expr
        Length b; each base parameter as a function of the declared ones.
    exponents : tuple of tuple of int
        (k, p); exponents of the declared parameters in each monomial.
    weights : tuple of tuple of float
        (b, k); weight of each monomial in each base parameter.
    unidentifiable : tuple of dict
        Changes of the declared parameters that no motion shows: the null space of the Jacobian of
        the base parameters.
    undetermined : tuple of dict
        Such changes with the known declared parameters fixed.
    undecided : tuple of tuple of sympy.Expr
        Groups of products of the declared parameters whose forces could not be distinguished,
        although it is not proved that they are equal. For a group of one product, no effect was
        found. All these products are kept.
    rounded : bool
        Whether parameters were merged whose functions of the motion are equal only if rounding
        errors of declared decimals are ignored.
    """

    declared: Axis
    axis: Axis
    expressions: tuple[sympy.Expr, ...]
    exponents: tuple[Exponents, ...]
    weights: tuple[tuple[float, ...], ...]
    unidentifiable: tuple[NullSpaceVector, ...]
    undetermined: tuple[NullSpaceVector, ...]
    undecided: tuple[tuple[sympy.Expr, ...], ...] = ()
    rounded: bool = False

    @property
    def changed(self) -> bool:
        """Return whether the base parameters differ from the declared parameters."""
        return self.axis is not self.declared

    @property
    def known(self) -> tuple[Parameter, ...]:
        """Return the declared parameters whose values are known independently of a record."""
        return tuple(p for p in self.declared.parameters if p.known is not None)

    @property
    def combined(self) -> tuple[tuple[Parameter, sympy.Expr], ...]:
        """Return the base parameters that are not declared parameters, each with its expression.

        The expression is a function of the declared parameters.
        """
        pairs = zip(self.axis.parameters, self.expressions, strict=True)
        return tuple((p, value) for p, value in pairs if p.symbol != value)

    def at(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the values (b,) of the base parameters, SI, for declared parameters (p,)."""
        sizes = [
            math.prod(v**e for v, e in zip(values, powers, strict=True) if e)
            for powers in self.exponents
        ]
        return tuple(
            math.fsum(w * size for w, size in zip(row, sizes, strict=True) if w)
            for row in self.weights
        )


def base_model(
    axis: Axis,
    balance: sympy.Expr | None = None,
    differing: Sequence[Mapping[sympy.Symbol, Any]] = (),
    *,
    merged: bool = True,
) -> BaseModel:
    """Derive the base parameters of an axis, and the axis declared in them.

    A parameter that does not enter by sums of products of whole powers is treated like a quantity
    of the motion, and remains unchanged. The function finds the independent combinations of
    parameters, refuses parameters without effect, sorts the combinations by the first declared
    parameter in the leading monomial of each, and rewrites the axis unless the combinations are the
    declared parameters themselves.

    Parameters
    ----------
    axis : Axis
    balance : sympy.Expr, optional
        The force of the axis with the friction direction in place of ``sign(dq)``; derived here by
        default.
    differing : sequence of mapping of sympy.Symbol to number
        Points at which the force in base parameters was found to differ from the declared force.
    merged : bool
        Whether parameters with linearly dependent functions of the motion are merged; otherwise all
        products of parameters are kept.

    Raises
    ------
    ModelError
        A parameter has no effect, or the force jumps with the velocity in a way that is not
        friction.

    References
    ----------
    [GautierKhalil1990]_; here by a reduced row echelon form, which applies to any force.
    """
    q, symbols = axis.coordinate, tuple(p.symbol for p in axis.parameters)
    if balance is None:
        balance = with_direction(with_numbers(axis.force), q.velocity)
    found = force_terms(balance, q.velocity, symbols, differing, merged=merged)
    cancelled = [str(p) for j, p in enumerate(symbols) if not any(e[j] for e in found.monomials)]
    if cancelled:
        names, verb = ", ".join(cancelled), "has" if len(cancelled) == 1 else "have"
        raise ModelError(
            f"{names} {verb} no effect on the force, because all terms of {names} cancel. Remove "
            f"{names} from the declaration."
        )
    # The monomial that leads each combination decides the order of the base parameters.
    leads = [found.monomials[pivot] for pivot in found.pivots]
    places = sorted(range(len(leads)), key=lambda i: _first(leads[i]))
    table = [found.rows[i] for i in places]
    expressions = tuple(_expression(row, found.monomials, symbols) for row in table)
    is_unchanged = expressions == symbols
    known = {p.symbol for p in axis.parameters if p.known is not None}
    base = BaseModel(
        declared=axis,
        axis=axis,
        expressions=expressions,
        exponents=found.monomials,
        weights=tuple(tuple(map(float, row)) for row in table),
        unidentifiable=() if is_unchanged else null_space(table, found.monomials, axis.parameters),
        undetermined=()
        if is_unchanged
        else null_space(table, found.monomials, axis.parameters, known),
        undecided=tuple(tuple(_product(e, symbols) for e in group) for group in found.undecided),
        rounded=found.rounded,
    )
    if is_unchanged:
        return base
    return replace(base, axis=_reduced(base, [leads[i] for i in places], found.nonlinear))


def declared_as_base(axis: Axis) -> BaseModel:
    """Return an axis with its declared parameters as base parameters, without combinations."""
    count = range(len(axis.parameters))
    return BaseModel(
        declared=axis,
        axis=axis,
        expressions=tuple(p.symbol for p in axis.parameters),
        exponents=tuple(tuple(int(i == j) for j in count) for i in count),
        weights=tuple(tuple(float(i == j) for j in count) for i in count),
        unidentifiable=(),
        undetermined=(),
    )


def _first(exponents: Exponents) -> tuple[int, int, Exponents]:
    """Return the sorting key of a base parameter, from the exponents of its leading monomial.

    It is the index of the first declared parameter in the monomial, then the degree.
    """
    return next(j for j, e in enumerate(exponents) if e), sum(exponents), exponents


def _expression(
    row: Row, monomials: Sequence[Exponents], symbols: Sequence[sympy.Symbol]
) -> sympy.Expr:
    """Return the sum of monomials of the parameters with the weights of a row."""
    return sympy.Add(
        *(
            sympy.Rational(weight.numerator, weight.denominator) * _product(e, symbols)
            for weight, e in zip(row, monomials, strict=True)
            if weight
        )
    )


def _product(exponents: Exponents, symbols: Sequence[sympy.Symbol]) -> sympy.Expr:
    """Return a monomial of the parameters from its exponents."""
    return sympy.Mul(*(p**power for p, power in zip(symbols, exponents, strict=True) if power))


def _reduced(
    base: BaseModel, leads: Sequence[Exponents], nonlinear: AbstractSet[sympy.Symbol]
) -> Axis:
    """Return the axis declared in base parameters.

    The declared force is split into monomials of the parameters. The coefficient of the monomial
    that leads a base parameter becomes the coefficient of that base parameter.

    Parameters
    ----------
    base : BaseModel
        The base parameters, with the declared axis.
    leads : sequence of tuple of int
        For each base parameter, its leading monomial, which has the weight 1.
    nonlinear : set of sympy.Symbol
        Parameters that enter nonlinearly; they stay in the coefficients.
    """
    axis = base.declared
    declared = {p.symbol: p for p in axis.parameters}
    taken = axis.taken_names
    parameters = tuple(
        declared[value] if value in declared else _combined(base, i, leads[i], taken)
        for i, value in enumerate(base.expressions)
    )
    weights = Coefficients(axis.force, tuple(declared), nonlinear).terms
    rest = weights.get((0,) * len(declared), sympy.S.Zero)
    scaled = zip(parameters, leads, strict=True)
    force = sympy.Add(rest, *(p * weights.get(lead, sympy.S.Zero) for p, lead in scaled))
    check_size(force, "the equation of motion in base parameters")
    truth = axis.experiment and replace(axis.experiment, truth=_truth(base, parameters))
    return replace(axis, parameters=parameters, force=force, experiment=truth)


def _truth(base: BaseModel, parameters: Sequence[Parameter]) -> dict[str, float]:
    """Return the true values of the base parameters of the axis's synthetic twin, SI, by name."""
    experiment, declared = base.declared.experiment, base.declared.parameters
    truth = experiment.truth if experiment else {}
    values = base.at([truth.get(p.name, p.nominal) for p in declared])
    return dict(zip([p.name for p in parameters], values, strict=True))


def _combined(base: BaseModel, i: int, lead: Exponents, taken: set[str]) -> Parameter:
    """Return a new parameter for a base parameter that is not a declared parameter.

    Its unit is the unit of its leading monomial. Its nominal value and bounds follow from those of
    the declared parameters.

    Parameters
    ----------
    base : BaseModel
    i : int
        Index of the base parameter.
    lead : tuple of int
        Exponents of its leading monomial.
    taken : set of str
        Names in use, in lower case; the new name is added.
    """
    declared = base.declared.parameters
    start = [p.nominal if p.known is None else p.known for p in declared]
    lower, upper = _bounds(base, i)
    return Parameter(
        fresh_name(_name(base, i), taken),
        str(product_of_powers((p.unit, e) for p, e in zip(declared, lead, strict=True) if e)),
        nominal=base.at(start)[i],
        lower=lower,
        upper=upper,
        description=str(rounded(base.expressions[i])),
    )


def _bounds(base: BaseModel, i: int) -> tuple[float, float]:
    """Return the lower and upper bound of base parameter number `i`; infinite if unknown.

    Bounds are known only if the declared parameters in it are at least 0 and its weights are
    positive.
    """
    inside = base.expressions[i].free_symbols
    low, high = (
        [getattr(p, side) if p.symbol in inside else 0.0 for p in base.declared.parameters]
        for side in ("lower", "upper")
    )
    if min(low) < 0 or min(base.weights[i]) < 0:
        return -math.inf, math.inf
    return base.at(low)[i], base.at(high)[i] if max(high) < math.inf else math.inf


def _name(base: BaseModel, i: int) -> str:
    """Return a name for base parameter number `i`, of 31 characters at most.

    ``m_l2`` stands for ``m l**2`` and ``J_plus_m_l2`` for ``J + m l**2``; weights are omitted.
    """
    names = [p.name for p in base.declared.parameters]
    text = ""
    for weight, powers in zip(base.weights[i], base.exponents, strict=True):
        if weight:
            if text:
                text += "_plus_" if weight > 0 else "_minus_"
            text += "_".join(
                f"{name}{e if e > 1 else ''}" for name, e in zip(names, powers, strict=True) if e
            )
    return text if len(text) <= _LONGEST_NAME else text.replace("_plus_", "_")[:_LONGEST_NAME]
