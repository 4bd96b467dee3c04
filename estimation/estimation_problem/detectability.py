"""Detectability of parameters: refuse parameters that a record does not show, by name.

Scaled to unit norm, even a column of 1e-80 gives an estimate. The criterion is the size that a
parameter needs for its force to stand out of the residual. A record does not show a parameter if
that force exceeds the whole force of the record at the sample where the term acts most, or if the
size is far beyond the one that the parameter's unit and declaration suggest.
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
from axisid.support.checks import refuse
from axisid.support.errors import EstimationError, ModelError, UsageError
from axisid.support.settings import setting

# force of a detectable term, relative to the record's largest force: other terms may cancel it
_MAX_CANCELLED_FORCE = 10.0
_MAX_TIMES_DECLARED = 1e3  # size of a detectable parameter, relative to its declared value
# the same relative to the size typical for its unit, if no value is declared: that size is a guess
_MAX_TIMES_UNIT = 1e9

_ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalRanges:
    """Ranges of the force, the motion and the columns of the inverse model over records.

    Attributes
    ----------
    force : float
        Largest magnitude of the force, SI.
    columns : (p,) array
        Largest magnitude of each column of the inverse model.
    travel : (float, float)
        Smallest and largest position, SI.
    velocity, acceleration : float
        Largest magnitudes, SI.
    """

    force: float
    columns: Array
    travel: tuple[float, float]
    velocity: float
    acceleration: float

    @classmethod
    def of(cls, records: Sequence[tuple[Signals, Equations, BoolArray]]) -> "SignalRanges | None":
        """Return the ranges over the kept samples of each record; None without kept samples.

        Parameters
        ----------
        records : sequence of (Signals, Equations, (N,) array of bool)
            Signals, rows, and True for kept samples of each record.
        """
        every = [each for each in records if each[2].any()]
        if not every:
            return None
        position = np.concatenate([s.position[kept] for s, _, kept in every])
        velocity = np.concatenate([s.velocity[kept] for s, _, kept in every])
        acceleration = np.concatenate([s.acceleration[kept] for s, _, kept in every])
        force = np.concatenate([e.left[kept] for _, e, kept in every])
        # Column by column, which is faster.
        columns = [np.abs(np.ascontiguousarray(e.regressor[kept].T)) for _, e, kept in every]
        return cls(
            force=float(np.abs(force).max()),
            columns=np.max([each.max(axis=1) for each in columns], axis=0),
            travel=(float(position.min()), float(position.max())),
            velocity=float(np.abs(velocity).max()),
            acceleration=float(np.abs(acceleration).max()),
        )


def check_time_known(axis: GeneratedAxis) -> None:
    """Refuse an axis whose drive has a lag or a delay that is to be estimated.

    Raises
    ------
    UsageError
        The lag or the delay is to be estimated.
    """
    estimated = axis.declared.drive.estimated
    if estimated is not None:
        raise UsageError(
            f"axis {axis.name!r}: the {estimated[0]} of its drive is to be estimated, which "
            "identify does from one record; declare its result as a number here.",
            code="drive-time",
        )


def check_has_rows(axis: Axis) -> None:
    """Refuse an axis whose friction has an internal state, which is not recorded.

    Raises
    ------
    ModelError
        The axis has internal states.
    """
    names = ", ".join(state.name for state in axis.states)
    refuse(
        ModelError,
        (
            axis.states,
            f"the friction of axis {axis.name!r} has the internal "
            f"{'state' if len(axis.states) == 1 else 'states'} {names}, in no record, so that "
            "least squares, "
            "instruments and DIDIM have no rows of measured signals; fit the simulated loop (fit)",
        ),
        code="equation",
    )


def _keeping_samples() -> str:
    """Return the advice if the samples left out near reversals and rests may show a parameter."""
    return (
        f"For a force that acts near reversals, keep those samples ({setting('reversals', 'keep')})"
        ", or fit the simulated loop (axisid fit), which uses all samples. Otherwise record"
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
        Ranges of the signals; None if no sample is kept, and nothing is refused then.
    regressor, left : (n, p), (n,) arrays
        Rows of the inverse model; the left side minus the known terms.
    source : str
        Name of the record, for the message.
    without_turns : bool
        True if samples near reversals and rests are left out.

    Raises
    ------
    EstimationError
        A record does not show the named parameters; the size that they need is given.
    """
    finite = np.all(np.isfinite(regressor)) and np.all(np.isfinite(left))
    if reach is None or len(regressor) <= regressor.shape[1] or not finite:
        return
    norms = np.linalg.norm(regressor, axis=0)
    unit = regressor[:, norms > 0] / norms[norms > 0]
    residuals = left - unit @ np.linalg.lstsq(unit, left, rcond=None)[0]
    unexplained = float(np.linalg.norm(residuals) / np.sqrt(len(left) - regressor.shape[1]))
    # Noise: the rms residual of least squares.
    noise = max(unexplained, _ROUNDING * reach.force)
    if not np.isfinite(noise):
        return  # the regression refuses signals of this size
    unseen: dict[str, str] = {}
    natural, unit_of_force = typical_magnitudes(axis, reach), axis.coordinate.force_unit
    for j, p in enumerate(axis.axis_parameters):
        if axis.nonlinear[j]:
            continue  # its column is a derivative about a point
        if norms[j] == 0:
            unseen[p.name] = f"the column of {p.name} is zero in every row"
            continue
        # The size with which the parameter is significant, and its largest force with that size.
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
    which = (f"a parameter of {made[n]}" if n in made else setting("leave_out", n) for n in unseen)
    record = _keeping_samples() if without_turns else "Record"
    them = "it" if len(unseen) == 1 else "them"
    raise EstimationError(
        f"{source} does not show {', '.join(unseen)}{turns}: {'; '.join(unseen.values())}. "
        f"{record} a motion that stays longer where the force depends on it, or leave {them} out "
        f"({' and '.join(which)}).",
        code="not-shown",
    )


def typical_magnitudes(
    axis: GeneratedAxis, reach: SignalRanges, parameters: Sequence[Parameter] | None = None
) -> Array:
    """Return the typical magnitude of each parameter by its unit, force and motion, (p,).

    It is the product of powers of the force, the travel and the times of the motion that has the
    dimension of the unit. It is infinite for units with other dimensions (an ampere; a length on a
    rotary axis), and for parameters of terms with a recorded signal.
    """
    named = axis.axis_parameters if parameters is None else parameters
    sizes = np.array([_natural(axis, p.unit, reach) for p in named])
    if axis.signals and [p.name for p in named] == list(axis.names):
        sizes[columns_by_signal(axis)["recorded"]] = np.inf
    return sizes


def detection_limits(axis: GeneratedAxis, reach: SignalRanges) -> Array:
    """Return the largest size that a detectable parameter may need to exceed the noise, (p,).

    It is the smaller one of two sizes: that with ten times the record's largest force; and 1000
    times the larger of declared and typical size (without a declared one 1e9 times the typical).
    """
    natural = typical_magnitudes(axis, reach)
    with np.errstate(divide="ignore"):
        by_force = _MAX_CANCELLED_FORCE * reach.force / reach.columns
    sizes = [_farthest(p, float(n)) for p, n in zip(axis.axis_parameters, natural, strict=True)]
    return np.minimum(by_force, sizes)


def _farthest(parameter: Parameter, natural: float) -> float:
    """Return the largest plausible size of a parameter from its declared and typical size."""
    bounds = max(abs(parameter.lower), abs(parameter.upper))
    declared = max(abs(parameter.nominal), bounds if np.isfinite(bounds) else 0.0)
    if not declared:
        return _MAX_TIMES_UNIT * natural
    return _MAX_TIMES_DECLARED * max(declared, natural if np.isfinite(natural) else 0.0)


def _natural(axis: GeneratedAxis, unit: str, reach: SignalRanges) -> float:
    """Return the typical magnitude of a parameter with a unit; infinite if it has none."""
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
