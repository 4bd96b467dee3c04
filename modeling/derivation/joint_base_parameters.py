"""The smallest set of parameters that the base parameters of several records depend on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from axisid.modeling.algebra import reduced_rows
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter, fresh_name, product_of_powers

#: Powers of declared parameters by name, and the number of the record if the product is its own.
Product = tuple[tuple[tuple[str, int], ...], int | None]
_LONGEST_NAME = 28


@dataclass(frozen=True, slots=True)
class CommonParameters:
    """Parameters with how they are made, and the products that lead them.

    Attributes
    ----------
    parameters : tuple of (Parameter, str)
        The expression is empty of one that is declared.
    pivots : tuple of int
    """

    parameters: tuple[tuple[Parameter, str], ...]
    pivots: tuple[int, ...]


def common_parameters(
    axis: Axis,
    products: Sequence[Product],
    single: Sequence[Parameter | None],
    rows: Sequence[list[Fraction]],
    taken: set[str],
) -> CommonParameters:
    """Reduce weights of products, one row for each base parameter of each record.

    Parameters
    ----------
    axis : Axis
        Whose parameters the products are of.
    products : sequence of Product
    single : sequence of Parameter or None
        Of products that are a parameter by themselves.
    rows : sequence of list of Fraction
    taken : set of str
        Names in lower case that no new parameter may have; new ones are added.

    Raises
    ------
    ModelError
        As `reduced_rows` does.
    """
    reduced, pivots = reduced_rows(rows)
    declared = {p.name: p for p in axis.parameters}
    found = []
    for row, pivot in zip(reduced, pivots, strict=True):
        alone = single[pivot]
        if alone is not None and sum(map(bool, row)) == 1:
            found.append((alone, ""))
            continue
        terms = [(w, p) for w, p in zip(row, products, strict=True) if w]
        said = " + ".join(
            factors if weight == 1 else f"{float(weight):g}*{factors}"
            for weight, factors in ((weight, _factors(product)) for weight, product in terms)
        )
        found.append((_made(terms, products[pivot], said, declared, taken), said))
    return CommonParameters(tuple(found), tuple(pivots))


def _made(
    terms: Sequence[tuple[Fraction, Product]],
    lead: Product,
    said: str,
    declared: dict[str, Parameter],
    taken: set[str],
) -> Parameter:
    """A parameter that is none of the declared ones."""
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
        fresh_name(name[:_LONGEST_NAME], taken), str(unit), nominal=nominal, description=said
    )


def _factors(product: Product) -> str:
    powers, record = product
    factors = "*".join(f"{n}**{e}" if e > 1 else n for n, e in powers)
    return factors if record is None else f"{factors} (record {record + 1})"
