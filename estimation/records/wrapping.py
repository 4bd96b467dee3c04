"""Numbers that restart after a modulus: their jumps are removed on request.

A position continues over the modulus, turn after turn. Other columns lost their sign: -1 is written
as the modulus minus 1.
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

_MAX_WRAPPED_SPAN = 1.001  # moduli that a wrapped position spans, with noise

#: Example of a modulus: one turn.
_IN_DEGREES = 'wrap = "360:deg" in run.toml'


class Modulus(NamedTuple):
    """Modulus after which a position restarts.

    Attributes
    ----------
    si : float
        Modulus in SI.
    factor : float
        Factor to SI of the unit in which it was given, or of the column's own numbers.
    unit : str
        Unit in messages.
    """

    si: float
    factor: float
    unit: str

    def __str__(self) -> str:
        return self.written(self.si)

    def written(self, size: float) -> str:
        """Return a distance, given in SI, in the unit of the modulus."""
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
        Longest time step that is no gap, in median steps.

    Raises
    ------
    DataError
        A column is not wrapped by its modulus, or the position jumps by whole turns.
    """
    for role, modulus in moduli.items():
        if role not in columns.samples:
            raise DataError(
                f"{columns.source}: the modulus {modulus} is given for the {role}, but there is no "
                f"such column. Name a column that is read ({', '.join(columns.samples)}), or omit "
                "wrap in run.toml.",
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
    jump nothing is changed. `gap` is the longest time step that is no gap, in median steps.
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
    gaps, counts, own_turn, pieces_moved = long_steps(samples["position"].times, gap), {}, False, 0
    for role in [role for role in ("position", "reference") if role in samples]:
        values = samples[role].values
        # A column that spans more than the modulus counts the turns itself.
        own_turn = float(np.ptp(values)) > _MAX_WRAPPED_SPAN * modulus.si
        turns = np.round(np.diff(values, prepend=values[0]) / modulus.si) * (not own_turn)
        values, counts[role] = values - modulus.si * np.cumsum(turns), int(np.count_nonzero(turns))
        if role == "position":  # a reference may step across the modulus
            _check_seams(source, values, np.flatnonzero(turns[1:]), gaps, modulus)
        samples[role] = replace(samples[role], values=values)
    # Without a jump neither column is known to be wrapped, and no turn is wrong.
    if "reference" in samples and any(counts.values()):
        samples["reference"], pieces_moved = _on_positions_turn(
            samples, modulus.si, gap, own_turn=own_turn
        )
    counted = ", ".join(f"{role} {count}" for role, count in counts.items())
    text = f"jumps by the modulus {modulus} removed: {counted}"
    if len(gaps):
        across = "a gap" if len(gaps) == 1 else f"each of {len(gaps)} gaps"
        text += f"; across {across} the motion is assumed to be less than half the modulus"
    text += f"; pieces of the reference shifted by whole moduli: {pieces_moved}" * bool(
        pieces_moved
    )
    return columns.repaired(
        samples, Repair(kind="wrap", count=sum(counts.values()) + pieces_moved, text=text)
    )


def _signed(columns: RoleColumns, role: str, modulus: Modulus) -> RoleColumns:
    """Return columns with values of half a modulus and more in one column read as negative.

    Such numbers were written without their sign.
    """
    samples, scale = columns.samples[role], columns.scales.get(role, Scale())
    sign = math.copysign(1.0, scale.factor)
    written = sign * (samples.values - scale.offset)
    if float(np.abs(written).max()) > modulus.si:
        raise DataError(
            f"{columns.source}: the {role} reaches {modulus.written(np.abs(written).max())}, more "
            f"than the modulus {modulus}. Give the modulus in the unit of the column, or with its "
            "unit, or omit wrap in run.toml.",
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
            text=f"{role}: {count} values of half the modulus {modulus} and more read as negative",
        ),
    )


def _on_positions_turn(
    samples: Mapping[str, Samples], modulus: float, gap: float, *, own_turn: bool
) -> tuple[Samples, int]:
    """Return the reference shifted by whole moduli to the turn of the position.

    The second value is the number of shifted pieces between gaps. The reference is shifted at its
    start and after each gap. At its start it is not shifted if it counts the turns itself
    (`own_turn`). `modulus` is in SI, `gap` in median time steps.
    """
    position, reference = samples["position"], samples["reference"]
    clock, reference_clock = position.times, reference.times
    after = np.searchsorted(reference_clock, clock[long_steps(position.times, gap) + 1])
    starts = np.unique(np.concatenate([[0], after, long_steps(reference.times, gap) + 1]))
    starts = starts[starts < len(reference_clock)]
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
    """Refuse a modulus that leaves a jump of the position where it removed one.

    A remaining jump is a step that differs from the mean of its neighbours by more than any other
    step does.

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
    """
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
            f"the modulus {modulus}, for instance before data row {seams[0] + 2}. Give the correct "
            f"modulus with its unit, as in {_IN_DEGREES}.",
            code="wrap",
        )


def _remaining_jumps(
    columns: RoleColumns, axis: Axis | None, gap: float, modulus: Modulus | None
) -> list[str]:
    """Return notes on jumps of a position: steps of over half its range during slow motion.

    Jumps by whole turns, and jumps that a given modulus does not remove, are refused.
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
    turns = axis is None or axis.coordinate.unit == "rad"
    refuse(
        DataError,
        (
            modulus is not None,
            f"which the modulus {modulus} does not remove. Give the correct modulus with its unit, "
            f"as in {_IN_DEGREES}",
        ),
        *(
            (
                turns and abs(size / turn - 1) < 0.05,  # the axis moves on during a jump
                f"as if it restarted after each turn. It looks wrapped. Add {more}{_IN_DEGREES}",
            )
            for turn, more in (
                (2 * math.pi, ""),
                (360.0, f"{setting('columns', {'position': 'NAME:deg'})} and "),
            )
        ),
        before=f"{columns.source}: {jumps}, ",
        code="wrap",
    )
    return [
        f"{jumps}. If the position restarts there, give the modulus after which it restarts (wrap "
        "in run.toml)"
    ]
