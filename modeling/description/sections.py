"""What was derived from an axis, section by section, for every way to write it down."""

from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from axisid.modeling.derivation import (
    AxisModel,
    BaseModel,
    DirectRegressor,
    ParameterMap,
    StateEquation,
)
from axisid.modeling.quantities import DIRECTION, FORCE, Formula, rounded
from axisid.support.errors import Missing

from .identifiability import describe_direction, describe_unidentifiable


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A title over formulas and sentences; the note says what the formulas are."""

    title: str
    lines: tuple[Formula | str, ...]
    note: str = ""


def derived_sections(model: AxisModel) -> tuple[Section, ...]:
    """Base parameters if others were declared, both models, the map, what is identifiable."""
    if model.states:
        return _remembering_sections(model)
    columns = zip(model.axis.parameters, model.idm.columns, strict=True)
    if isinstance(model.ddm, Missing) or isinstance(model.parameter_map, Missing):
        direct = [Section(title="Direct regressor", lines=(f"none: {model.ddm}",))]
    else:
        direct = _direct_sections(model.ddm, model.parameter_map)
    return (
        *_base_sections(model.base),
        _inverse(model),
        Section(
            title="Inverse regressor",
            lines=(
                *(Formula(name=p.symbol, unit=p.unit, column=c) for p, c in columns),
                Formula(name="known", column=model.idm.intercept),
            ),
            note="the force is the sum of parameter times column, and known",
        ),
        _direct(model),
        *direct,
        *_unchecked(model),
        Section(
            title="Identifiability",
            lines=(
                *describe_unidentifiable(model.base),
                *(
                    f"no motion shows a change of {describe_direction(h)}"
                    for h in model.unidentifiable
                ),
            )
            or ("every parameter has an effect of its own",),
        ),
    )


def _inverse(model: AxisModel) -> Section:
    return Section(
        title="Inverse dynamic model",
        lines=(Formula(name=FORCE, value=model.force),),
        note=_conventions(model.force),
    )


def _direct(model: AxisModel) -> Section:
    acceleration = model.axis.coordinate.acceleration
    return Section(
        title="Direct dynamic model",
        lines=(Formula(name=acceleration, value=model.acceleration),),
    )


def _remembering_sections(model: AxisModel) -> tuple[Section, ...]:
    """The models with internal states, the states' equations, and why there are no rows."""
    return (
        _inverse(model),
        Section(
            title="Internal states",
            lines=tuple(line for state in model.states for line in _of_state(state)),
            note="what friction remembers, by its rate of change; no record has it, so that there "
            "are no regressors and no least squares: fit the simulated loop",
        ),
        _direct(model),
        *_unchecked(model),
    )


def _of_state(state: StateEquation) -> Iterator[Formula | str]:
    yield Formula(name=sympy.Symbol(f"d{state.symbol}", real=True), value=state.rate)
    if state.limit is not None:
        limit = Formula(name=sympy.Symbol(f"{state.symbol}_limit", real=True), value=state.limit)
        yield limit
        yield f"{state.symbol} stays at its limit, on either side, while the motion drives it on"
    if not state.start.is_zero:
        yield Formula(name=sympy.Symbol(f"{state.symbol}_start", real=True), value=state.start)


def _conventions(force: sympy.Expr) -> str:
    """What the names in a force mean that no declaration explains."""
    notes = []
    if DIRECTION in force.free_symbols:
        notes.append(
            "direction is the sign of the velocity; between -1 and 1 while the axis sticks"
        )
    if force.has(sympy.Heaviside):
        notes.append("Heaviside(x), a step, is 0 for x < 0, 1 for x > 0 and 1/2 at 0")
    return "; ".join(notes)


def _base_sections(base: BaseModel) -> list[Section]:
    if not base.changed:
        return []
    lines = tuple(
        Formula(name=p.symbol, value=rounded(value), unit=p.unit) for p, value in base.combined
    )
    return [
        Section(
            title="Base parameters",
            lines=lines,
            note="what a record identifies: the force is linear in these and the other parameters",
        )
    ]


def _unchecked(model: AxisModel) -> tuple[Section, ...]:
    terms = model.axis.unchecked_terms
    return (Section(title="Units not checked", lines=terms),) if terms else ()


def _direct_sections(ddm: DirectRegressor, mapping: ParameterMap) -> list[Section]:
    rows = zip(mapping.symbols, mapping.forward, mapping.units, ddm.regressor.columns, strict=True)
    lines = [
        Formula(name=symbol, value=value, unit=str(unit), column=column)
        for symbol, value, unit, column in rows
    ]
    inverse = (
        Formula(name=p, value=value)
        for p, value in zip(mapping.parameters, mapping.inverse, strict=True)
    )
    return [
        Section(
            title="Direct regressor",
            lines=(*lines, Formula(name="known", column=ddm.regressor.intercept)),
            note="the acceleration is the sum of theta times column, and known",
        ),
        Section(
            title=f"Parameter map, rank {len(mapping.parameters)}",
            lines=tuple(inverse),
            note="theta back to the physical parameters",
        ),
    ]
