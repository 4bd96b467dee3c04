"""A drive of two formulas: its force by control and motion, and the control by the force."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy

from axisid.modeling.declaration import DRIVE_GAIN, Drive, check_unit, unit_table
from axisid.modeling.quantities import (
    CONTROL,
    FORCE,
    ConstantSymbol,
    Coordinate,
    Signal,
    Symbolic,
    Unit,
    expression,
    parse_unit,
    with_numbers,
)
from axisid.support.errors import ModelError

from .figures import check_others


@dataclass(frozen=True, slots=True, kw_only=True)
class FormulaDrive(Drive):
    """A drive by its formulas; made by `formula_drive`.

    Attributes
    ----------
    made : expression
        The force, by `CONTROL`, the motion, recorded signals and `DRIVE_GAIN`.
    undone : expression
        The control, by `FORCE` and the same.
    """

    made: sympy.Expr
    undone: sympy.Expr

    @property
    def force(self) -> sympy.Expr:
        """Force by the control and the motion."""
        return with_numbers(self.made)

    @property
    def inverse(self) -> sympy.Expr:
        """Control by the force and the motion."""
        return with_numbers(self.undone)

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """The gain, where it stands in the formulas."""
        used = self.made.free_symbols | self.undone.free_symbols
        return {DRIVE_GAIN: self.gain} if DRIVE_GAIN in used else {}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse formulas in other units than the axis's force and the control's."""
        force, control = coordinate.force_unit, parse_unit(self.unit)
        units = unit_table(coordinate, signals)
        units |= {general: units[own] for general, own in self.along(coordinate).items()}
        units |= {CONTROL: control, FORCE: force, DRIVE_GAIN: force / control}
        for what, value, wanted in (
            ("force", self.made, force),
            ("inverse", self.undone, control),
        ):
            check_formula(value, what, units, wanted)


def formula_drive(
    force: sympy.Expr | Symbolic,
    inverse: sympy.Expr | Symbolic | None = None,
    *,
    unit: str = "V",
    gain: float = 1.0,
    **others: Any,
) -> Drive:
    """A drive by its force as an expression, and by the control that makes a force.

    Parameters
    ----------
    force : expression
        Of `CONTROL`, the coordinate and its velocity (or `POSITION` and `VELOCITY`), constants,
        recorded signals, and `DRIVE_GAIN` for the gain if it has one.
    inverse : expression, optional
        The control of which the drive makes `FORCE`, of the same. By default what follows from a
        force that is a straight line over the control. The two are compared by numbers when the
        axis is derived.
    unit : str
        Of the control.
    gain : float
        What `DRIVE_GAIN` is.
    **others
        Of `Drive`: limit, relative_sd (of the gain), lag, delay, logged, profile.

    Returns
    -------
    FormulaDrive
        A force that depends on the motion follows it between the samples of a sampled law.

    Raises
    ------
    ModelError
        There is no inverse, and none follows.
    """
    check_others("formula_drive", others)
    made = expression(force, "the drive's force")
    undone = _solved(made) if inverse is None else expression(inverse, "the drive's inverse")
    return FormulaDrive(made=made, undone=undone, unit=unit, gain=gain, **others)


def _solved(force: sympy.Expr) -> sympy.Expr:
    """The inverse of a force that is a straight line over the control.

    Raises
    ------
    ModelError
        It is none.
    """
    slope = force.diff(CONTROL)
    if slope == 0 or slope.has(CONTROL):
        raise ModelError(
            f"the drive's force {force} is no straight line over the control, so that its inverse "
            "does not follow; give it, the control by tau.",
            code="drive",
        )
    return (FORCE - force.xreplace({CONTROL: sympy.S.Zero})) / slope


def check_formula(
    value: sympy.Expr, what: str, units: Mapping[sympy.Symbol, Unit], wanted: Unit
) -> None:
    """Refuse a formula of a drive with a symbol that it cannot have, or in another unit.

    Raises
    ------
    ModelError
        It has one, or is.
    """
    if unknown := sorted(map(str, value.free_symbols - set(units) - value.atoms(ConstantSymbol))):
        raise ModelError(
            f"the drive's {what} has the symbols {', '.join(unknown)}, which are no control, "
            "motion, constant or declared signal; use those.",
            code="drive",
        )
    plain = not value.atoms(ConstantSymbol)  # of numbers alone any may stand for a unit
    try:
        check_unit(value, wanted, units, f"the drive's {what} {value}", of_numbers=plain)
    except ModelError as error:
        raise ModelError(str(error), code="drive") from error
