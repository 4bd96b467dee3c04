"""The direct dynamic model: acceleration from force, its regressor and the map of its parameters.

With constant inertia ``I = a . theta`` the acceleration ``(tau - h) / I`` is linear in
``1/I`` and the quotients ``p/I``. One parameter of the inertia, the *pivot*, is expressed by the
others, since ``a . theta / I = 1`` leaves one quotient too many. A known part of the inertia moves
to the first column.

The paper inverts the map ``theta_ddm = [1/I, p/I, ...]`` by hand and gives no deviations for the
result; here the map, its inverse and both Jacobians are derived, as the delta method needs them.
"""

from dataclasses import dataclass

import sympy

from axisid.modeling.algebra import intercept, multiplied_out, vanishes, without
from axisid.modeling.quantities import DIRECTION, FORCE, Coordinate, Unit
from axisid.support.errors import Missing, ModelError

from .inverse import Regressor


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectRegressor:
    """``ddq = regressor.columns . theta_ddm + regressor.intercept``, for constant inertia.

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


def inertia_of(force: sympy.Expr, coordinate: Coordinate) -> sympy.Expr:
    """Coefficient of the acceleration in the inverse dynamics.

    Raises
    ------
    ModelError
        The force is not linear in the acceleration.
    """
    found = force.diff(coordinate.acceleration)
    inertia = without(found, {coordinate.acceleration})
    if inertia is None:
        raise ModelError(
            f"the force is not linear in the acceleration {coordinate.acceleration}: its "
            f"derivative is {multiplied_out(found, powers=False)}. A mechanical axis has one "
            "inertia times one acceleration."
        )
    for motion in (coordinate.symbol, coordinate.velocity, DIRECTION):
        constant = without(inertia, {motion})
        inertia = inertia if constant is None else constant
    return inertia


def direct_dynamics(balance: sympy.Expr, profile: sympy.Expr, coordinate: Coordinate) -> sympy.Expr:
    """Acceleration from force: ``(profile tau - rest) / inertia``.

    Parameters
    ----------
    balance : sympy.Expr
        What ``profile tau`` is spent on, by the friction direction.
    profile : sympy.Expr
        The drive's.
    coordinate : Coordinate
    """
    rest = balance.xreplace({coordinate.acceleration: sympy.S.Zero})
    return (profile * FORCE - rest) / inertia_of(balance, coordinate)


def direct_regressor(
    idm: Regressor,
    parameters: tuple[sympy.Symbol, ...],
    inertia: sympy.Expr,
    acceleration: sympy.Symbol,
) -> DirectRegressor | Missing:
    """Derive the direct model's regressor, or say why there is none.

    References
    ----------
    Equation (2) of [Brunot2015]_, generalised.
    """
    moving = inertia.free_symbols - set(parameters)
    if idm.nonlinear:
        names = ", ".join(map(str, idm.nonlinear))
        return Missing(f"its friction or load is not linear in {names}; use idm-ls or idm-iv")
    if moving:
        return Missing(
            f"its inertia {inertia} depends on {', '.join(sorted(map(str, moving)))}, so the "
            "acceleration is not linear in any finite set of parameters; use idm-ls or idm-iv"
        )
    free, scales = _shares(inertia, parameters)
    still = idm.at_rest(acceleration)
    if not scales:
        # ddq = (tau - intercept)/I - sum of columns p/I: linear in the parameters as they are.
        return DirectRegressor(
            regressor=Regressor(
                columns=tuple(-column / free for column in still.columns),
                intercept=(FORCE - still.intercept) / free,
            ),
            inertia=free,
            pivot=None,
            quotients=parameters,
        )
    rest = dict(zip(parameters, still.columns, strict=True))
    pivot = next((p for p in scales if vanishes(rest[p])), next(iter(scales)))
    share = rest[pivot] / scales[pivot]
    columns = {p: scales.get(p, sympy.S.Zero) * share - rest[p] for p in parameters if p != pivot}
    first = FORCE - still.intercept + share * free
    return DirectRegressor(
        regressor=Regressor(columns=(first, *columns.values()), intercept=-share),
        inertia=sympy.Add(free, *(p * scale for p, scale in scales.items())),
        pivot=pivot,
        quotients=tuple(columns),
    )


def _shares(
    inertia: sympy.Expr, parameters: tuple[sympy.Symbol, ...]
) -> tuple[sympy.Expr, dict[sympy.Symbol, sympy.Expr]]:
    """Part of an affine inertia without parameters, and what multiplies each of them in it."""
    unknown = frozenset(parameters)
    slopes = {p: without(inertia.diff(p), unknown) for p in parameters}
    found = {p: slope for p, slope in slopes.items() if slope is not None and slope != 0}
    free = intercept(inertia, found)
    if free is None:
        raise ModelError(f"the inertia {inertia} has no finite value; write it in another form.")
    return free, found


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterMap:
    """``theta_ddm`` from the physical parameters, and back.

    Attributes
    ----------
    parameters : tuple of sympy.Symbol
        Physical, length p.
    symbols : tuple of sympy.Symbol
        ``theta1 ... thetam``, the direct model's.
    forward : sympy.Matrix, (m, 1)
        ``theta_ddm`` of the parameters.
    forward_jacobian : sympy.Matrix, (m, p)
    inverse : sympy.Matrix, (p, 1)
        The parameters of ``theta_ddm``.
    inverse_jacobian : sympy.Matrix, (p, m)
    units : tuple of Unit
        Of ``theta_ddm``.
    """

    parameters: tuple[sympy.Symbol, ...]
    symbols: tuple[sympy.Symbol, ...]
    forward: sympy.ImmutableMatrix
    forward_jacobian: sympy.ImmutableMatrix
    inverse: sympy.ImmutableMatrix
    inverse_jacobian: sympy.ImmutableMatrix
    units: tuple[Unit, ...]


def parameter_map(
    ddm: DirectRegressor,
    parameters: tuple[sympy.Symbol, ...],
    units: dict[sympy.Symbol, Unit],
    inverse_inertia_unit: Unit,
) -> ParameterMap:
    """Derive the map of a direct regressor in parameters that can be told apart.

    Parameters
    ----------
    ddm : DirectRegressor
    parameters : tuple of sympy.Symbol
        Physical parameters in the axis's order.
    units : dict
        Their units.
    inverse_inertia_unit : Unit
        Of ``1/I``: acceleration over force.
    """
    if ddm.pivot is None:
        forward = sympy.Matrix(ddm.quotients)
    else:
        forward = sympy.Matrix([1 / ddm.inertia, *(p / ddm.inertia for p in ddm.quotients)])
    symbols = tuple(sympy.Symbol(f"theta{i + 1}", real=True) for i in range(len(forward)))
    jacobian = forward.jacobian(parameters).applyfunc(sympy.together)
    inverse = _inverse(ddm, parameters, symbols)
    return ParameterMap(
        parameters=parameters,
        symbols=symbols,
        forward=forward.as_immutable(),
        forward_jacobian=jacobian.as_immutable(),
        inverse=inverse,
        inverse_jacobian=inverse.jacobian(symbols).as_immutable(),
        units=tuple(units.values())
        if ddm.pivot is None
        else (inverse_inertia_unit, *(units[p] * inverse_inertia_unit for p in ddm.quotients)),
    )


def _inverse(
    ddm: DirectRegressor,
    parameters: tuple[sympy.Symbol, ...],
    symbols: tuple[sympy.Symbol, ...],
) -> sympy.ImmutableMatrix:
    """``I = 1/theta1``, ``p = thetaj/theta1``, and the pivot from the inertia's definition."""
    if ddm.pivot is None:
        return sympy.ImmutableMatrix(symbols)
    inertia = 1 / symbols[0]
    values = {p: t * inertia for p, t in zip(ddm.quotients, symbols[1:], strict=True)}
    shared = (ddm.inertia - ddm.pivot * ddm.inertia.diff(ddm.pivot)).subs(values, simultaneous=True)
    values[ddm.pivot] = sympy.factor((inertia - shared) / ddm.inertia.diff(ddm.pivot))
    return sympy.ImmutableMatrix([values[p] for p in parameters])
