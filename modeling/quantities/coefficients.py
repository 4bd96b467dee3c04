"""Expand a force in products of parameters, and return their coefficients.

Only the parameters are multiplied out; factors that do not depend on them stay as written.
"""

import math
from collections.abc import Iterable, Sequence, Set as AbstractSet
from functools import cache

import sympy
from sympy.ntheory.multinomial import multinomial_coefficients

from axisid.support.errors import ModelError
from axisid.support.mappings import grouped

from .dependences import depends, vanishes
from .symbols import check_size

#: Largest number of products of two terms that may be formed for one expression.
_MOST_PRODUCTS = 100_000

#: Power of each parameter in a product, a whole number of either sign.
Exponents = tuple[int, ...]
# Coefficient of each product of parameters.
_Polynomial = dict[Exponents, sympy.Expr]


class Coefficients:
    """An expression as a polynomial of parameters, with expressions as its coefficients.

    Parameters
    ----------
    expression : sympy.Expr
    parameters : sequence of sympy.Symbol
        Parameters in which the expression is expanded.
    motion : set of sympy.Symbol
        Parameters that are treated like quantities of the motion: they stay in the coefficients.

    Attributes
    ----------
    terms : dict
        The coefficient of each monomial. A monomial is a tuple with the power of each parameter;
        all powers are 0 for the part without parameters.

    Raises
    ------
    ModelError
        The expanded expression has too many terms, or terms that are too large.
    """

    def __init__(
        self,
        expression: sympy.Expr,
        parameters: Sequence[sympy.Symbol],
        motion: AbstractSet[sympy.Symbol] = frozenset(),
    ) -> None:
        self._one = (0,) * len(parameters)  # exponents of the product without parameters
        # The parameters that are multiplied out, with their index in the exponents.
        self._places = {p: j for j, p in enumerate(parameters) if p not in motion}
        self._zero = dict.fromkeys(self._places, sympy.S.Zero)
        self._polynomial = cache(self._expanded)
        self._products_left = _MOST_PRODUCTS
        self._hidden: set[sympy.Symbol] = set()  # parameters inside nodes that are not expanded
        self.terms = self._polynomial(expression)
        for weight in self.terms.values():
            check_size(weight, "the equation of motion, multiplied out,")

    @property
    def nonlinear(self) -> set[sympy.Symbol]:
        """Return the parameters in which the expression is not a polynomial."""
        divisors = {
            p
            for exponents, weight in self.terms.items()
            for p, j in self._places.items()
            if exponents[j] < 0 and not vanishes(weight)
        }
        return self._hidden | divisors

    def _expanded(self, node: sympy.Expr) -> _Polynomial:
        """Return the polynomial of one node of the expression, from those of its arguments.

        A node that is neither a sum, a product, a power with a positive whole exponent nor a
        Piecewise becomes part of a coefficient.
        """
        if not node.free_symbols & self._places.keys():
            return {self._one: node}
        base, power = node.as_base_exp()
        whole = int(power) if power.is_Number and int(power) == float(power) else None
        if base in self._places and whole is not None:
            exponents = list(self._one)
            exponents[self._places[base]] = whole
            return {tuple(exponents): sympy.S.One}
        if node.is_Add:
            return _sum(map(self._polynomial, node.args))
        if node.is_Mul:
            return self._product(map(self._polynomial, node.args))
        if node.is_Pow and whole is not None and whole > 0:
            return self._power(self._polynomial(base), whole)
        if isinstance(node, sympy.Piecewise):
            return self._piecewise(node)
        return {self._one: self._opaque(node).xreplace(self._zero)}

    def _opaque(self, node: sympy.Basic) -> sympy.Basic:
        """Return a node that is not expanded, and add its parameters to `_hidden`.

        The expression is not a polynomial in these parameters, so `nonlinear` contains them. Only
        parameters of `_places` are added, which are those to be multiplied out. A parameter that
        cancels, so that the value of the node does not depend on it, is not added.

        Parameters
        ----------
        node : sympy.Basic
            An expression, or a condition of a Piecewise.
        """
        # `depends` needs an expression. A condition is replaced by one: 1 where it holds, else 0.
        value = node if isinstance(node, sympy.Expr) else sympy.Piecewise((1, node), (0, True))
        inside = node.free_symbols & self._places.keys() - self._hidden
        self._hidden |= {p for p in inside if depends(value, {p})}
        return node

    def _piecewise(self, node: sympy.Piecewise) -> _Polynomial:
        """Return the polynomial of a Piecewise; its coefficients are Piecewise expressions too."""
        values = [self._polynomial(value) for value, _ in node.args]
        conditions = [self._opaque(c).xreplace(self._zero) for _, c in node.args]
        return {
            exponents: sympy.Piecewise(
                *(
                    (value.get(exponents, sympy.S.Zero), condition)
                    for value, condition in zip(values, conditions, strict=True)
                ),
                evaluate=False,  # its evaluation compares all pairs of conditions
            )
            for exponents in dict.fromkeys(e for value in values for e in value)
            if any(value.get(exponents, 0) != 0 for value in values)
        }

    def _power(self, base: _Polynomial, whole: int) -> _Polynomial:
        """Return a positive whole power of a polynomial, by the multinomial theorem.

        Repeated multiplication would nest sums in sums.
        """
        self._count_products(math.comb(whole + len(base) - 1, whole))
        shares = multinomial_coefficients(len(base), whole)
        return _sum(
            {
                tuple(
                    sum(k * e for k, e in zip(powers, each, strict=True))
                    for each in zip(*base, strict=True)
                ): (sympy.Mul(count, *(w**k for w, k in zip(base.values(), powers, strict=True))))
            }
            for powers, count in shares.items()
        )

    def _count_products(self, count: int) -> None:
        """Count further products of two terms; refuse an expression that needs too many of them."""
        self._products_left -= count
        if self._products_left < 0:
            raise ModelError(
                "the equation of motion has too many products of parameters. Declare parameters "
                "that enter together as one parameter.",
                code="equation",
            )

    def _product(self, factors: Iterable[_Polynomial]) -> _Polynomial:
        """Return the product of polynomials."""
        product: _Polynomial = {self._one: sympy.S.One}
        for factor in factors:
            self._count_products(len(product) * len(factor))
            product = _sum(
                {tuple(map(sum, zip(a, b, strict=True))): x * y}
                for a, x in product.items()
                for b, y in factor.items()
            )
        return product


def _sum(polynomials: Iterable[_Polynomial]) -> _Polynomial:
    """Return the sum of polynomials."""
    terms = grouped(term for polynomial in polynomials for term in polynomial.items())
    return {exponents: sympy.Add(*weights) for exponents, weights in terms.items()}
