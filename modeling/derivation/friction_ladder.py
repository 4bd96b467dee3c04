"""Friction ladder: variants of an axis with friction laws of increasing complexity.

The declared friction consists of the forces that depend only on the velocity, and of a constant
force. Each rung of the ladder is the axis with this friction replaced by the terms of one friction
law. The inertia, gravity, springs and all other terms that depend on the position or on a recorded
signal are the same on all rungs.
"""

import math
from collections.abc import Sequence, Set as AbstractSet
from dataclasses import replace

import sympy

from axisid.modeling.declaration import Axis, check_axis
from axisid.modeling.quantities import (
    Parameter,
    fresh_name,
    multiplied_out,
    number,
    reduced_rows,
    vanishes,
    where,
    with_numbers,
    without,
)
from axisid.support.errors import UsageError

from .base_model import Terms, force_terms
from .inverse import with_direction

_Term = tuple[Parameter, sympy.Expr]  # a parameter and its factor


def friction_ladder(
    axis: Axis, *, quadratic: bool = False, stribeck: float | None = None
) -> dict[str, Axis]:
    """Return the axis with each friction law by name, from the simplest to the most general law.

    The laws are ``viscous``; ``Coulomb``, which adds Coulomb friction; ``offset``, which adds a
    constant force; and ``directional``, in which viscous and Coulomb friction differ between
    directions. Each law contains the laws before it. If the declared friction can produce the same
    forces as a law, with the same or other parameters, the declared axis itself is that rung.
    Otherwise the declared axis comes last, as ``declared``.

    Parameters
    ----------
    axis : Axis
        Its friction parameters keep their names and known values. If a parameter is split by
        direction, both new parameters get its nominal value, but no known value. A Coulomb level
        that is split also loses its bounds, because each of the two levels contains the constant
        force.
    quadratic : bool
        Whether a further rung adds ``Fq dq |dq|`` to the directional law.
    stribeck : float, optional
        Stribeck velocity v, in the coordinate's unit per second, of a further rung that adds
        ``Fs exp(-(dq/v)^2) sign(dq)`` to the directional law. A positive Fs is the Stribeck peak, a
        negative Fs a dip. None for no such rung.

    Raises
    ------
    UsageError
        The object is not an axis, or the Stribeck velocity is not positive.
    """
    check_axis(axis)
    if stribeck is not None and not 0 < number(stribeck, "the Stribeck velocity") < math.inf:
        raise UsageError(
            f"the Stribeck velocity is {stribeck!r}. Give a positive number.",
            code="axis",
        )
    # Split each term of the force into friction and a part that stays on every rung.
    parameters = _friction_parameters(axis)
    rests = [(term, _rest(term, parameters)) for term in sympy.Add.make_args(axis.force)]
    kept = [rest for _, rest in rests if rest != 0]
    friction = [term - rest for term, rest in rests if rest != term]
    # The declared axis takes the place of the rung with the same forces.
    laws = _laws(axis, kept, friction, quadratic=quadratic, stribeck=stribeck)
    ladder = {
        law: axis if _is_law(axis, friction, terms) else _rung(axis, kept, law, terms)
        for law, terms in laws.items()
    }
    if not any(rung is axis for rung in ladder.values()):
        ladder["declared"] = axis
    return ladder


def _friction_parameters(axis: Axis) -> AbstractSet[sympy.Symbol]:
    """Return the parameters that occur only in constant forces and forces of the velocity alone.

    A parameter that also occurs in another term (a mass in a constant weight) is excluded. The
    search excludes each parameter if the derivative of the force with respect to it contains the
    position, the acceleration, a recorded signal or an excluded parameter. It is repeated until no
    further parameter is excluded.
    """
    q = axis.coordinate
    slopes = {p.symbol: axis.force.diff(p.symbol) for p in axis.parameters}
    others = frozenset(slopes)
    beyond: AbstractSet[sympy.Symbol] = {q.symbol, q.acceleration, *axis.signal_symbols}
    while beyond:
        slopes = {p: slope for p, slope in slopes.items() if without(slope, beyond) is not None}
        others, beyond = frozenset(slopes), others - frozenset(slopes)
    return others


def _rest(term: sympy.Expr, parameters: AbstractSet[sympy.Symbol]) -> sympy.Expr:
    """Return the part of a term of the force that contains none of the given parameters.

    The term is expanded only if replacing the parameters that enter linearly by 0 is not enough.
    """
    linear = {p for p in term.free_symbols & parameters if vanishes(term.diff(p, 2))}
    rest = where(term, linear)
    if rest is None or rest.free_symbols & parameters:
        rest = multiplied_out(term if rest is None else rest, powers=False)
        return sympy.Add(
            *(part for part in sympy.Add.make_args(rest) if not part.free_symbols & parameters)
        )
    return rest


def _laws(
    axis: Axis,
    kept: list[sympy.Expr],
    friction: list[sympy.Expr],
    *,
    quadratic: bool,
    stribeck: float | None,
) -> dict[str, list[_Term]]:
    """Return the friction terms of each rung by the name of its law.

    Each term is a parameter and its factor. If the axis declares a parameter with the same factor,
    this parameter is used; otherwise a new parameter is declared.

    Parameters
    ----------
    axis : Axis
    kept : list of sympy.Expr
        Terms of the force that stay on every rung.
    friction : list of sympy.Expr
        Terms of the declared friction.
    quadratic : bool
        Whether there is a rung with quadratic friction.
    stribeck : float or None
        Stribeck velocity of a further rung; None for no such rung.
    """
    q = axis.coordinate
    taken = axis.taken_names | {str(s).lower() for term in kept for s in term.free_symbols}
    speed, sign = q.velocity, sympy.sign(q.velocity)
    force, rate = str(q.force_unit), f"{q.unit}/s"
    ahead, back = (1 + sign) / 2, (1 - sign) / 2

    def term(name: str, unit: str, factor: sympy.Expr) -> _Term:
        """Return a factor with the axis's parameter for it, or with a new parameter."""
        declared = _declared(axis, friction, factor)
        return declared or Parameter(fresh_name(name, taken), unit), factor

    basic = [
        term("Fv", f"{force}/({rate})", speed),
        term("Fc", force, sign),
        term("F0", force, sympy.S.One),
    ]
    (viscous, _), (coulomb, _), _ = basic
    # A level of one direction contains the constant force, and may have either sign.
    level = replace(coulomb, lower=-math.inf, upper=math.inf)
    directional = [
        (_declared(axis, friction, factor) or _one_way(undirected, suffix, taken), factor)
        for undirected, suffix, factor in (
            (viscous, "p", speed * ahead),
            (viscous, "m", speed * back),
            (level, "p", ahead),
            (level, "m", -back),
        )
    ]
    laws = {
        "viscous": basic[:1],
        "Coulomb": basic[:2],
        "offset": basic,
        "directional": directional,
    }
    if quadratic:
        laws["quadratic"] = [
            *directional,
            term("Fq", f"{force}/({rate})^2", speed * sympy.Abs(speed)),
        ]
    if stribeck is not None:
        laws["Stribeck"] = [
            *directional,
            term("Fs", force, sign * sympy.exp(-((speed / stribeck) ** 2))),
        ]
    return laws


def _is_law(axis: Axis, friction: list[sympy.Expr], law: list[_Term]) -> bool:
    """Return whether the declared friction can produce exactly the forces that a law can produce.

    The declared friction and the law are expanded in the same functions of the motion. They produce
    the same forces if their matrices of weights have the same rank, separately and together.

    Parameters
    ----------
    axis : Axis
    friction : list of sympy.Expr
        Terms of the declared friction.
    law : list of (Parameter, sympy.Expr)
        Parameters of the law with their factors.
    """
    # Expand the sum of both, with a new symbol for each parameter of the law.
    used = {s for term in friction for s in term.free_symbols}
    symbols = [p.symbol for p in axis.parameters if p.symbol in used]
    amounts = sympy.symbols(f"law:{len(law)}", real=True, cls=sympy.Dummy)
    terms = (amount * factor for amount, (_, factor) in zip(amounts, law, strict=True))
    both = _terms(axis, sympy.Add(*friction, *terms), (*symbols, *amounts))
    if both.nonlinear or any(sum(exponents) > 1 for exponents in both.monomials):
        return False
    # The ranks of the columns of the declared friction, of the law, and of all columns.
    is_declared = [any(exponents[: len(symbols)]) for exponents in both.monomials]
    of_declared = [j for j, declared in enumerate(is_declared) if declared]
    of_law = [j for j, declared in enumerate(is_declared) if not declared]
    ranks = {
        len(reduced_rows([[row[j] for j in columns] for row in both.rows])[1])
        for columns in (of_declared, of_law, range(len(is_declared)))
    }
    return len(ranks) == 1


def _terms(axis: Axis, force: sympy.Expr, symbols: Sequence[sympy.Symbol]) -> Terms:
    """Return a force as combinations of the symbols that multiply its functions of the motion.

    The result does not depend on the form in which the force is written.
    """
    velocity = axis.coordinate.velocity
    return force_terms(with_direction(with_numbers(force), velocity), velocity, symbols)


def _rung(axis: Axis, kept: list[sympy.Expr], law: str, terms: list[_Term]) -> Axis:
    """Return the axis with the kept terms of its force and the friction terms of a law.

    Parameters
    ----------
    axis : Axis
    kept : list of sympy.Expr
        Terms of the force that stay on every rung.
    law : str
        Name of the law, for the name and the title of the axis.
    terms : list of (Parameter, sympy.Expr)
        Friction parameters with their factors.
    """
    used = {s for term in kept for s in term.free_symbols}
    stay = [p for p in axis.parameters if p.symbol in used]
    return replace(
        axis,
        name=f"{axis.name[: 30 - len(law)]}_{law}",
        title=f"{axis.title or axis.name}, friction law {law}",
        parameters=(*stay, *(p for p, _ in terms)),
        force=sum([*kept, *(p * factor for p, factor in terms)], sympy.S.Zero),
        experiment=None,
    )


def _declared(axis: Axis, friction: list[sympy.Expr], factor: sympy.Expr) -> Parameter | None:
    """Return the declared parameter whose friction force is the parameter times a factor.

    It is None if no parameter has exactly this force.
    """
    symbols = {p.symbol for p in axis.parameters}
    for p in axis.parameters:
        own = [term - _rest(term, {p.symbol}) for term in friction if p.symbol in term.free_symbols]
        rest = sympy.Add(*own, -p * factor)
        if own and not _terms(axis, rest, tuple(rest.free_symbols & symbols)).monomials:
            return p
    return None


def _one_way(parameter: Parameter, suffix: str, taken: set[str]) -> Parameter:
    """Return the parameter for one direction: ``Fvp`` for positive velocity, ``Fvm`` for negative.

    It has the nominal value and bounds of the undirected parameter, but no known value, because the
    known value of the undirected parameter is a mean of both directions.

    Parameters
    ----------
    parameter : Parameter
        The undirected parameter.
    suffix : str
        ``p`` or ``m``, appended to the name.
    taken : set of str
        Names in use, in lower case; the new name is added.
    """
    name = fresh_name(f"{parameter.name}{suffix}", taken)
    return replace(parameter, name=name, known=None, known_sd=0.0)
