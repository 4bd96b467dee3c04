"""Derive the models of a declared axis."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy

from axisid.modeling.declaration import Axis, check_axis
from axisid.modeling.quantities import parse_unit, vanishes, with_numbers, with_own_symbols
from axisid.support.errors import ModelError
from axisid.support.missing import Missing

from .base_model import BaseModel, base_model, declared_as_base
from .direct import (
    ParameterMap,
    direct_dynamics,
    direct_model,
    inertia_of,
)
from .force_guard import check_force, differing_points
from .friction_states import StateEquation, in_direction, state_equations
from .inverse import Regressor, inverse_regressor, with_direction
from .null_space import NullSpaceVector, unidentifiable_directions

_MOST_TRIES = 4  # derivations of base parameters that merge parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisModel:
    """The symbolic models derived from an axis.

    Attributes
    ----------
    base : BaseModel
        The declared axis, and its base parameters.
    axis : Axis
        The axis in its base parameters. These are the declared parameters if the declared
        parameters are distinguishable and enter linearly.
    force : sympy.Expr
        Inverse dynamics, divided by the profile of the drive, with the friction direction in place
        of ``sign(dq)``.
    inertia : sympy.Expr
        Coefficient of the acceleration in `force`.
    acceleration : sympy.Expr
        Direct dynamics.
    idm : Regressor
        Regressor of the inverse model; one column per parameter.
    ddm : Regressor or Missing
        Regressor of the direct model; Missing, with the reason, if the acceleration is not linear
        in a finite set of parameters.
    parameter_map : ParameterMap or Missing
        Map between ``theta_ddm`` and the parameters; Missing if `ddm` is.
    unidentifiable : tuple of dict
        Changes of the parameters of a partially linear axis that no motion shows; for a linear axis
        these are in `base`.
    states : tuple of StateEquation
        Internal states of friction; empty for none. With states, the models contain the symbols of
        the states, and the columns of the inverse regressor are the derivatives of the force with
        respect to the parameters at fixed states.
    """

    base: BaseModel
    axis: Axis
    force: sympy.Expr
    inertia: sympy.Expr
    acceleration: sympy.Expr
    idm: Regressor
    ddm: Regressor | Missing
    parameter_map: ParameterMap | Missing
    unidentifiable: tuple[NullSpaceVector, ...]
    states: tuple[StateEquation, ...] = ()

    def at_start(self, value: sympy.Expr) -> sympy.Expr:
        """Return an expression of the models with each internal state at its start value."""
        return value.xreplace({state.symbol: state.start for state in self.states})


def derive(axis: Axis) -> AxisModel:
    """Derive the inverse and direct models, their regressors and the map between them.

    If parameters enter as products, or are not distinguishable, the models are in base parameters.
    The steps are in `_derived`.

    Raises
    ------
    UsageError
        The object is not an axis.
    ModelError
        The equation of motion is not linear in the parameters or the acceleration, or jumps with
        the velocity in a way that is not friction.
    """
    check_axis(axis)
    states = state_equations(axis)
    try:
        return _derived(axis, states)
    except ModelError as error:
        raise ModelError(f"axis {axis.name!r}: {error}", code="equation") from error
    except RecursionError as error:
        raise ModelError(
            f"axis {axis.name!r}: the equation of motion is nested too deeply. Simplify "
            "the equation."
        ) from error


def _derived(declared: Axis, states: tuple[StateEquation, ...]) -> AxisModel:
    """Return the models of an axis.

    Without internal states the models are in base parameters, with internal states in the declared
    parameters. The steps are the force balance, the base parameters, the inertia, the inverse
    regressor and the direct model.
    """
    balance = _balance(declared)
    if states:
        base = declared_as_base(declared)
    else:
        base, balance = _checked_base(declared, balance)
    axis = base.axis
    q, symbols = axis.coordinate, tuple(p.symbol for p in axis.parameters)
    if states:
        balance = in_direction(with_own_symbols(balance), q.velocity)
    profile = with_numbers(axis.drive.profile)
    force = balance / profile
    inertia = inertia_of(force, q)
    idm = inverse_regressor(force, symbols, held=symbols if states else ())
    units = {p.symbol: parse_unit(p.unit) for p in axis.parameters}
    names = ", ".join(str(state.symbol) for state in states)
    ddm: Regressor | Missing
    mapping: ParameterMap | Missing
    direct: tuple[Regressor, ParameterMap] | Missing
    if states:
        direct = Missing(f"its friction has internal states ({names}), which are not recorded")
    else:
        direct = direct_model(idm, units, inertia, q)
    if isinstance(direct, Missing):
        ddm = mapping = Missing(f"axis {axis.name!r} has no direct regressor: {direct}")
    else:
        ddm, mapping = direct
    return AxisModel(
        base=base,
        axis=axis,
        force=force,
        inertia=inertia,
        acceleration=direct_dynamics(balance, profile, q),
        idm=idm,
        ddm=ddm,
        parameter_map=mapping,
        unidentifiable=() if states else unidentifiable_directions(idm, axis.parameters, q),
        states=states,
    )


def _checked_base(declared: Axis, balance: sympy.Expr) -> tuple[BaseModel, sympy.Expr]:
    """Return base parameters whose force equals the declared force, and the force in them.

    Points at which the two forces differ show that parameters were merged wrongly, and are used in
    the next derivation of base parameters. If there are still such points after four derivations,
    no parameters are merged.

    Parameters
    ----------
    declared : Axis
    balance : sympy.Expr
        The declared force with the friction direction in place of ``sign(dq)``.

    Raises
    ------
    ModelError
        The forces differ although no parameters are merged.
    """
    differing: list[Mapping[sympy.Symbol, Any]] = []
    for _ in range(_MOST_TRIES):
        base = base_model(declared, balance, differing)
        if not base.changed:
            return base, balance
        reduced = _balance(base.axis)
        found = differing_points(base, balance, reduced)
        if not found:
            return base, reduced
        differing += found
    base = base_model(declared, balance, differing, merged=False)
    if not base.changed:
        return base, balance
    reduced = _balance(base.axis)
    check_force(base, balance, reduced)
    return base, reduced


def _balance(axis: Axis) -> sympy.Expr:
    """Return the declared force with the friction direction in place of ``sign(dq)``.

    Raises
    ------
    ModelError
        The acceleration cancels out of the force.
    """
    q = axis.coordinate
    force = with_direction(with_numbers(axis.force), q.velocity)
    if vanishes(inertia_of(force, q)):
        raise ModelError(
            "the acceleration cancels out of the force. Add an inertia times the acceleration."
        )
    return force
