"""The nonlinear map between the direct model's parameters and the physical ones.

``theta_ddm = [1/I, p/I, ...]``. The paper inverts it by hand and gives no deviations for the
result; here the map, its inverse and both Jacobians are derived, as the delta method needs them.
"""

from dataclasses import dataclass

import sympy

from axisid.modeling.quantities import Unit

from .direct import DirectRegressor


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
