"""What is said of something that a model lacks."""

from collections.abc import Callable

import numpy as np

from axisid.modeling.declaration import Drive
from axisid.modeling.quantities import Coordinate

from .candidates import Kind
from .search import Lack

_DEAD_BAND: Kind = "dead band"


def term_sentence(lack: Lack, coordinate: Coordinate, drive: Drive) -> str:
    """Which term is missing, how large it is, and the element that declares it."""
    if lack.kind == _DEAD_BAND:
        what = _dead_band(lack, coordinate, drive)
    else:
        what = _SAID[lack.kind](lack, coordinate)
    return f"{what} ({100 * lack.share:.2g} % of the force is this)"


def change_sentence(lack: Lack, unit: str) -> str:
    """Which parameter changes, by how much and when."""
    by = f"{lack.values[0]:+.3g} +- {lack.deviations[0]:.1g} {unit}"
    share = f" ({100 * lack.values[0] / lack.before:+.2g} %)" if lack.before else ""
    if lack.kind == "drift":
        return (
            f"{lack.parameter} changes by {by}{share} over the record, little by little: record "
            "when the axis is warm, or identify parts of the record by themselves"
        )
    return (
        f"{lack.parameter} changes by {by}{share} at about {lack.at:.3g} s: identify what is "
        "before and after by itself, or find what was changed there"
    )


def is_named(lack: Lack) -> bool:
    """Whether it is a term with an element; a delay of the force has a check of its own."""
    return lack.kind in _SAID or lack.kind == _DEAD_BAND


def _dead_band(lack: Lack, q: Coordinate, drive: Drive) -> str:
    band = drive.deadband + lack.values[0] / abs(drive.gain)
    return (
        f"the drive makes {lack.values[0]:.3g} +- {lack.deviations[0]:.1g} {q.force_unit} "
        f"less force than its control says, whichever way it "
        f"pushes: declare its dead band, Drive(deadband={band:.2g}) in {drive.unit}"
    )


def _coulomb(lack: Lack, q: Coordinate) -> str:
    friction = _amount(lack, str(q.force_unit))
    return f"Coulomb friction of {friction} is missing: declare coulomb(Fc, {q.name})"


def _viscous(lack: Lack, q: Coordinate) -> str:
    friction = _amount(lack, f"{q.force_unit}/({q.unit}/s)")
    return f"viscous friction of {friction} is missing: declare viscous(Fv, {q.name})"


def _direction(lack: Lack, q: Coordinate) -> str:
    difference = _amount(lack, f"{q.force_unit}/({q.unit}/s)", factor=2.0)
    return (
        "viscous friction differs with the direction, forward less backward by "
        f"{difference}: declare asymmetric_viscous(Fvp, Fvm, {q.name}) in place of viscous"
    )


def _quadratic(lack: Lack, q: Coordinate) -> str:
    drag = _amount(lack, f"{q.force_unit}/({q.unit}/s)^2")
    return (
        f"friction bends over the speed, by {drag} times its square: declare quadratic(Fq, "
        f"{q.name}), or a peak of friction (stribeck) where it is slow motion that differs"
    )


def _stribeck(lack: Lack, q: Coordinate) -> str:
    size = f"{abs(lack.values[0]):.2g} {q.force_unit}"
    side = "higher" if lack.values[0] > 0 else "lower"
    return (
        f"friction depends on the speed, roughly {size} {side} than the model's at speeds of "
        f"about {lack.at:.1g} {q.unit}/s and less: declare stribeck(Fs, {q.name}, "
        f"velocity={lack.at:.1g}, exponent=1) beside coulomb"
    )


def _slope(lack: Lack, q: Coordinate) -> str:
    stiffness = _amount(lack, f"{q.force_unit}/{q.unit}")
    return f"a force of {stiffness} over the position is missing: declare spring(k, {q.name})"


def _bend(lack: Lack, q: Coordinate) -> str:
    bend = _amount(lack, f"{q.force_unit}/{q.unit}^2")
    return (
        f"a force that bends over the position, by {bend} times its square, is missing: declare "
        f"offset(kq*{q.name}**2)"
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
    return (
        f"friction depends on the position, rising by {slope}: declare coulomb(Fq*{q.name}, "
        f"{q.name}) beside what there is"
    )


def _friction_bend(lack: Lack, q: Coordinate) -> str:
    bend = _amount(lack, f"{q.force_unit}/{q.unit}^2")
    return (
        f"friction depends on the position, by {bend} times its square: declare "
        f"coulomb(Fq*{q.name}**2, {q.name}) beside what there is"
    )


def _friction_place(lack: Lack, q: Coordinate) -> str:
    return (
        f"friction depends on the position, by {_amplitude(lack)} {q.force_unit} every "
        f"{lack.at:.3g} {q.unit}: declare periodic_coulomb(a, b, {q.name}, period={lack.at:.3g})"
    )


def _amount(lack: Lack, unit: str, factor: float = 1.0) -> str:
    value, deviation = factor * lack.values[0], factor * lack.deviations[0]
    return f"{value:+.3g} +- {deviation:.1g} {unit}"


def _amplitude(lack: Lack) -> str:
    """Of cosine and sine together, with the deviation along it."""
    values, deviations = np.array(lack.values), np.array(lack.deviations)
    size = float(np.linalg.norm(values))
    return f"{size:.3g} +- {float(np.linalg.norm(values * deviations)) / size:.1g}"


_SAID: dict[Kind, Callable[[Lack, Coordinate], str]] = {
    "coulomb": _coulomb,
    "viscous": _viscous,
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
