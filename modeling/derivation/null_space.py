"""Changes of the parameters that no motion shows, and the combinations that several records show.

Several parameters may multiply the same function of the motion, or functions whose sum is zero. No
experiment separates such parameters: only combinations of them are identifiable. A *direction* is a
change of the parameters that no motion shows, given by a weight for each parameter.
"""

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from functools import reduce
from typing import TypeAlias

import sympy
from sympy import QQ
from sympy.polys.domains import PolynomialRing
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement

from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import (
    Coordinate,
    Exponents,
    NotRealError,
    Parameter,
    Row,
    fresh_name,
    product_of_powers,
    reduced_functions,
    reduced_rows,
)

from .inverse import Regressor

#: Direction: the weight of each parameter in a change that no motion shows.
NullSpaceVector: TypeAlias = dict[sympy.Symbol, sympy.Expr]

_PLACES, _STEPS = 101, (37, 59)  # a prime, and the steps of two points through its fractions
_FAR = 1000.0  # largest factor between a far point and the nominal values
_MOST_PRODUCTS = 20_000  # product of the numbers of terms, up to which directions are symbolic


def null_space(
    rows: Sequence[Row],
    monomials: Sequence[Exponents],
    parameters: Sequence[Parameter],
    known: AbstractSet[sympy.Symbol] = frozenset(),
) -> tuple[NullSpaceVector, ...]:
    """Return the directions in which given sums of products of parameters do not change.

    They are a basis of the null space of the Jacobian of the sums. Known parameters stay fixed.

    Parameters
    ----------
    rows : sequence of (k,) rows
        Weights of the k products in each sum.
    monomials : sequence of tuple of int
        Length k; each product as its exponents by parameter.
    parameters : sequence of Parameter
        Length p.
    known : set of sympy.Symbol
        Parameters that stay fixed.

    Returns
    -------
    tuple of dict
        Directions with weights as functions of the parameters; if these are too large, with decimal
        weights at the nominal values.
    """
    # The Jacobian of the sums with respect to the free parameters, as polynomials.
    free = [p.symbol for p in parameters if p.symbol not in known]
    ring = QQ[tuple(p.symbol for p in parameters)]
    sums = [
        ring.ring.from_dict(
            {e: QQ(w.numerator, w.denominator) for e, w in zip(monomials, row, strict=True) if w}
        )
        for row in rows
    ]
    slopes = [[total.diff(ring.from_sympy(p)) for p in free] for total in sums]
    if math.prod(map(len, sums)) <= _MOST_PRODUCTS:
        return tuple(_kernel(slopes, free, ring))
    # Too large: the null spaces at the nominal point and at a generic point; use the smaller one.
    found: list[tuple[NullSpaceVector, ...]] = []
    for point in (nominal_point(parameters), generic_points(parameters)[0]):
        table = [[Fraction(ring.to_sympy(w).xreplace(point)) for w in row] for row in slopes]
        found.append(tuple(_kernel(reduced_rows(table)[0], free, ring)))
    nominal, generic = found
    return tuple(map(_as_decimals, nominal if len(nominal) <= len(generic) else generic))


def _as_decimals(direction: NullSpaceVector) -> NullSpaceVector:
    """Return a direction with decimal weights, to show that it holds at the nominal values only."""
    return {p: sympy.Float(weight) for p, weight in direction.items()}


def _kernel(
    rows: Sequence[Sequence[PolyElement | Fraction]],
    symbols: Sequence[sympy.Symbol],
    ring: PolynomialRing,
) -> Iterator[NullSpaceVector]:
    """Yield a basis of the null space of a matrix of polynomials or numbers.

    The weights of each vector are polynomials without a common factor and with whole coefficients.
    If the weights are numbers, the last one is 1.

    Parameters
    ----------
    rows : sequence of rows
        Rows of the matrix.
    symbols : sequence of sympy.Symbol
        The parameter of each column.
    ring : PolynomialRing
        Polynomials of the parameters, to which the entries belong.
    """
    field = ring.get_field()
    table = [[field.convert(weight) for weight in row] for row in rows]
    basis = DomainMatrix(table, (len(table), len(symbols)), field).to_sparse().nullspace()
    for row in basis.to_list():
        vector = {j: weight for j, weight in enumerate(row) if weight}
        # Clear the denominators, then divide by the common factor of the weights.
        shared = reduce(ring.lcm, (weight.denom for weight in vector.values()))
        whole = {j: w.numer * shared.exquo(w.denom) for j, w in vector.items()}
        common = reduce(ring.gcd, whole.values())
        weights = {symbols[j]: weight.exquo(common) for j, weight in whole.items()}
        # Scale numbers so that the last weight is 1, and polynomials to whole coefficients.
        first, last = next(iter(weights.values())), next(reversed(weights.values()))
        if all(weight.is_ground for weight in weights.values()):
            unit = last.LC
        else:
            numbers = [number for weight in weights.values() for number in weight.coeffs()]
            unit = QQ(
                math.gcd(*(int(number.numerator) for number in numbers)),
                math.lcm(*(int(number.denominator) for number in numbers)),
            )
            unit = -unit if ring.to_sympy(first).could_extract_minus_sign() else unit
        yield {s: ring.to_sympy(weight.quo_ground(unit)) for s, weight in weights.items()}


def unidentifiable_directions(
    regressor: Regressor, parameters: Sequence[Parameter], coordinate: Coordinate
) -> tuple[NullSpaceVector, ...]:
    """Return changes of the parameters that no motion shows, for a partially linear axis.

    They are the null space of its regressor over all motions. The columns contain parameters, so
    ``exp(b) dq`` and ``a exp(b) dq`` look like two functions of the motion. The null space is
    therefore computed for numbers of the parameters: the nominal values, and values near and far
    from them, because two functions may agree at one point by coincidence. For a linear axis the
    result is empty: its base parameters show these directions.

    Parameters
    ----------
    regressor : Regressor
        Linearised about the parameters.
    parameters : sequence of Parameter
        One for each column.
    coordinate : Coordinate

    Returns
    -------
    tuple of dict
        Directions with rational weights if these are equal at all points, otherwise with decimals
        at the nominal values.
    """
    if not regressor.nonlinear:
        return ()
    # The directions at the nominal values and near them; empty if one of the points has none.
    symbols = tuple(p.symbol for p in parameters)
    near = (nominal_point(parameters), generic_points(parameters)[0])
    nearby: list[tuple[NullSpaceVector, ...]] = []
    for directions in _directions(regressor, symbols, coordinate, near):
        if not directions:
            return ()
        nearby.append(directions)
    if not nearby:
        return ()
    # Directions that are the same at far points too keep their rational weights.
    far = tuple(_far_points(parameters))
    everywhere = [*nearby, *_directions(regressor, symbols, coordinate, far)]
    fewest = min(nearby, key=len)
    return tuple(d if all(d in each for each in everywhere) else _as_decimals(d) for d in fewest)


def _directions(
    regressor: Regressor,
    symbols: Sequence[sympy.Symbol],
    coordinate: Coordinate,
    points: Sequence[Mapping[sympy.Symbol, sympy.Expr]],
) -> Iterator[tuple[NullSpaceVector, ...]]:
    """Yield the null space of a regressor at each point of the parameters.

    A point at which the regressor has no real value is omitted.
    """
    for point in points:
        with contextlib.suppress(NotRealError):
            rows = reduced_functions(regressor.columns, coordinate.velocity, point).rows
            yield tuple(_kernel(rows, symbols, QQ[symbols]))


def nominal_point(parameters: Sequence[Parameter]) -> Mapping[sympy.Symbol, sympy.Expr]:
    """Return the nominal values of the parameters by symbol, without zeros (see `_near`)."""
    return {p.symbol: sympy.Rational(str(_near(p))) for p in parameters}


def _near(parameter: Parameter) -> float:
    """Return the nominal value of a parameter; for 0, a value up to 1 in size within the bounds."""
    if parameter.nominal:
        return parameter.nominal
    if parameter.upper > 0:
        return min(1.0, parameter.upper)
    return max(-1.0, parameter.lower)


def _far_points(
    parameters: Sequence[Parameter],
) -> Iterator[Mapping[sympy.Symbol, sympy.Expr]]:
    """Yield two points of the parameters far from the nominal point.

    At the first point, each parameter is larger or smaller by a factor of up to 1000. At the second
    point, each factor is inverted. All values are within the bounds.
    """
    for sign in (1, -1):
        point = {}
        for i, p in enumerate(parameters):
            share = 2 * ((i + 1) * _STEPS[0] % _PLACES) / _PLACES - 1
            value = min(max(_near(p) * _FAR ** (sign * share), p.lower), p.upper)
            point[p.symbol] = sympy.Rational(str(value))
        yield point


def generic_points(
    parameters: Sequence[Parameter],
) -> tuple[Mapping[sympy.Symbol, sympy.Expr], ...]:
    """Return two points of the parameters with unrelated values, as rational numbers by symbol.

    Each value is within the bounds, and between half and twice the nominal value.
    """
    points: list[dict[sympy.Symbol, sympy.Expr]] = [{} for _ in _STEPS]
    for i, p in enumerate(parameters):
        near = _near(p)
        low, high = sorted((near / 2, 2 * near))
        start, end = (sympy.Rational(str(x)) for x in (max(low, p.lower), min(high, p.upper)))
        for point, step in zip(points, _STEPS, strict=True):
            share = sympy.Rational((i + 1) * step % _PLACES, _PLACES)
            point[p.symbol] = start + (end - start) * share
    return tuple(points)


#: A product of parameters: name and power of each factor, and the index, from 0, of the record to
#: which the product belongs; None if it is common to all records.
Product = tuple[tuple[tuple[str, int], ...], int | None]
_LONGEST_NAME = 28


#: A parameter that several records determine together: the column of its leading product, the
#: parameter, and its expression as text, which is empty for a declared parameter.
CommonParameter = tuple[int, Parameter, str]


def common_parameters(
    axis: Axis,
    products: Sequence[Product],
    single: Sequence[Parameter | None],
    rows: Sequence[list[Fraction]],
    taken: set[str],
) -> list[CommonParameter]:
    """Return the parameters that several records determine together.

    There is one for each row of the reduced echelon form of `rows`.

    Parameters
    ----------
    axis : Axis
        Axis whose parameters form the products.
    products : sequence of Product
        Products of parameters, one for each column of `rows`.
    single : sequence of Parameter or None
        For each product, its parameter if the product is a single parameter, otherwise None.
    rows : sequence of list of Fraction
        Weights of the products in each base parameter of each record, one row per base parameter.
    taken : set of str
        Names in lower case that no new parameter may have; the names of new parameters are added.

    Returns
    -------
    list of (int, Parameter, str)
        Pivot column, parameter, and its expression in the products, which is empty for a declared
        parameter.

    Raises
    ------
    ModelError
        There are too many weights for a reduction.
    """
    reduced, pivots = reduced_rows(rows)
    declared = {p.name: p for p in axis.parameters}
    found: list[CommonParameter] = []
    for row, pivot in zip(reduced, pivots, strict=True):
        alone = single[pivot]
        if alone is not None and sum(map(bool, row)) == 1:
            found.append((pivot, alone, ""))
            continue
        terms = [(w, p) for w, p in zip(row, products, strict=True) if w]
        texts = []
        for weight, product in terms:
            factors = _factors(product)
            texts.append(factors if weight == 1 else f"{float(weight):g}*{factors}")
        text = " + ".join(texts)
        found.append((pivot, _combination(terms, products[pivot], text, declared, taken), text))
    return found


def _combination(
    terms: Sequence[tuple[Fraction, Product]],
    lead: Product,
    text: str,
    declared: dict[str, Parameter],
    taken: set[str],
) -> Parameter:
    """Return a new parameter for a sum of weighted products of declared parameters.

    Parameters
    ----------
    terms : sequence of (Fraction, Product)
        Weights and products of the sum.
    lead : Product
        The leading product, whose unit is that of the sum.
    text : str
        The sum as text, for the description.
    declared : dict of str to Parameter
        Declared parameters by name.
    taken : set of str
        Names in lower case that the parameter may not have; the new name is added.
    """
    name = "_plus_".join(
        "_".join(f"{n}{e if e > 1 else ''}" for n, e in powers)
        + ("" if record is None else f"_{record + 1}")
        for _, (powers, record) in terms
    )
    nominal = math.fsum(
        float(weight) * math.prod(declared[n].nominal ** e for n, e in powers)
        for weight, (powers, _) in terms
    )
    unit = product_of_powers((declared[n].unit, e) for n, e in lead[0])
    return Parameter(
        fresh_name(name[:_LONGEST_NAME], taken), str(unit), nominal=nominal, description=text
    )


def _factors(product: Product) -> str:
    """Return a product as text: ``m*l**2``, with ``(record 2)`` if it belongs to one record."""
    powers, record = product
    factors = "*".join(f"{n}**{e}" if e > 1 else n for n, e in powers)
    return factors if record is None else f"{factors} (record {record + 1})"
