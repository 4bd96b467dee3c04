"""What multiplies products of parameters in a force, in the functions that the user declared.

Only the parameters are multiplied out; what does not depend on them stays as it was written.
"""

import math
from collections.abc import ItemsView, Iterable, Sequence

import sympy
from sympy.ntheory.multinomial import multinomial_coefficients

from axisid.modeling.quantities import check_size
from axisid.support.errors import ModelError

from .point_value import dependences, vanishes

#: Products of two terms that may be formed for one expression.
_MOST_PRODUCTS = 100_000

#: Powers of the parameters, whole ones of either sign.
Exponents = tuple[int, ...]
_Polynomial = dict[Exponents, sympy.Expr]


class Coefficients:
    """An expression as a polynomial of parameters, with expressions for its weights.

    Parameters
    ----------
    expression : sympy.Expr
    parameters : sequence of sympy.Symbol
        Those that it is a polynomial of, once everything that cancels is left out.

    Raises
    ------
    ModelError
        It has too many terms, or too large ones.
    """

    def __init__(self, expression: sympy.Expr, parameters: Sequence[sympy.Symbol]) -> None:
        self._one = (0,) * len(parameters)
        self._places = {p: j for j, p in enumerate(parameters)}
        self._zero = dict.fromkeys(parameters, sympy.S.Zero)
        self._made: dict[sympy.Basic, _Polynomial] = {}
        self._left = _MOST_PRODUCTS
        self._hidden: set[sympy.Symbol] = set()
        self._polynomial = self._of(expression)
        for weight in self._polynomial.values():
            check_size(weight, "the equation of motion, multiplied out,")

    @property
    def terms(self) -> ItemsView[Exponents, sympy.Expr]:
        """The weights by the products of powers."""
        return self._polynomial.items()

    @property
    def nonlinear(self) -> set[sympy.Symbol]:
        """The parameters that the expression is no polynomial of."""
        divisors = {
            p
            for exponents, weight in self.terms
            for p, exponent in zip(self._places, exponents, strict=True)
            if exponent < 0 and not vanishes(weight)
        }
        return self._hidden | divisors

    def __getitem__(self, exponents: Exponents) -> sympy.Expr:
        """The weight of a product of powers."""
        return self._polynomial.get(exponents, sympy.S.Zero)

    @property
    def rest(self) -> sympy.Expr:
        """What no parameter multiplies."""
        return self[self._one]

    def _of(self, node: sympy.Expr) -> _Polynomial:
        if node not in self._made:
            self._made[node] = self._worked_out(node)
        return self._made[node]

    def _worked_out(self, node: sympy.Expr) -> _Polynomial:
        if not node.free_symbols & self._places.keys():
            return {self._one: node}
        base, power = node.as_base_exp()
        whole = int(power) if power.is_Number and int(power) == float(power) else None
        if base in self._places and whole is not None:
            exponents = list(self._one)
            exponents[self._places[base]] = whole
            return {tuple(exponents): sympy.S.One}
        if node.is_Add:
            return _sum(map(self._of, node.args))
        if node.is_Mul:
            return self._product(map(self._of, node.args))
        if node.is_Pow and whole is not None and whole > 0:
            return self._power(self._of(base), whole)
        if isinstance(node, sympy.Piecewise):
            return self._chosen(node)
        return {self._one: self._opaque(node).xreplace(self._zero)}

    def _opaque(self, node: sympy.Basic) -> sympy.Basic:
        """A node that is taken as a whole; some of the parameters in it may cancel."""
        shown = node if isinstance(node, sympy.Expr) else sympy.Piecewise((1, node), (0, True))
        inside = node.free_symbols & self._places.keys() - self._hidden
        self._hidden |= {p for (p,) in dependences(shown, [{p} for p in inside])}
        return node

    def _chosen(self, node: sympy.Piecewise) -> _Polynomial:
        """The weights of what is chosen by conditions, chosen by the same."""
        values = [self._of(value) for value, _ in node.args]
        conditions = [self._opaque(c).xreplace(self._zero) for _, c in node.args]
        return {
            exponents: sympy.Piecewise(
                *(
                    (value.get(exponents, sympy.S.Zero), condition)
                    for value, condition in zip(values, conditions, strict=True)
                ),
                evaluate=False,  # its evaluation compares all conditions with all
            )
            for exponents in dict.fromkeys(e for value in values for e in value)
            if any(value.get(exponents, 0) != 0 for value in values)
        }

    def _power(self, base: _Polynomial, whole: int) -> _Polynomial:
        """By the multinomial theorem: a product after another nests sums in sums."""
        self._take(math.comb(whole + len(base) - 1, whole))
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

    def _take(self, terms: int) -> None:
        self._left -= terms
        if self._left < 0:
            raise ModelError(
                "the equation of motion has too many products of parameters.",
                code="equation",
            )

    def _product(self, factors: Iterable[_Polynomial]) -> _Polynomial:
        made: _Polynomial = {self._one: sympy.S.One}
        for factor in factors:
            self._take(len(made) * len(factor))
            made = _sum(
                {tuple(map(sum, zip(a, b, strict=True))): x * y}
                for a, x in made.items()
                for b, y in factor.items()
            )
        return made


def _sum(polynomials: Iterable[_Polynomial]) -> _Polynomial:
    terms: dict[Exponents, list[sympy.Expr]] = {}
    for polynomial in polynomials:
        for exponents, weight in polynomial.items():
            terms.setdefault(exponents, []).append(weight)
    return {exponents: sympy.Add(*weights) for exponents, weights in terms.items()}
