"""Describe identifiability and the derived models with sentences and formulas."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import sympy
from sympy.utilities.iterables import connected_components

from axisid.modeling.declaration import known_text
from axisid.modeling.quantities import DIRECTION, FORCE, Formula, rounded
from axisid.support.missing import Missing
from axisid.support.wording import listed

from .base_model import BaseModel
from .direct import ParameterMap
from .friction_states import StateEquation
from .inverse import Regressor
from .model import AxisModel
from .null_space import NullSpaceVector, generic_points

_MOST_DIRECTIONS = 4


def undetermined_names(base: BaseModel) -> tuple[str, ...]:
    """Return the names of declared parameters that a record and known values do not determine."""
    undetermined = {s for direction in base.undetermined for s in direction}
    return tuple(p.name for p in base.declared.parameters if p.symbol in undetermined)


def describe_unidentifiable(base: BaseModel) -> tuple[str, ...]:
    """Return one sentence for each group of parameters that no motion can distinguish."""
    return tuple(
        f"{listed(names)} cannot be distinguished, because a record shows only "
        f"{_combinations(base, names)}: no motion shows a change of {_directions(directions)}"
        for names, directions in _groups(base, base.unidentifiable)
    )


def describe_undecided(base: BaseModel) -> tuple[str, ...]:
    """Return one sentence for each group of parameters that may have the same effect.

    For these parameters, neither a difference of their effects was found, nor a proof that the
    effects are equal.
    """
    found = []
    for group in base.undecided:
        *others, last = map(str, group)
        if others:
            found.append(
                f"No motion was found that distinguishes {last} and {listed(others)}, and no "
                "proof was found that there is no such motion. All these parameters are kept. "
                "Check their standard errors with `axisid identify`."
            )
        else:
            found.append(
                f"No effect of {last} was found, and no proof was found that {last} has no effect. "
                "The parameter is kept. Check its standard error with `axisid identify`."
            )
    return tuple(found)


def describe_undetermined(base: BaseModel) -> tuple[str, ...]:
    """Return one sentence for each group of parameters that a record does not determine.

    The sentence states which parameters of the group must be known so that the record determines
    the rest.
    """
    return tuple(
        f"{listed(names)} cannot be distinguished, because a record shows only "
        f"{_combinations(base, names)}: the rest follows if "
        f"{_to_be_known(base, names, directions)} known"
        for names, directions in _groups(base, base.undetermined)
    )


def describe_determined(base: BaseModel) -> str:
    """Return a clause that lists the declared parameters that a record determines.

    The clause also lists the known values. It is empty if a record, together with the known values,
    determines no declared parameter.
    """
    undetermined = undetermined_names(base)
    found = [p.name for p in base.declared.parameters if p.name not in undetermined]
    if not found:
        return ""
    known = [f"{p.name} = {known_text(p.known, p.known_sd)} {p.unit}" for p in base.known]
    condition = f", with {', '.join(known)} known" if known else ""
    follows = "follows" if len(found) == 1 else "follow"
    return f"{listed(found)} {follows} from a record{condition}"


def _groups(
    base: BaseModel, directions: Sequence[NullSpaceVector]
) -> list[tuple[list[str], list[NullSpaceVector]]]:
    """Return groups of unidentifiable directions, connected by common parameters.

    Each group comes with the names of its parameters, in their declared order.
    """
    indices = range(len(directions))
    sharing = [(i, j) for i, j in combinations(indices, 2) if {*directions[i]} & {*directions[j]}]
    components = connected_components((indices, sharing))
    groups = [[directions[i] for i in sorted(component)] for component in components]
    order = [p.symbol for p in base.declared.parameters]
    return [([str(s) for s in order if any(s in d for d in group)], group) for group in groups]


def _combinations(base: BaseModel, names: Iterable[str]) -> str:
    """Return the base parameters that contain any of the named parameters, as text."""
    wanted = set(names)
    return listed(
        [
            str(rounded(value))
            for value in base.expressions
            if wanted & {str(s) for s in value.free_symbols}
        ]
    )


def _directions(directions: Sequence[NullSpaceVector]) -> str:
    """Return unidentifiable directions as text, at most four of them, and the count of the rest."""
    texts = [describe_direction(d) for d in directions[:_MOST_DIRECTIONS]]
    more = len(directions) - len(texts)
    if more:
        texts.append(f"{more} more")
    text = " or ".join(texts)
    is_decimal = any(weight.is_Float for direction in directions for weight in direction.values())
    return f"{text} (at the nominal values)" if is_decimal else text


def _to_be_known(
    base: BaseModel, names: Sequence[str], directions: Sequence[NullSpaceVector]
) -> str:
    """Return a clause on which parameters of a group must be known to identify the rest.

    For one unidentifiable direction, any one parameter of the group is enough: "one of m, l is".
    For several directions, as many parameters must be known as there are directions, and the clause
    gives an example: "2 of these parameters, such as m and l, are".
    """
    if len(directions) == 1:
        return f"one of {', '.join(names)} is"
    example = listed([names[j] for j in _sufficient(base, names, directions)])
    return f"{len(directions)} of these parameters, such as {example}, are"


def _sufficient(
    base: BaseModel, names: Sequence[str], directions: Sequence[NullSpaceVector]
) -> tuple[int, ...]:
    """Return indices of parameters of a group that identify the rest if they are known.

    They are the pivot columns of the matrix of unidentifiable directions (one row for each
    direction, one column for each name). Numbers are used in place of the parameters, because
    reducing fractions of polynomials could take very long; almost every point gives the same
    pivots.
    """
    columns = [sympy.Symbol(name, real=True) for name in names]
    found: list[tuple[int, ...]] = []
    for point in generic_points(base.declared.parameters):
        weights = [[d.get(s, sympy.S.Zero).xreplace(point) for s in columns] for d in directions]
        found.append(sympy.Matrix(weights).rref()[1])
    return min(found, key=lambda pivots: (-len(pivots), pivots))


def describe_loss(direction: NullSpaceVector) -> str:
    """Return a clause on a change that no motion shows, and the combinations that a record shows.

    If the weights depend on the values of the parameters, only the parameters are named.
    """
    if any(weight.is_Float for weight in direction.values()):
        names = listed([*map(str, direction)])
        if len(direction) == 1:
            return f"no motion shows a change of {names} at the nominal values"
        return f"no motion distinguishes {names} at the nominal values"
    clause = f"no motion shows a change of {describe_direction(direction)}"
    if len(direction) == 1:
        return clause
    # With each other parameter, the first parameter has a combination that the change keeps.
    (pivot, size), *others = direction.items()
    identifiable = []
    for p, weight in others:
        ratio = -float(weight) / float(size)  # the value of p + ratio * pivot does not change
        first, second, factor = (p, pivot, ratio) if abs(ratio) > 1 else (pivot, p, 1 / ratio)
        scale = "" if abs(factor) == 1 else f"{abs(factor):.4g} "
        identifiable.append(f"{first} {'+' if factor > 0 else '-'} {scale}{second}")
    return f"{clause}; only {', '.join(identifiable)} can be identified"


def describe_direction(direction: NullSpaceVector) -> str:
    """Return a change that no motion shows as text: ``m +1, J -0.25`` or ``m +m, l -l``.

    The number or expression after each parameter is its weight in the change.
    """
    return ", ".join(f"{p} {_signed(weight)}" for p, weight in direction.items())


def _signed(weight: sympy.Expr) -> str:
    """Return a weight as text with its sign: ``+1``, ``-0.25``, ``+m``, ``-l``, ``+(a + b)``."""
    if weight.is_number:
        return f"{float(weight):+.4g}"
    text = str(rounded(weight))
    if weight.is_Add:
        return f"+({text})"
    return text if text.startswith("-") else f"+{text}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A titled block of formulas and sentences.

    Attributes
    ----------
    title : str
    lines : tuple of Formula or str
        Formulas, and sentences as text.
    note : str
        Explanation of the formulas; empty for none.
    """

    title: str
    lines: tuple[Formula | str, ...]
    note: str = ""


def derived_sections(model: AxisModel) -> tuple[Section, ...]:
    """Return the sections that describe an axis's models, in the order of display.

    Without internal states these are the base parameters if they differ from the declared ones, the
    inverse model and its regressor, the direct model with its regressor and parameter map, terms
    whose unit is not checked, and identifiability. With internal states there are no regressors.
    """
    inverse = Section(
        title="Inverse dynamic model",
        lines=(Formula(name=FORCE, value=model.force),),
        note=_conventions(model.force),
    )
    accelerated = Formula(name=model.axis.coordinate.acceleration, value=model.acceleration)
    forward = Section(title="Direct dynamic model", lines=(accelerated,))
    terms = model.axis.unchecked_terms
    unchecked = [Section(title="Units not checked", lines=terms)] if terms else []
    if model.states:
        states = Section(
            title="Internal states",
            lines=tuple(line for state in model.states for line in _of_state(state)),
            note="the rates of change of the internal states of friction; the states are not "
            "recorded, so there are no regressors and no least squares: fit the simulated loop",
        )
        return (inverse, states, forward, *unchecked)
    base = Section(
        title="Base parameters",
        lines=tuple(
            Formula(name=p.symbol, value=rounded(value), unit=p.unit)
            for p, value in model.base.combined
        ),
        note="the identifiable combinations of parameters; the force is linear in these "
        "combinations and in the other parameters",
    )
    columns = zip(model.axis.parameters, model.idm.columns, strict=True)
    if isinstance(model.ddm, Missing) or isinstance(model.parameter_map, Missing):
        direct = [Section(title="Direct regressor", lines=(f"none: {model.ddm}",))]
    else:
        direct = _direct_sections(model.ddm, model.parameter_map)
    return (
        *((base,) if model.base.changed else ()),
        inverse,
        Section(
            title="Inverse regressor",
            lines=(
                *(Formula(name=p.symbol, unit=p.unit, column=c) for p, c in columns),
                Formula(name="known", column=model.idm.intercept),
            ),
            note="the force is the sum of parameter times column, plus the known part",
        ),
        forward,
        *direct,
        *unchecked,
        Section(
            title="Identifiability",
            lines=(
                *describe_unidentifiable(model.base),
                *map(describe_loss, model.unidentifiable),
                *describe_undecided(model.base),
            )
            or ("all parameters are identifiable",),
        ),
    )


def _of_state(state: StateEquation) -> Iterator[Formula | str]:
    """Yield the formulas of an internal state: the rate, and the limit and the start if not 0."""
    yield Formula(name=sympy.Symbol(f"d{state.symbol}", real=True), value=state.rate)
    if state.limit is not None:
        yield Formula(name=sympy.Symbol(f"{state.symbol}_limit", real=True), value=state.limit)
        yield (
            f"{state.symbol} stays at plus or minus its limit while the motion drives "
            f"{state.symbol} further"
        )
    if not state.start.is_zero:
        yield Formula(name=sympy.Symbol(f"{state.symbol}_start", real=True), value=state.start)


def _conventions(force: sympy.Expr) -> str:
    """Return the meaning of ``direction`` and ``Heaviside`` if they occur in a force."""
    notes = (
        (
            DIRECTION in force.free_symbols,
            "direction is the sign of the velocity, and between -1 and 1 while the axis sticks",
        ),
        (
            force.has(sympy.Heaviside),
            "Heaviside(x), a step, is 0 for x < 0, 1 for x > 0 and 1/2 at 0",
        ),
    )
    return "; ".join(note for is_needed, note in notes if is_needed)


def _direct_sections(ddm: Regressor, mapping: ParameterMap) -> list[Section]:
    """Return the sections of the direct regressor and of the parameter map."""
    rows = zip(mapping.symbols, mapping.forward, mapping.units, ddm.columns, strict=True)
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
            lines=(*lines, Formula(name="known", column=ddm.intercept)),
            note="the acceleration is the sum of theta times column, plus the known part",
        ),
        Section(
            title=f"Parameter map, rank {len(mapping.parameters)}",
            lines=tuple(inverse),
            note="the physical parameters as functions of theta",
        ),
    ]
