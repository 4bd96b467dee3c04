"""A measured velocity against the position's derivative, an acceleration against the velocity's.

Both say the same of the axis, whatever its model: a factor between them is a unit or a scale, a
delay the drive's filter or the logger's, a constant the zero of a tachometer.
"""

from collections.abc import Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.records import Record, advised_between, advised_shift, samples_apart
from axisid.estimation.thresholds import MAX_SCALE_ERROR, MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .column_comparison import (
    MAX_COLUMN_DELAY,
    MAX_COLUMN_OFFSET,
    ColumnComparison,
    LowPassed,
    scale_remedy,
)


def compared_motion(
    record: Record, role: str, velocities: Sequence[Array] = ()
) -> ColumnComparison | Missing:
    """Hold a measured velocity or acceleration against the derivative of what was measured before.

    A velocity without a position is held against that of the simulated loop, where there is one:
    it follows the recorded reference, whatever its parameters are but for a little, and has the
    scale and the zero of the motion.

    Parameters
    ----------
    record : Record
        With that column.
    role : {"velocity", "acceleration"}
    velocities : sequence of (N,) array
        Of the loop, by segment.

    Returns
    -------
    ColumnComparison or Missing
        Missing where there is no such derivative, or the record is too short or still to tell.
    """
    longest = record.longest()
    by_position = role == "velocity" or record.velocity is None
    basis = longest.position if by_position else np.asarray(longest.velocity)
    times = 2 if role == "acceleration" and by_position else 1
    if by_position and record.integrated:
        if role != "velocity" or not velocities:
            return Missing(
                f"no position was recorded that the {role} could be held against, and no loop can "
                f"be simulated: the scale of the motion rests on the column of the {role} alone"
            )
        basis, times = max(velocities, key=len), 0
    columns = LowPassed.of(longest, basis, np.asarray(getattr(longest, role)), times)
    return columns if isinstance(columns, Missing) else ColumnComparison.of(columns)


def compared_motions(
    record: Record, velocities: Sequence[Array] = ()
) -> dict[str, ColumnComparison | Missing]:
    """`compared_motion` of each of the two that was measured."""
    roles = (role for role in record.motion if role != "position")
    return {role: compared_motion(record, role, velocities) for role in roles}


def motion_check(
    axis: GeneratedAxis, record: Record, role: str, found: ColumnComparison | Missing | None
) -> Check | Missing | None:
    """What was found of a measured velocity or acceleration; nothing without the column."""
    if found is None or isinstance(found, Missing):
        return found
    against, way = _derivative(record, role), "late" if found.delay >= 0 else "early"
    told = (
        f"{found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} times, "
        f"{abs(found.delay):.2f} +- {max(found.delay_deviation, 1e-2):.1g} samples {way} and "
        f"{found.offset:+.3g} +- {found.offset_deviation:.1g} {_unit(axis, role)}"
    )
    meaning, remedy = f"the measured {role} is {against} ({told})", None
    if found.distances["left"] > 1:
        meaning = (
            f"the measured {role} is not {against}: {found.left_percent:.3g} % are left whatever "
            f"factor, delay and constant ({told}): "
        )
        remedy = Remedy.of("check the column (", Setting("columns", f"{role}=NAME:UNIT"), ")")
    elif found.worst > 1:
        meaning = f"the measured {role} is {told} beside {against}: "
        remedy = _remedy(axis, record, found, role)
    return Check(
        name=f"measured {role}",
        status=passed(found.worst <= 1),
        figure=found.worst if np.isfinite(found.worst) else None,
        threshold=1.0,
        source="largest of the factor's distance from 1 by "
        f"{MAX_SCALE_ERROR.value:g}, the delay by {MAX_COLUMN_DELAY:g} samples and "
        f"the constant by {100 * MAX_COLUMN_OFFSET:g} % of the {role}, or by three of their "
        "deviations where these are more",
        meaning=meaning,
        remedy=remedy,
    )


def _derivative(record: Record, role: str) -> str:
    if role == "velocity" and record.integrated:
        return "that of the simulated loop, which follows the reference"
    if role == "velocity":
        return "the position's derivative"
    return (
        "the position's second derivative"
        if record.velocity is None
        else ("the measured velocity's derivative")
    )


def _unit(axis: GeneratedAxis, role: str) -> str:
    q = axis.axis.coordinate
    return str(q.velocity_unit if role == "velocity" else q.acceleration_unit)


def _remedy(axis: GeneratedAxis, record: Record, found: ColumnComparison, role: str) -> Remedy:
    """What sets right what is wrong."""
    parts, far = list[Remedy | str](), found.distances
    name = record.provenance.columns.get(role, "NAME")
    if far["delay"] > 1:
        parts.append(
            Remedy.of("draw it between its values (", advised_between(role), ")")
            if samples_apart(getattr(record, role)) > 1
            else advised_shift(role, found.delay, MAX_COLUMN_DELAY)
        )
    if far["factor"] > 1:
        beside = "reference" if role == "velocity" and record.integrated else "position"
        vague = MIN_DISTANCE_FROM_NOISE.value * found.factor_deviation / abs(found.factor)
        vague += MAX_SCALE_ERROR.value
        known = scale_remedy(role, name, _unit(axis, role), found.factor, vague)
        of_sign = Setting("columns", f"{role}={name}:UNIT*-1")
        if known is None and abs(found.factor + 1) <= vague:
            known = Remedy.of("turn its sign (", of_sign, ")")
        column = Setting("columns", f"{role}={name}:UNIT")
        said = f"check its unit and scale, and those of the {beside} ("
        parts.append(known or Remedy.of(said, column, ")"))
    if far["offset"] > 1:
        zero = Setting("columns", f"{role}={name}:UNIT{-found.offset:+.3g}{_unit(axis, role)}")
        parts.append(Remedy.of("take off its zero (", zero, ")"))
    between = [each for part in parts for each in (", and ", part)]
    return Remedy.of(*between[1:])
