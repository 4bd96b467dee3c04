"""The direct dynamic model: acceleration from force, and its regressor where there is one.

With constant inertia ``I = a . theta`` the acceleration ``(tau - h) / I`` is linear in
``1/I`` and the quotients ``p/I``. One parameter of the inertia, the *pivot*, is expressed by the
others, since ``a . theta / I = 1`` leaves one quotient too many. A known part of the inertia moves
to the first column.
"""

from dataclasses import dataclass

import sympy

from .errors import ModelError
from .inverse import Regressor
from .symbols import FORCE


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectRegressor:
    """``ddq = regressor.columns . theta_ddm + regressor.known``, for constant inertia.

    Attributes
    ----------
    regressor : Regressor
        The row; its first column multiplies ``1/I``.
    inertia : sympy.Expr
        ``I``, affine in the parameters.
    pivot : sympy.Symbol or None
        The parameter of the inertia that has no quotient of its own; None for a known inertia.
    quotients : tuple of sympy.Symbol
        The parameters p whose ``p/I`` follow ``1/I`` in ``theta_ddm``; under a known inertia they
        are ``theta_ddm`` themselves.
    """

    regressor: Regressor
    inertia: sympy.Expr
    pivot: sympy.Symbol | None
    quotients: tuple[sympy.Symbol, ...]


def inertia_of(force: sympy.Expr, acceleration: sympy.Symbol) -> sympy.Expr:
    """Coefficient of the acceleration in the inverse dynamics.

    Raises
    ------
    ModelError
        The force is not linear in the acceleration.
    """
    inertia = sympy.expand_mul(sympy.expand_mul(force).diff(acceleration))
    if acceleration in inertia.free_symbols:
        raise ModelError(
            f"the force is not linear in the acceleration {acceleration}: its derivative is "
            f"{inertia}. A mechanical axis has one inertia times one acceleration."
        )
    return inertia


def direct_dynamics(
    force: sympy.Expr, inertia: sympy.Expr, acceleration: sympy.Symbol
) -> sympy.Expr:
    """Acceleration from force: ``(tau - rest) / inertia``."""
    return (FORCE - force.subs(acceleration, 0)) / inertia


def direct_regressor(
    idm: Regressor,
    parameters: tuple[sympy.Symbol, ...],
    inertia: sympy.Expr,
    acceleration: sympy.Symbol,
) -> DirectRegressor | str:
    """Derive the direct model's regressor, or say why there is none.

    References
    ----------
    Equation (2) of [Brunot2015]_, generalised.
    """
    scales = {
        p: column.diff(acceleration) for p, column in zip(parameters, idm.columns, strict=True)
    }
    scales = {p: scale for p, scale in scales.items() if scale != 0}
    moving = inertia.free_symbols - set(parameters)
    if idm.nonlinear:
        names = ", ".join(map(str, idm.nonlinear))
        return f"its friction or load is not linear in {names}; use idm-ls or idm-iv"
    if moving:
        return (
            f"its inertia {inertia} depends on {', '.join(sorted(map(str, moving)))}, so the "
            "acceleration is not linear in any finite set of parameters; use idm-ls or idm-iv"
        )
    if not scales:
        return _under_known_inertia(idm, parameters, inertia, acceleration)
    rest = {p: c.subs(acceleration, 0) for p, c in zip(parameters, idm.columns, strict=True)}
    pivot = next((p for p in scales if rest[p] == 0), next(iter(scales)))
    share = rest[pivot] / scales[pivot]
    columns = {
        p: sympy.expand_mul(scales.get(p, sympy.S.Zero) * share - rest[p])
        for p in parameters
        if p != pivot
    }
    columns = {p: column for p, column in columns.items() if column != 0}
    first = FORCE - idm.known.subs(acceleration, 0) + share * idm.known.diff(acceleration)
    return DirectRegressor(
        regressor=Regressor(
            columns=(sympy.expand_mul(first), *columns.values()), known=sympy.expand_mul(-share)
        ),
        inertia=inertia,
        pivot=pivot,
        quotients=tuple(columns),
    )


def _under_known_inertia(
    idm: Regressor,
    parameters: tuple[sympy.Symbol, ...],
    inertia: sympy.Expr,
    acceleration: sympy.Symbol,
) -> DirectRegressor:
    """``ddq = (tau - known)/I - sum of columns p/I``: linear in the parameters as they are."""
    rest = idm.known.subs(acceleration, 0)
    return DirectRegressor(
        regressor=Regressor(
            columns=tuple(sympy.expand_mul(-column / inertia) for column in idm.columns),
            known=sympy.expand_mul((FORCE - rest) / inertia),
        ),
        inertia=inertia,
        pivot=None,
        quotients=parameters,
    )
