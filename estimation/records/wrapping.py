"""Removal of jumps from columns whose numbers restart after a modulus, on request.

A position continues beyond the modulus, turn after turn. In other columns the jumps are a missing
sign: -1 is written as the modulus minus 1.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from axisid.estimation.raw_tables import Repair, Samples
from axisid.estimation.records.columns import RoleColumns, Scale
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.checks import refuse
from axisid.support.errors import DataError
from axisid.support.settings import setting

from .clocks import long_steps
from .shifts_and_interpolation import Rows

_MAX_WRAPPED_SPAN = 1.001  # largest range of a wrapped position with noise, in moduli

#: Example of a modulus: one turn.
_IN_DEGREES = 'wrap = "360:deg" in run.toml'


class Modulus(NamedTuple):
    """Modulus after which a position restarts.

    Attributes
    ----------
    si : float
        Modulus in SI.
    factor : float
        Factor to SI of the unit in which the modulus was given; without a unit, that of the numbers
        of the column.
    unit : str
        Unit in messages; empty if it is unknown.
    """

    si: float
    factor: float
    unit: str

    def __str__(self) -> str:
        return self.written(self.si)

    def written(self, size: float) -> str:
        """Return the text of a distance, given in SI, in the unit of the modulus."""
        return f"{size / self.factor:.6g} {self.unit}".rstrip()


def unwound(
    columns: RoleColumns, moduli: Mapping[str, Modulus], axis: Axis | None, gap: float
) -> tuple[RoleColumns, list[str]]:
    """Return columns without their jumps by moduli, and notes on remaining jumps.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times.
    moduli : mapping of str to Modulus
        Moduli by role.
    axis : Axis or None
        Axis, whose coordinate shows if it rotates; None if it is unknown.
    gap : float
        Longest time step that is not a gap, in median steps.

    Raises
    ------
    DataError
        A column is not wrapped by its modulus, or the position jumps by whole turns.
    """
    for role, modulus in moduli.items():
        if role not in columns.samples:
            raise DataError(
                f"{columns.source}: the modulus {modulus} is given for the {role}, but the log has "
                f"no column of the {role}. Give wrap for a column of the log "
                f"({', '.join(columns.samples)}), or omit wrap in run.toml.",
                code="wrap",
            )
        if role == "position":
            columns = _unwrapped(columns, modulus, gap)
        else:
            columns = _signed(columns, role, modulus)
    return columns, _remaining_jumps(columns, axis, gap, moduli.get("position"))


def _unwrapped(columns: RoleColumns, modulus: Modulus, gap: float) -> RoleColumns:
    """Return columns without the jumps of position and reference by whole moduli.

    If there were jumps, the reference begins on the turn of the position, unless it spans more than
    the modulus. Across a gap the number of turns is unknown: the position is assumed to move by
    less than half a modulus, and the reference begins again on the turn of the position. Without a
    jump nothing is changed. `gap` is the longest time step that is not a gap, in median steps.

    Raises
    ------
    DataError
        The position spans more than the modulus, or still jumps after unwrapping.
    """
    source, samples = columns.source, {**columns.samples}
    span = float(np.ptp(samples["position"].values))
    if span > _MAX_WRAPPED_SPAN * modulus.si:
        raise DataError(
            f"{source}: the position spans {modulus.written(span)}, more than the modulus "
            f"{modulus}, so it is not wrapped by this modulus. Give the modulus with its unit, or "
            "omit wrap in run.toml.",
            code="wrap",
        )
    gaps = long_steps(samples["position"].times, gap)
    # Subtract the jumps of each column, and count them by role.
    counts: dict[str, int] = {}
    own_turn = False
    for role in [role for role in ("position", "reference") if role in samples]:
        values = samples[role].values
        # A column that spans more than the modulus counts the turns itself. The position does not;
        # after the loop, `own_turn` is that of the reference.
        own_turn = float(np.ptp(values)) > _MAX_WRAPPED_SPAN * modulus.si
        turns = np.round(np.diff(values, prepend=values[0]) / modulus.si) * (not own_turn)
        values = values - modulus.si * np.cumsum(turns)
        counts[role] = int(np.count_nonzero(turns))
        if role == "position":  # a reference may step across the modulus
            _check_seams(source, values, np.flatnonzero(turns[1:]), gaps, modulus)
        samples[role] = replace(samples[role], values=values)
    # Shift the reference to the turn of the position. Without a jump neither column is known to be
    # wrapped, so nothing is shifted.
    pieces_moved = 0
    if "reference" in samples and any(counts.values()):
        samples["reference"], pieces_moved = _on_positions_turn(
            samples, modulus.si, gap, own_turn=own_turn
        )
    counted = ", ".join(f"{role} {count}" for role, count in counts.items())
    text = f"jumps by the modulus {modulus} are removed: {counted}"
    if len(gaps):
        across = "a gap" if len(gaps) == 1 else f"each of {len(gaps)} gaps"
        text += f"; across {across} the motion is assumed to be less than half the modulus"
    if pieces_moved:
        text += f"; pieces of the reference that are shifted by whole moduli: {pieces_moved}"
    return columns.repaired(
        samples, Repair(kind="wrap", count=sum(counts.values()) + pieces_moved, text=text)
    )


def _signed(columns: RoleColumns, role: str, modulus: Modulus) -> RoleColumns:
    """Return columns with the sign of one column restored.

    Numbers of half a modulus or more were written without their sign: the modulus is subtracted
    from these numbers.

    Raises
    ------
    DataError
        A number is larger than the modulus.
    """
    samples, scale = columns.samples[role], columns.scales.get(role, Scale())
    sign = math.copysign(1.0, scale.factor)
    written = sign * (samples.values - scale.offset)
    if float(np.abs(written).max()) > modulus.si:
        raise DataError(
            f"{columns.source}: the {role} reaches {modulus.written(np.abs(written).max())}, more "
            f"than the modulus {modulus}. Set wrap in run.toml to the modulus in the unit of the "
            "column or with its unit, or omit wrap.",
            code="wrap",
        )
    beyond = written >= modulus.si / 2
    values = np.where(beyond, samples.values - sign * modulus.si, samples.values)
    signed = replace(samples, values=values)
    count = int(np.count_nonzero(beyond))
    return columns.repaired(
        {role: signed},
        Repair(
            kind="wrap",
            count=count,
            text=f"{role}: {count} values of half the modulus {modulus} or more are read as "
            "negative",
        ),
    )


def _on_positions_turn(
    samples: Mapping[str, Samples], modulus: float, gap: float, *, own_turn: bool
) -> tuple[Samples, int]:
    """Return the reference shifted by whole moduli to the turn of the position.

    The second value is the number of shifted pieces. A piece begins at the start of the reference
    and after each gap.

    Parameters
    ----------
    samples : mapping of str to Samples
        Columns by role, with position and reference.
    modulus : float
        Modulus, SI.
    gap : float
        Longest time step that is not a gap, in median steps.
    own_turn : bool
        True if the reference counts the turns itself; its first piece is then not shifted.
    """
    # First samples of the pieces: after gaps of the position, and of the reference.
    position, reference = samples["position"], samples["reference"]
    clock, reference_clock = position.times, reference.times
    after = np.searchsorted(reference_clock, clock[long_steps(position.times, gap) + 1])
    starts = np.unique(np.concatenate([[0], after, long_steps(reference.times, gap) + 1]))
    starts = starts[starts < len(reference_clock)]
    # Turns by which each piece differs from the position at its first sample.
    nearest = np.minimum(np.searchsorted(clock, reference_clock[starts]), len(clock) - 1)
    turns = np.round((position.values[nearest] - reference.values[starts]) / modulus)
    if own_turn:
        turns[0] = 0.0
    stops = np.append(starts[1:], len(reference_clock))
    shifted = replace(
        reference, values=reference.values + modulus * np.repeat(turns, stops - starts)
    )
    return shifted, int(np.count_nonzero(turns))


def _check_seams(source: str, unwrapped: Array, places: Rows, gaps: Rows, modulus: Modulus) -> None:
    """Refuse a modulus with which the position still jumps where a jump was removed.

    The difference of a step from the mean of its two neighbours is compared: the position still
    jumps if the median difference at removed jumps exceeds five times the largest one elsewhere.

    Parameters
    ----------
    source : str
        Name of the log.
    unwrapped : (N,) array
        Position after unwrapping, SI.
    places, gaps : (k,) array of int
        Steps from which jumps were removed, and steps across gaps.
    modulus : Modulus
        Modulus by which the position was unwrapped.

    Raises
    ------
    DataError
    """
    # Differences of steps from the mean of their neighbours, without steps next to jumps or gaps.
    bends = np.abs(np.diff(unwrapped, 3)) / 2
    special = np.zeros(len(unwrapped) - 1, dtype=bool)
    special[places] = special[gaps] = True
    steady = ~(special[:-2] | special[2:])
    seams = np.setdiff1d(places, gaps)
    at_seams = bends[steady & np.isin(np.arange(1, len(special) - 1), seams)]
    elsewhere = bends[steady & ~special[1:-1]]
    jump = float(np.median(at_seams)) if len(at_seams) and len(elsewhere) else 0.0
    if jump > max(5 * float(elsewhere.max(initial=0.0)), 1e-4 * modulus.si):
        raise DataError(
            f"{source}: the position still jumps by {modulus.written(jump)} after unwrapping with "
            f"the modulus {modulus}, for instance before data row {seams[0] + 2}. Set the correct "
            f"modulus with its unit, as in {_IN_DEGREES}.",
            code="wrap",
        )


def _remaining_jumps(
    columns: RoleColumns, axis: Axis | None, gap: float, modulus: Modulus | None
) -> list[str]:
    """Return notes on jumps of a position: steps of over half its range during slow motion.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role; there are no notes without a position.
    axis : Axis or None
        Axis, whose coordinate shows if it rotates; None if it is unknown.
    gap : float
        Longest time step that is not a gap, in median steps.
    modulus : Modulus or None
        Modulus by which the position was unwrapped; None for none.

    Raises
    ------
    DataError
        The position jumps by whole turns, or by jumps that a given modulus does not remove.
    """
    position = columns.samples.get("position")
    if position is None:
        return []
    steps = np.abs(np.diff(position.values))
    steps[long_steps(position.times, gap)] = 0.0
    neighbours, middle = np.pad(steps, 1), np.median(steps) if len(steps) else 0.0
    slow = np.maximum(np.maximum(neighbours[:-2], neighbours[2:]), middle)
    places = np.flatnonzero((steps > 0.5 * np.ptp(position.values)) & (slow < 0.1 * steps))
    if not len(places):
        return []
    size = float(np.median(steps[places]))
    times = f" ({len(places)} such jumps)" if len(places) > 1 else ""
    unit = axis.coordinate.unit if axis is not None else "(m or rad)"
    jumps = f"the position jumps by {size:.4g} {unit} before data row {places[0] + 2}{times}"
    # A jump by one turn in rad, or in deg; it differs a little, as the axis moves on meanwhile.
    may_rotate = axis is None or axis.coordinate.unit == "rad"
    in_rad = may_rotate and abs(size / (2 * math.pi) - 1) < 0.05
    in_deg = may_rotate and abs(size / 360.0 - 1) < 0.05
    is_wrapped = "as if it restarted after each turn. The position is probably wrapped"
    refuse(
        DataError,
        (
            modulus is not None,
            f"which the modulus {modulus} does not remove. Set the correct modulus with its unit, "
            f"as in {_IN_DEGREES}",
        ),
        (in_rad, f"{is_wrapped}. Set {_IN_DEGREES}"),
        (
            in_deg,
            f"{is_wrapped}. Set {setting('columns', {'position': 'NAME:deg'})} and {_IN_DEGREES}",
        ),
        before=f"{columns.source}: {jumps}, ",
        code="wrap",
    )
    return [
        f"{jumps}. If the position restarts there, set wrap in run.toml to the modulus after which "
        "it restarts"
    ]
