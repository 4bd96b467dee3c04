"""Whether a record shows a parameter at all: said by name, before there is a number to print.

Scaled to unit norm, a column of 1e-80 gives a number as any other does. What tells is how large the
parameter would have to be for its part of the force to stand out of what the model leaves
unexplained. A record does not show a parameter where that is more than all the force there was,
at the place of the record where the term acts most; or where it is far beyond the size that the
parameter's unit and its declaration give it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.regression import Equations
from axisid.estimation.signals import Signals, columns_by_signal
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter, parse_unit
from axisid.support.arrays import Array, BoolArray
from axisid.support.errors import EstimationError, ModelError, UsageError, refuse

# times the record's largest force that a term would have to make to show: others may cancel it
_MAX_CANCELLED_FORCE = 10.0
_MAX_TIMES_DECLARED = 1e3  # times the declared value that a parameter would need to be shown
# times its unit by force and motion, where none is declared: that size is a guess
_MAX_TIMES_UNIT = 1e9

_ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalRanges:
    """How far the force, the motion and the columns of the inverse model go along a record.

    Attributes
    ----------
    force : float
        Largest.
    columns : (p,) array
        Largest of each column.
    travel : (float, float)
        Least and largest position.
    velocity, acceleration : float
        Largest.
    """

    force: float
    columns: Array
    travel: tuple[float, float]
    velocity: float
    acceleration: float

    @classmethod
    def of(cls, records: Sequence[tuple[Signals, Equations, BoolArray]]) -> "SignalRanges | None":
        """Over the samples (N,) that are kept of each record; None where there are none."""
        every = [each for each in records if each[2].any()]
        if not every:
            return None
        position, velocity, acceleration, force = (
            np.concatenate(pieces)
            for pieces in zip(
                *(
                    (s.position[kept], s.velocity[kept], s.acceleration[kept], e.left[kept])
                    for s, e, kept in every
                ),
                strict=True,
            )
        )
        # quicker one by one
        columns = [np.abs(np.ascontiguousarray(e.regressor[kept].T)) for _, e, kept in every]
        return cls(
            force=float(np.abs(force).max()),
            columns=np.max([each.max(axis=1) for each in columns], axis=0),
            travel=(float(position.min()), float(position.max())),
            velocity=float(np.abs(velocity).max()),
            acceleration=float(np.abs(acceleration).max()),
        )


def check_time_known(axis: GeneratedAxis) -> None:
    """Refuse an axis whose drive has a lag or a delay that is still to be estimated.

    Raises
    ------
    UsageError
        It has.
    """
    estimated = axis.declared.drive.estimated
    if estimated is not None:
        raise UsageError(
            f"axis {axis.name!r}: the {estimated[0]} of its drive is to be estimated, which "
            "identify does of one record; declare what it finds as a number here.",
            code="drive-time",
        )


def check_has_rows(axis: Axis) -> None:
    """Refuse an axis whose friction remembers: what it remembers is in no record.

    Raises
    ------
    ModelError
        It has internal states.
    """
    names = ", ".join(state.name for state in axis.states)
    refuse(
        ModelError,
        (
            axis.states,
            f"the friction of axis {axis.name!r} remembers: no record has its internal "
            f"{'state' if len(axis.states) == 1 else 'states'} {names}, so that least squares, "
            "instruments and DIDIM have no rows of measured signals; fit the simulated loop (fit)",
        ),
        code="equation",
    )


#: Where what is left out near reversals and rests may show a parameter.
_KEEPING = (
    'For what acts near these, keep those samples (reversals="keep"), or fit the simulated loop '
    "(axisid fit), which has them all; otherwise record"
)


def check_visible(
    axis: GeneratedAxis,
    reach: SignalRanges | None,
    regressor: Array,
    left: Array,
    *,
    source: str,
    without_turns: bool,
) -> None:
    """Refuse a regression with a column that the record does not show.

    Parameters
    ----------
    axis : GeneratedAxis
    reach : SignalRanges or None
        None where no sample is kept; nothing is refused then.
    regressor, left : (n, p), (n,) arrays
        Of the inverse model, the left side less what is known.
    source : str
        Of the record, for the message.
    without_turns : bool
        Whether samples near reversals and rests are left out.

    Raises
    ------
    EstimationError
        The parameters are named, with what they would have to be.
    """
    finite = np.all(np.isfinite(regressor)) and np.all(np.isfinite(left))
    if reach is None or len(regressor) <= regressor.shape[1] or not finite:
        return
    norms = np.linalg.norm(regressor, axis=0)
    unit = regressor[:, norms > 0] / norms[norms > 0]
    residuals = left - unit @ np.linalg.lstsq(unit, left, rcond=None)[0]
    unexplained = float(np.linalg.norm(residuals) / np.sqrt(len(left) - regressor.shape[1]))
    noise = max(unexplained, _ROUNDING * reach.force)
    if not np.isfinite(noise):
        return  # the signals' size is refused where it is regressed
    unseen: dict[str, str] = {}
    natural, unit_of_force = typical_magnitudes(axis, reach), axis.coordinate.force_unit
    for j, p in enumerate(axis.axis_parameters):
        if axis.nonlinear[j]:
            continue  # its column is a slope about a point
        if norms[j] == 0:
            unseen[p.name] = f"the column of {p.name} is zero in every row"
            continue
        needed = MIN_DISTANCE_FROM_NOISE.value * noise / float(norms[j])
        there = needed * float(reach.columns[j])
        seen = f"{p.name} would have to be {needed:.2g} {p.unit} to stand out of the noise"
        if there > _MAX_CANCELLED_FORCE * reach.force:
            unseen[p.name] = (
                f"{seen}, a force of {there:.2g} {unit_of_force} where it acts most, in a record "
                f"whose largest is {reach.force:.3g} {unit_of_force}"
            )
        elif needed > _farthest(p, float(natural[j])):
            usual = f"a force and a motion like these make a parameter in {p.unit} about "
            said = [f"{usual}{natural[j]:.2g}"] * bool(np.isfinite(natural[j]))
            said += [f"its nominal value is {p.nominal:g}"] * bool(p.nominal)
            unseen[p.name] = f"{seen}; {' and '.join(said) or 'its bounds are far below that'}"
    if not unseen:
        return
    turns = ", without the samples near reversals and rests" if without_turns else ""
    made = {q.name: q.expression for q in axis.parameters if q.expression}
    which = (f"a parameter of {made[n]}" if n in made else f"leave-out {n}" for n in unseen)
    raise EstimationError(
        f"{source} does not show {', '.join(unseen)}{turns}: {'; '.join(unseen.values())}. "
        f"{_KEEPING if without_turns else 'Record'} a motion that stays longer where the force "
        f"depends on it, or leave {'it' if len(unseen) == 1 else 'them'} out "
        f"({' and '.join(which)}).",
        code="not-shown",
    )


def typical_magnitudes(
    axis: GeneratedAxis, reach: SignalRanges, parameters: Sequence[Parameter] | None = None
) -> Array:
    """What a parameter of each unit is in an axis of this force and motion, (p,).

    The force, the travel and the times that the motion gives, to the powers of the unit; infinite
    where it has others (an ampere; a length on a rotary axis), or stands beside a recorded signal.
    """
    named = axis.axis_parameters if parameters is None else parameters
    sizes = np.array([_natural(axis, p.unit, reach) for p in named])
    if axis.signals and [p.name for p in named] == list(axis.names):
        sizes[columns_by_signal(axis)["recorded"]] = np.inf
    return sizes


def detection_limits(axis: GeneratedAxis, reach: SignalRanges) -> Array:
    """How large each parameter may have to be to stand out of the noise, and be shown, (p,)."""
    natural = typical_magnitudes(axis, reach)
    with np.errstate(divide="ignore"):
        by_force = _MAX_CANCELLED_FORCE * reach.force / reach.columns
    sizes = [_farthest(p, float(n)) for p, n in zip(axis.axis_parameters, natural, strict=True)]
    return np.minimum(by_force, sizes)


def _farthest(parameter: Parameter, natural: float) -> float:
    bounds = max(abs(parameter.lower), abs(parameter.upper))
    declared = max(abs(parameter.nominal), bounds if np.isfinite(bounds) else 0.0)
    if not declared:
        return _MAX_TIMES_UNIT * natural
    return _MAX_TIMES_DECLARED * max(declared, natural if np.isfinite(natural) else 0.0)


def _natural(axis: GeneratedAxis, unit: str, reach: SignalRanges) -> float:
    mass, length, time, current, warmth = map(float, parse_unit(unit).exponents)
    travel = reach.travel[1] - reach.travel[0]
    rotary = axis.coordinate.unit == "rad"  # no unit itself: of its powers none can be seen
    lengths, times = length - (2 if rotary else 1) * mass, time + 2 * mass
    if current or warmth or (rotary and lengths):
        return np.inf
    with np.errstate(all="ignore"):
        speed, push = np.float64(reach.velocity), np.float64(reach.acceleration)
        clocks = np.array([travel / speed, speed / push, np.sqrt(travel / push)])
        sizes = reach.force**mass * np.float64(travel) ** lengths * clocks**times
    usable = sizes[np.isfinite(sizes)]
    return float(usable.max()) if usable.size else np.inf
