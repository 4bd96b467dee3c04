"""A position that is recorded from another zero than the reference, beside a law.

To the law it is a tracking error that does not change: a control of so many volts where the law is
of gains alone, a ramp where it integrates. The first is what a constant error of the recorded
control is too, so that both are told.
"""

from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.thresholds import MAX_SCALE_ERROR
from axisid.modeling.declaration import ControlLaw
from axisid.support.remedy import Note, Remedy, Setting

from .terms import compared_with_law

_STEP = 1e-3  # of the reference's range


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionZero:
    """How far the recorded position is from where the law read it.

    Attributes
    ----------
    away : float
        By how much the recorded position is more than the one beside the reference, SI.
    control : float or None
        The constant control that does the same; None for a law that integrates.
    """

    away: float
    control: float | None


def position_zero(axis: GeneratedAxis, law: ControlLaw, record: Record) -> PositionZero | None:
    """The zero of the position that explains most of what a law leaves; None where it does nothing.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Of the axis.
    record : Record
        Of one piece, with a reference and a control.
    """
    reference = np.asarray(record.reference)
    step = _STEP * float(np.ptp(reference)) or _STEP
    control, terms, used = compared_with_law(axis, law, record)
    moved = replace(record, position=record.position + step)
    _, otherwise, _ = compared_with_law(axis, law, moved)
    answer = ((otherwise - terms).sum(axis=1) / step)[used]
    left = (control - terms.sum(axis=1))[used]
    power, mean = float(answer @ answer), float(np.mean(answer))
    if not (np.isfinite(power) and power > 0):
        return None
    away = -float(answer @ left) / power
    is_constant = float(np.ptp(answer)) <= MAX_SCALE_ERROR.value * abs(mean)
    return PositionZero(away=away, control=-mean * away if is_constant else None)


def zero_note(axis: GeneratedAxis, record: Record, found: PositionZero) -> Note:
    """What such a record is, and what puts it right; it goes on after what the law leaves."""
    unit, drive = axis.axis.coordinate.unit, axis.axis.drive
    name = record.provenance.columns.get("position", "NAME")
    said = (
        f"it is with the position {found.away:+.3g} {unit} away from its zero beside the reference "
        "(a constant tracking error of as much)"
    )
    back = Setting("columns", f"position={name}:UNIT{-found.away:+.3g}{unit}")
    if found.control is None:
        return Note(f"{said}: ", Remedy.of("take that off (", back, ")"))
    beyond = abs(found.control) > drive.limit
    if beyond:
        return Note(
            f"{said}, which the law makes {found.control:.3g} {drive.unit} of, more than the drive "
            "gives: ",
            Remedy.of("take that off the position (", back, ")"),
        )
    return Note(
        f"{said}, or with a constant of {found.control:.3g} {drive.unit} off the control, which "
        "the law makes of it: a constant force that the model does not explain, or an offset that "
        "should be nothing, would say that it is the control's; ",
        Remedy.of(
            "take the one off the position (",
            back,
            "), or check the control's offset, or an integral of the drive that the law does not "
            "declare",
        ),
    )
