"""Sums of products of factors, with exact weights, and what powers of factors reduce to.

A *factor* is what cannot be taken apart: a symbol, a sine, the root of a sum, a function. Every
product of two terms is counted, so that the work is bounded whatever is multiplied.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import sympy

from axisid.support.errors import ModelError

from .constant_value import power_of, value_of

#: Exact; whole numbers as integers, which are many times faster.
Number: TypeAlias = int | Fraction
#: Places of factors, with their powers, in the order of the places.
Product: TypeAlias = tuple[tuple[int, Number], ...]
#: Weights by products; none is 0.
Sum: TypeAlias = dict[Product, Number]

#: Products of two terms that may be formed for one expression.
MOST_PRODUCTS = 100_000

HALF = Fraction(1, 2)
_LOST = Fraction(1, 10**30)  # share of two numbers below which their sum is what rounding left
_LONG, _KEPT = 400, 120  # binary digits from which a weight in a factor is rounded, and to which
_WAVES = ("sin", "cos")


class TooLargeError(ModelError):
    """An expression has too many terms once it is multiplied out."""

    code = "too-many-terms"


@dataclass(frozen=True, slots=True)
class Factor:
    """What cannot be taken apart.

    Attributes
    ----------
    kind : str or type
        ``symbol``; ``base`` of a power that is not whole and positive; ``exp``, a base to the power
        of a product; ``sin``, ``cos``, ``sign`` and ``abs`` of a sum, the last to a power that is
        not whole; ``case``, 1 where the last of its conditions alone holds; or a class of SymPy.
    content : hashable
        What of, with all sums as tuples.
    symbols : frozenset of sympy.Symbol
        What it depends on.
    """

    kind: Any
    content: Hashable
    symbols: frozenset[sympy.Symbol]


def tidy(value: Number) -> Number:
    """A number as an integer, if it is whole."""
    if value.denominator == 1:
        return value.numerator
    return value


def modulus_of(value: Number) -> Number:
    """The absolute value of a number, as a number of the same kind."""
    return -value if value < 0 else value


def constant(value: Number) -> Sum:
    """A number as a sum."""
    return {(): tidy(value)} if value else {}


def number_in(total: Sum) -> Number | None:
    """The number that a sum is, or None."""
    if not total:
        return 0
    return total.get(()) if len(total) == 1 else None


def scaled(total: Sum, scale: Number) -> Sum:
    """A multiple of a sum, not 0 times it."""
    return {product: tidy(scale * weight) for product, weight in total.items()}


def add(total: Sum, more: Sum, scale: Number = 1) -> None:
    """Add a multiple of a sum to another, in place."""
    for product, weight in more.items():
        _count(total, product, scale * weight)


def _count(total: Sum, product: Product, share: Number) -> None:
    """Add one term to a sum, in place."""
    value = tidy(total[product] + share if product in total else share)
    if value and (
        value.denominator.bit_length() < _LONG or modulus_of(value) > _LOST * modulus_of(share)
    ):
        total[product] = value
    else:
        total.pop(product, None)


def frozen(total: Sum) -> tuple[tuple[Product, Number], ...]:
    """A sum as a key, the same for weights that differ by rounding alone."""
    return tuple(sorted((product, _rounded(weight)) for product, weight in total.items()))


def _rounded(weight: Number) -> Number:
    if weight.denominator.bit_length() < _LONG:
        return weight
    places = _KEPT + weight.denominator.bit_length() - weight.numerator.bit_length()
    unit = Fraction(2) ** places
    return tidy(round(weight * unit) / unit)


def normal(total: Sum, *, positive: bool) -> tuple[Number, Sum]:
    """A number and a sum of first weight 1, or of weight 1 or -1 if the number must be positive."""
    lead = total[min(total)]
    if positive:
        lead = modulus_of(lead)
    return lead, scaled(total, Fraction(1) / lead)


@dataclass(frozen=True, slots=True)
class _Kinship:
    """Places of the absolute value and the sign of a sum, and of what it is if it is a factor."""

    modulus: int
    sign: int
    alone: int | None


class Algebra:
    """Multiplies sums, over factors that they share."""

    def __init__(self) -> None:
        self._places: dict[Factor, int] = {}
        self._factors: list[Factor] = []
        self._contents: dict[int, Sum] = {}  # of the factors whose powers reduce
        self._kin: dict[int, _Kinship] = {}
        self._left = MOST_PRODUCTS

    def factor(self, place: int) -> Factor:
        """The factor at a place."""
        return self._factors[place]

    def single(self, factor: Factor, content: Sum | None = None) -> Sum:
        """A factor as a sum; with what it is of, if its powers reduce."""
        return {((self._place(factor, content), 1),): 1}

    def symbols(self, *sums: Sum) -> frozenset[sympy.Symbol]:
        """What sums depend on."""
        places = {place for total in sums for product in total for place, _ in product}
        return frozenset().union(*(self._factors[place].symbols for place in places))

    def spend(self, products: int) -> None:
        """Count products that are formed."""
        self._left -= products
        if self._left < 0:
            raise TooLargeError(
                "the equation of motion has too many terms once it is multiplied out, as it is to "
                "find what a record tells apart; write less of it, smaller powers of sums, or "
                "fewer sines and cosines in a product."
            )

    def times(self, left: Sum, right: Sum) -> Sum:
        """The product of two sums.

        Raises
        ------
        TooLargeError
            More products were formed than are allowed.
        """
        self.spend(len(left) * len(right))
        total: Sum = {}
        for a, x in left.items():
            for b, y in right.items():
                powers = dict(a)
                for place, power in b:
                    powers[place] = tidy(powers[place] + power) if place in powers else power
                if self._contents.keys().isdisjoint(powers):
                    joined = tuple(sorted(item for item in powers.items() if item[1]))
                    _count(total, joined, x * y)
                else:
                    add(total, self._reduced(powers), x * y)
        return total

    def power(self, base: Sum, exponent: Number) -> Sum:
        """A sum to the power of a number."""
        number = number_in(base)
        if number is not None or not exponent:
            return constant(power_of(number, exponent) if number is not None and exponent else 1)
        whole = exponent.denominator == 1
        if len(base) == 1 and (not whole or exponent < 0 or self._is_plain(next(iter(base)))):
            ((product, weight),) = base.items()
            if not whole:
                return self._root(product, weight, exponent)
            powers = {place: tidy(power * exponent) for place, power in product}
            return scaled(self._reduced(powers), power_of(weight, exponent))
        if whole and exponent > 0:
            total = base
            for _ in range(exponent.numerator - 1):
                total = self.times(total, base)
            return total
        size, inside = normal(base, positive=not whole)
        return scaled(self._power_of("base", inside, exponent), power_of(size, exponent))

    def modulus(self, total: Sum, exponent: Number = 1) -> Sum:
        """The absolute value of a sum, to the power of a number."""
        number = number_in(total)
        if number is not None:
            return self.power(constant(modulus_of(number)), exponent)
        if exponent.denominator == 1 or len(total) == 1:
            return self.power(self.times(total, self.sign(total)), exponent)
        size, inside = normal(total, positive=False)
        return scaled(self._power_of("abs", inside, exponent), power_of(modulus_of(size), exponent))

    def sign(self, total: Sum) -> Sum:
        """The sign of a sum, 1 or -1."""
        number = number_in(total)
        if number is not None:
            return constant(value_of(sympy.sign, (number,)))
        size, inside = normal(total, positive=False)
        factors = [inside]
        if len(inside) == 1:
            signed = [
                place
                for place, power in next(iter(inside))
                if power % 2 == 1 and self._factors[place].kind not in ("exp", "abs")
            ]
            factors = [{((place, 1),): 1} for place in signed]
        result = constant(1 if size > 0 else -1)
        for factor in factors:
            result = self.times(result, self._power_of("sign", factor, 1))
        return result

    def wave(self, kind: str, angle: Sum) -> Sum:
        """The sine or cosine of a sum, with a constant phase taken out of it."""
        phase = angle.get((), 0)
        moving = {product: weight for product, weight in angle.items() if product}
        if not moving:
            return constant(value_of(getattr(sympy, kind), (phase,)))
        turned = moving[min(moving)] < 0
        inside = scaled(moving, -1) if turned else moving
        same, other = (self._power_of(name, inside, 1) for name in (kind, _other(kind)))
        if turned and kind == "sin":
            same = scaled(same, -1)
        if not phase:
            return same
        if turned and kind == "cos":
            other = scaled(other, -1)
        total: Sum = {}
        add(total, same, value_of(sympy.cos, (phase,)))
        add(total, other, value_of(sympy.sin, (phase,)) * (1 if kind == "sin" else -1))
        return total

    def _place(self, factor: Factor, content: Sum | None = None) -> int:
        if factor not in self._places:
            self._places[factor] = len(self._factors)
            self._factors.append(factor)
            if content is not None:
                self._contents[self._places[factor]] = content
        return self._places[factor]

    def _power_of(self, kind: str, content: Sum, exponent: Number) -> Sum:
        """The power of a factor of a sum; ``sign(sign)`` is ``sign``."""
        if kind == "sign" and len(content) == 1:
            place = next(iter(content))[0][0]
            if self._factors[place].kind == "sign":
                return content
        factor = Factor(kind, frozen(content), self.symbols(content))
        return self._reduced({self._place(factor, content): exponent})

    def _is_plain(self, product: Product) -> bool:
        """Whether a product's powers do not reduce."""
        return not any(place in self._contents for place, _ in product)

    def _root(self, product: Product, weight: Number, exponent: Number) -> Sum:
        """A power that is not whole of one term: of its positive factors one by one."""
        result = constant(power_of(modulus_of(weight), exponent))
        signs = {self._factors[p].content: p for p, _ in product if self._factors[p].kind == "sign"}
        rest = dict(product)
        for place, power in product:
            own: Sum = {((place, 1),): 1}
            kind, sign = self._factors[place].kind, signs.get(frozen(own))
            odd = power % 2 == 1 and kind != "sign"
            if kind in ("exp", "abs") or power.denominator != 1:
                result = self.times(result, {((place, tidy(power * exponent)),): 1})
            elif power % 2 == 0 or (odd and sign in rest):
                result = self.times(result, self._power_of("abs", own, tidy(power * exponent)))
                if odd and sign is not None:
                    del rest[sign]
            else:
                continue
            del rest[place]
        if not rest and weight > 0:
            return result
        if weight > 0 and list(rest.values()) == [1]:
            return self.times(result, self._reduced({next(iter(rest)): exponent}))
        inside: Sum = {tuple(sorted(rest.items())): 1 if weight > 0 else -1}
        return self.times(result, self._power_of("base", inside, exponent))

    def _reduced(self, powers: dict[int, Number]) -> Sum:
        """A product of powers of factors, by what these are."""
        plain = dict(powers)
        parts: list[Sum] = []
        waves: list[int] = []
        for place in sorted(self._contents.keys() & powers.keys()):
            kind, power = self._factors[place].kind, plain.get(place, 0)
            if kind in ("sign", "abs"):
                parts += self._signed(place, plain)
            elif kind == "case":
                plain[place] = min(power, 1)
            elif kind in _WAVES:
                waves += [place] * int(power) if power > 0 and power.denominator == 1 else []
            elif power > 0 and (whole := power.numerator // power.denominator):
                plain[place] = power - whole
                parts.append(self.power(self._contents[place], whole))
        if len(waves) > 1:
            plain = {place: power for place, power in plain.items() if place not in waves}
            parts.append(self._mixed(waves))
        total: Sum = {tuple(sorted((p, tidy(e)) for p, e in plain.items() if e)): 1}
        for part in parts:
            total = self.times(total, part)
        return total

    def _signed(self, place: int, plain: dict[int, Number]) -> list[Sum]:
        """Write ``g**b |g|**a sign(g)**c`` in one way; what is multiplied out is returned."""
        kin = self._kinship(place)
        a, c = plain.pop(kin.modulus, 0), plain.pop(kin.sign, 0)
        if kin.alone is None:
            more = a.numerator // a.denominator if a.denominator == 1 or a > 1 else 0
            plain[kin.modulus], plain[kin.sign] = a - more, (more + c) % 2
            return [self.power(self._contents[place], more)] if more else []
        b = plain.get(kin.alone, 0)
        if b.denominator != 1:
            plain[kin.modulus], plain[kin.sign] = a, c % 2
            return []
        whole = a.denominator == 1
        plain[kin.alone] = a + b if whole else 0
        plain[kin.modulus] = 0 if whole else a + b
        plain[kin.sign] = ((a if whole else b) + c) % 2
        return []

    def _kinship(self, place: int) -> "_Kinship":
        if place not in self._kin:
            content, factor = self._contents[place], self._factors[place]
            modulus, sign = (
                self._place(Factor(kind, factor.content, factor.symbols), content)
                for kind in ("abs", "sign")
            )
            product = next(iter(content))
            alone = len(content) == 1 and len(product) == 1 and product[0][1] == 1
            kin = _Kinship(modulus, sign, product[0][0] if alone else None)
            self._kin[modulus] = self._kin[sign] = kin
        return self._kin[place]

    def _mixed(self, waves: Sequence[int]) -> Sum:
        """The product of sines and cosines as a sum of them."""
        first, *others = waves
        total: Sum = {((first, 1),): 1}
        for place in others:
            result: Sum = {}
            self.spend(2 * len(total))
            for product, weight in total.items():
                factor: Sum = {((place, 1),): 1}
                mixed = self._beat(product[0][0], place) if product else factor
                add(result, mixed, weight)
            total = result
        return total

    def _beat(self, one: int, two: int) -> Sum:
        """The product of two waves by the difference and the sum of their angles."""
        kinds = [self._factors[place].kind for place in (one, two)]
        if kinds == ["cos", "sin"]:
            return self._beat(two, one)
        angles = [dict(self._contents[one]), dict(self._contents[one])]
        for angle, way in zip(angles, (-1, 1), strict=True):
            add(angle, self._contents[two], way)
        kind = "cos" if kinds[0] == kinds[1] else "sin"
        less, more = (self.wave(kind, angle) for angle in angles)
        total = scaled(less, HALF)
        add(total, more, -HALF if kinds == ["sin", "sin"] else HALF)
        return total


def _other(kind: str) -> str:
    return "cos" if kind == "sin" else "sin"
