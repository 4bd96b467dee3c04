"""From the declared axis to its models: the whole derivation in one function."""

from dataclasses import dataclass

import sympy

from .axis import Axis
from .direct import DirectRegressor, direct_dynamics, direct_regressor, inertia_of
from .errors import ModelError
from .friction import with_direction
from .identifiability import Direction, hidden_directions
from .inverse import Regressor, inverse_regressor
from .parameter_map import ParameterMap, parameter_map
from .units import parse_unit


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisModel:
    """Everything derived from an axis, symbolically.

    Attributes
    ----------
    axis : Axis
        What was declared.
    force : sympy.Expr
        Inverse dynamics with the friction direction in place of ``sign(dq)``.
    inertia : sympy.Expr
        Coefficient of the acceleration.
    acceleration : sympy.Expr
        Direct dynamics.
    idm : Regressor
        Of the inverse model; one column per physical parameter.
    ddm : DirectRegressor or None
        Of the direct model; None where the acceleration is linear in no finite parameter set.
    ddm_refusal : str
        Why `ddm` is None, else empty.
    parameter_map : ParameterMap or None
        Between ``theta_ddm`` and the physical parameters.
    hidden : tuple of dict
        Changes of the physical parameters that no motion shows; empty if all are identifiable.
    """

    axis: Axis
    force: sympy.Expr
    inertia: sympy.Expr
    acceleration: sympy.Expr
    idm: Regressor
    ddm: DirectRegressor | None
    ddm_refusal: str
    parameter_map: ParameterMap | None
    hidden: tuple[Direction, ...]


def derive(axis: Axis) -> AxisModel:
    """Derive the inverse and direct models, their regressors and the map between them.

    Raises
    ------
    ModelError
        The equation of motion is not linear in the parameters or the acceleration, or jumps with
        the velocity in a way that is not friction.
    """
    q, symbols = axis.coordinate, tuple(p.symbol for p in axis.parameters)
    try:
        force = with_direction(axis.force, q.velocity)
        inertia = inertia_of(force, q.acceleration)
        if inertia == 0:
            raise ModelError("the acceleration cancels out of the force; an axis needs an inertia.")
        idm = inverse_regressor(force, symbols)
        silent = [str(p) for p, c in zip(symbols, idm.columns, strict=True) if c == 0]
        if silent:
            raise ModelError(f"{', '.join(silent)} has no effect: its terms cancel. Remove it.")
    except ModelError as error:
        raise ModelError(f"axis {axis.name!r}: {error}") from error
    except RecursionError as error:
        raise ModelError(
            f"axis {axis.name!r}: the equation of motion is nested too deeply; simplify it."
        ) from error
    ddm = direct_regressor(idm, symbols, inertia, q.acceleration)
    refusal = f"axis {axis.name!r} has no direct regressor: {ddm}" if isinstance(ddm, str) else ""
    direct = None if isinstance(ddm, str) else ddm
    return AxisModel(
        axis=axis,
        force=force,
        inertia=inertia,
        acceleration=direct_dynamics(force, inertia, q.acceleration),
        idm=idm,
        ddm=direct,
        ddm_refusal=refusal,
        parameter_map=None if direct is None else _map(axis, direct),
        hidden=hidden_directions(idm.columns, symbols),
    )


def _map(axis: Axis, ddm: DirectRegressor) -> ParameterMap:
    q = axis.coordinate
    return parameter_map(
        ddm,
        tuple(p.symbol for p in axis.parameters),
        {p.symbol: parse_unit(p.unit) for p in axis.parameters},
        q.acceleration_unit / q.force_unit,
    )
