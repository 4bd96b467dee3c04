"""The direct dynamic model: acceleration from force, its regressor and its parameter map.

With constant inertia ``I = a . theta`` the acceleration ``(tau - h) / I`` is linear in ``1/I`` and
the quotients ``p/I``. By ``a . theta / I = 1`` there is one quotient too many: one parameter of the
inertia, the *pivot*, is therefore expressed by the other parameters. A known part of the inertia is
included in the first column.

The paper inverts the map ``theta_ddm = [1/I, p/I, ...]`` by hand and gives no standard errors for
the result. Here the map, its inverse and both Jacobians, which the delta method needs, are derived.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from axisid.modeling.quantities import (
    DIRECTION,
    FORCE,
    Coordinate,
    Unit,
    intercept,
    multiplied_out,
    vanishes,
    without,
)
from axisid.support.errors import ModelError
from axisid.support.missing import Missing

from .inverse import Regressor


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterMap:
    """The map between the physical parameters and those of the direct model, ``theta_ddm``.

    Dimensions: p physical parameters, m direct-model parameters.

    Attributes
    ----------
    parameters : tuple of sympy.Symbol
        Physical parameters, length p.
    symbols : tuple of sympy.Symbol
        ``theta1 ... thetam``, the parameters of the direct model.
    forward : sympy.Matrix, (m, 1)
        ``theta_ddm`` as functions of the physical parameters.
    forward_jacobian : sympy.Matrix, (m, p)
    inverse : sympy.Matrix, (p, 1)
        The physical parameters as functions of ``theta_ddm``.
    inverse_jacobian : sympy.Matrix, (p, m)
    units : tuple of Unit
        Units of ``theta_ddm``, length m.
    """

    parameters: tuple[sympy.Symbol, ...]
    symbols: tuple[sympy.Symbol, ...]
    forward: sympy.ImmutableMatrix
    forward_jacobian: sympy.ImmutableMatrix
    inverse: sympy.ImmutableMatrix
    inverse_jacobian: sympy.ImmutableMatrix
    units: tuple[Unit, ...]


def inertia_of(force: sympy.Expr, coordinate: Coordinate) -> sympy.Expr:
    """Return the coefficient of the acceleration in the inverse dynamics.

    If it does not depend on the position, the velocity or the friction direction, it is written
    without this symbol.

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
            f"derivative is {multiplied_out(found, powers=False)}. Write the force as one inertia "
            "times the acceleration, plus terms without the acceleration."
        )
    for motion in (coordinate.symbol, coordinate.velocity, DIRECTION):
        constant = without(inertia, {motion})
        inertia = inertia if constant is None else constant
    return inertia


def direct_dynamics(balance: sympy.Expr, profile: sympy.Expr, coordinate: Coordinate) -> sympy.Expr:
    """Return the acceleration as a function of the force: ``(profile tau - rest) / inertia``.

    Parameters
    ----------
    balance : sympy.Expr
        The force that the motion needs, equal to ``profile tau``, with the friction direction in
        place of ``sign(dq)``.
    profile : sympy.Expr
        Force of the drive divided by its nominal value, a function of the position.
    coordinate : Coordinate
    """
    rest = balance.xreplace({coordinate.acceleration: sympy.S.Zero})
    return (profile * FORCE - rest) / inertia_of(balance, coordinate)


def direct_model(
    idm: Regressor,
    units: Mapping[sympy.Symbol, Unit],
    inertia: sympy.Expr,
    coordinate: Coordinate,
) -> tuple[Regressor, ParameterMap] | Missing:
    """Return the direct model's regressor and parameter map; Missing if there is none.

    ``ddq = columns . theta_ddm + intercept``, for constant inertia ``I``. The first column
    multiplies ``1/I``. The other columns multiply the quotients ``p/I`` of all parameters except
    one parameter of the inertia, the *pivot*, which follows from the others. If the inertia
    contains no parameter, ``theta_ddm`` are the physical parameters themselves.

    Parameters
    ----------
    idm : Regressor
        Regressor of the inverse model.
    units : mapping of sympy.Symbol to Unit
        Units of the physical parameters, in the axis's order; the parameters are distinguishable.
    inertia : sympy.Expr
        ``I``.
    coordinate : Coordinate

    Returns
    -------
    (Regressor, ParameterMap) or Missing
        Missing, with the reason, if a parameter enters nonlinearly, or the inertia depends on the
        motion.

    References
    ----------
    Equation (2) of [Brunot2015]_, generalised.
    """
    parameters = tuple(units)
    moving = inertia.free_symbols - set(parameters)
    if idm.nonlinear:
        names = ", ".join(map(str, idm.nonlinear))
        return Missing(f"its friction or load is not linear in {names}. Use IDM-LS or IDM-IV")
    if moving:
        return Missing(
            f"its inertia {inertia} depends on {', '.join(sorted(map(str, moving)))}, so the "
            "acceleration is not linear in any finite set of parameters. Use IDM-LS or IDM-IV"
        )
    free, scales = _shares(inertia, parameters)
    still = {coordinate.acceleration: sympy.S.Zero}
    # The inverse model without the acceleration: known part and columns.
    known, *columns = (part.xreplace(still) for part in (idm.intercept, *idm.columns))
    symbols = tuple(sympy.Symbol(f"theta{i + 1}", real=True) for i in range(len(parameters)))
    if not scales:
        regressor = Regressor(
            columns=tuple(-column / free for column in columns), intercept=(FORCE - known) / free
        )
        forward, inverse = sympy.Matrix(parameters), sympy.ImmutableMatrix(symbols)
        map_units = tuple(units.values())
    else:
        # Eliminate the pivot: preferably a parameter of the inertia with no other effect.
        rest = dict(zip(parameters, columns, strict=True))
        pivot = next((p for p in scales if vanishes(rest[p])), next(iter(scales)))
        share = rest[pivot] / scales[pivot]
        quotients = {
            p: scales.get(p, sympy.S.Zero) * share - rest[p] for p in parameters if p != pivot
        }
        first = FORCE - known + share * free
        regressor = Regressor(columns=(first, *quotients.values()), intercept=-share)
        whole = sympy.Add(free, *(p * scale for p, scale in scales.items()))
        forward = sympy.Matrix([1 / whole, *(p / whole for p in quotients)])
        # The inverse map: I = 1/theta1, p = thetaj/theta1, and the pivot from I = a . theta.
        over, slope = 1 / symbols[0], whole.diff(pivot)
        values = {p: t * over for p, t in zip(quotients, symbols[1:], strict=True)}
        shared = (whole - pivot * slope).subs(values, simultaneous=True)
        values[pivot] = sympy.factor((over - shared) / slope)
        inverse = sympy.ImmutableMatrix([values[p] for p in parameters])
        of_one = coordinate.acceleration_unit / coordinate.force_unit
        map_units = (of_one, *(units[p] * of_one for p in quotients))
    return regressor, ParameterMap(
        parameters=parameters,
        symbols=symbols,
        forward=forward.as_immutable(),
        forward_jacobian=forward.jacobian(parameters).applyfunc(sympy.together).as_immutable(),
        inverse=inverse,
        inverse_jacobian=inverse.jacobian(symbols).as_immutable(),
        units=map_units,
    )


def _shares(
    inertia: sympy.Expr, parameters: tuple[sympy.Symbol, ...]
) -> tuple[sympy.Expr, dict[sympy.Symbol, sympy.Expr]]:
    """Return the part of an inertia without parameters, and its derivatives by the parameters.

    The inertia is affine in the parameters. Derivatives that are 0 are omitted.

    Raises
    ------
    ModelError
        The part without parameters has no finite value.
    """
    unknown = frozenset(parameters)
    slopes = {p: without(inertia.diff(p), unknown) for p in parameters}
    found = {p: slope for p, slope in slopes.items() if slope is not None and slope != 0}
    free = intercept(inertia, found)
    if free is None:
        raise ModelError(
            f"the inertia {inertia} has no finite value. Write the inertia in another form."
        )
    return free, found
