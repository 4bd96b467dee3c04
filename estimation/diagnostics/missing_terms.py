"""Whether a named term is missing in the model, as a check."""

from collections.abc import Callable, Sequence

import numpy as np

from axisid.estimation.thresholds.diagnostics import NEGLIGIBLE_FORCE
from axisid.modeling.quantities import Coordinate
from axisid.support.missing import Missing

from .candidates import Kind
from .check import Check, passed
from .lacking import Lack

_NAME = "missing terms"
SOURCE = (
    "percent of the force, root mean square; fails where Wald's test tells it from zero among all "
    "that is looked for (a false-discovery rate of 0.1 %, Benjamini-Yekutieli), the score test at "
    "1 % too, and it takes 5 % or more of the residuals' power"
)


def missing_terms(found: Sequence[Lack] | Missing, coordinate: Coordinate) -> Check | Missing:
    """Whether the residuals hold a term that an element could declare.

    A delay of the force and what changes in time have checks of their own.
    """
    if isinstance(found, Missing):
        return found
    terms = [lack for lack in found if lack.kind in _SAID]
    return Check(
        name=_NAME,
        status=passed(not terms),
        figure=100 * max((lack.share for lack in terms), default=0.0),
        threshold=100 * NEGLIGIBLE_FORCE.value,
        p_value=min((lack.p_value for lack in terms), default=None),
        source=SOURCE,
        meaning="; ".join(said(lack, coordinate) for lack in terms)
        or "no named term of friction, drag or position stands out of the residuals",
    )


def said(lack: Lack, coordinate: Coordinate) -> str:
    """What is missing, how large it is, and the element that declares it."""
    what = _SAID[lack.kind](lack, coordinate)
    return f"{what} ({100 * lack.share:.2g} % of the force is this)"


def _direction(lack: Lack, q: Coordinate) -> str:
    difference = _amount(lack, f"{q.force_unit}/({q.unit}/s)", factor=2.0)
    return (
        "viscous friction differs with the direction, forward less backward by "
        f"{difference}: declare asymmetric_viscous(Fvp, Fvm, {q.name})"
    )


def _quadratic(lack: Lack, q: Coordinate) -> str:
    drag = _amount(lack, f"{q.force_unit}/({q.unit}/s)^2")
    return f"a drag of {drag} times the speed squared is missing: declare quadratic(Fq, {q.name})"


def _stribeck(lack: Lack, q: Coordinate) -> str:
    size = f"{abs(lack.values[0]):.2g} {q.force_unit}"
    side = "higher" if lack.values[0] > 0 else "lower"
    return (
        f"friction depends on the speed, roughly {size} {side} than the model's below about "
        f"{lack.at:.1g} {q.unit}/s: declare stribeck(Fs, {q.name}, velocity={lack.at:.1g}) beside "
        "coulomb"
    )


def _slope(lack: Lack, q: Coordinate) -> str:
    stiffness = _amount(lack, f"{q.force_unit}/{q.unit}")
    return f"a force of {stiffness} over the position is missing: declare spring(k, {q.name})"


def _bend(lack: Lack, q: Coordinate) -> str:
    bend = _amount(lack, f"{q.force_unit}/{q.unit}^2")
    return (
        f"a force that bends over the position, by {bend} times its square, is missing: declare "
        f"it as an expression of {q.name}"
    )


def _turn(lack: Lack, q: Coordinate) -> str:
    return (
        f"a moment over a turn of the position, of {_amplitude(lack)} {q.force_unit}, is missing: "
        f"declare gravity_moment(a, b, {q.name})"
    )


def _place(lack: Lack, q: Coordinate) -> str:
    return (
        f"a force over the position, of {_amplitude(lack)} {q.force_unit} every {lack.at:.3g} "
        f"{q.unit}, is missing: declare cogging(a, b, {q.name}, period={lack.at:.3g})"
    )


def _friction_slope(lack: Lack, q: Coordinate) -> str:
    slope = _amount(lack, f"{q.force_unit}/{q.unit}")
    return f"friction depends on the position, rising by {slope}: {_over_position(q)}"


def _friction_bend(lack: Lack, q: Coordinate) -> str:
    bend = _amount(lack, f"{q.force_unit}/{q.unit}^2")
    return f"friction depends on the position, by {bend} times its square: {_over_position(q)}"


def _friction_place(lack: Lack, q: Coordinate) -> str:
    return (
        f"friction depends on the position, by {_amplitude(lack)} {q.force_unit} every "
        f"{lack.at:.3g} {q.unit}: declare periodic_coulomb(a, b, {q.name}, period={lack.at:.3g})"
    )


def _over_position(q: Coordinate) -> str:
    return f"declare an expression of {q.name} times its direction of motion, or periodic_coulomb"


def _amount(lack: Lack, unit: str, factor: float = 1.0) -> str:
    value, deviation = factor * lack.values[0], factor * lack.deviations[0]
    return f"{value:+.3g} +- {deviation:.1g} {unit}"


def _amplitude(lack: Lack) -> str:
    """Of cosine and sine together, with the deviation along it."""
    size = float(np.hypot(*lack.values))
    parts = zip(lack.values, lack.deviations, strict=True)
    return f"{size:.3g} +- {float(np.hypot(*(v * d for v, d in parts))) / size:.1g}"


_SAID: dict[Kind, Callable[[Lack, Coordinate], str]] = {
    "direction": _direction,
    "quadratic": _quadratic,
    "stribeck": _stribeck,
    "slope": _slope,
    "bend": _bend,
    "turn": _turn,
    "place": _place,
    "friction slope": _friction_slope,
    "friction bend": _friction_bend,
    "friction place": _friction_place,
}
