"""Detectability of parameters: refuse parameters that a record does not show, by name.

Scaled to unit norm, even a column of 1e-80 gives an estimate. The criterion is the size that a
parameter needs for its force to exceed the residual. A record does not show a parameter if that
force exceeds ten times the largest force of the record at the sample where the term acts most, or
if that size is far beyond the size that the parameter's unit and declaration suggest.
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
            f"axis {axis.name!r}: the {estimated[0]} of its drive is to be estimated, and only "
            f"identify estimates it, from one record. Declare the estimated {estimated[0]} as a "
            "number.",
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
    states = f"state {names}, which is" if len(axis.states) == 1 else f"states {names}, which are"
    refuse(
        ModelError,
        (
            axis.states,
            f"the friction of axis {axis.name!r} has the internal {states} not recorded. Least "
            "squares, instrumental variables and DIDIM need rows of measured signals only. Fit the "
            "simulated loop (fit)",
        ),
        code="equation",
    )


def _advice_to_keep_samples() -> str:
    """Return advice for a parameter that the samples near reversals and rests may show.

    These samples are left out of the rows.
    """
    return (
        "For a force that acts near reversals, keep the samples there "
        f"({setting('reversals', 'keep')}), or fit the simulated loop (axisid fit), which uses all "
        "samples."
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
    """Refuse a regression with a parameter that the record does not show.

    The noise is the rms residual of least squares. From it follows the size that a parameter needs
    to be significant. The record does not show a parameter with a zero column, or if the largest
    force with the needed size is not plausible, or if that size itself is not plausible. Parameters
    that enter nonlinearly are not checked.

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
        The record does not show some parameters. The message names them, with the size that each
        would need.
    """
    finite = np.all(np.isfinite(regressor)) and np.all(np.isfinite(left))
    if reach is None or len(regressor) <= regressor.shape[1] or not finite:
        return
    norms = np.linalg.norm(regressor, axis=0)
    unit = regressor[:, norms > 0] / norms[norms > 0]
    # Noise: the rms residual of least squares, at least the rounding of the force.
    residuals = left - unit @ np.linalg.lstsq(unit, left, rcond=None)[0]
    rms = float(np.linalg.norm(residuals) / np.sqrt(len(left) - regressor.shape[1]))
    noise = max(rms, _ROUNDING * reach.force)
    if not np.isfinite(noise):
        return  # the regression refuses signals of this size
    unseen = _reasons_not_shown(axis, reach, norms, noise)
    if not unseen:
        return
    turns = ", without the samples near reversals and rests" if without_turns else ""
    raise EstimationError(
        f"{source} does not show {', '.join(unseen)}{turns}: {'; '.join(unseen.values())}. "
        f"{_advice_on_parameters(axis, [*unseen], without_turns=without_turns)}",
        code="not-shown",
    )


def _reasons_not_shown(
    axis: GeneratedAxis, reach: SignalRanges, norms: Array, noise: float
) -> dict[str, str]:
    """Return why the record does not show some parameters, as text, by name of the parameter.

    Parameters
    ----------
    axis : GeneratedAxis
    reach : SignalRanges
        Ranges of the signals.
    norms : (p,) array
        Norms of the columns of the regressor.
    noise : float
        Root mean square of the noise, in the unit of the force.
    """
    unseen: dict[str, str] = {}
    typical, unit_of_force = typical_magnitudes(axis, reach), axis.coordinate.force_unit
    for j, p in enumerate(axis.axis_parameters):
        if axis.nonlinear[j]:
            continue  # the column is a derivative, linearised about a point
        if norms[j] == 0:
            unseen[p.name] = f"the column of {p.name} is zero in every row"
            continue
        # The size with which the parameter is significant, and its largest force with that size.
        needed = MIN_DISTANCE_FROM_NOISE.value * noise / float(norms[j])
        largest_force = needed * float(reach.columns[j])
        reason = f"{p.name} would have to be {needed:.2g} {p.unit} to exceed the noise"
        if largest_force > _MAX_CANCELLED_FORCE * reach.force:
            unseen[p.name] = (
                f"{reason}, which is a force of {largest_force:.2g} {unit_of_force} where it acts "
                f"most, but the largest force of the record is {reach.force:.3g} {unit_of_force}"
            )
        elif needed > _largest_plausible(p, float(typical[j])):
            unseen[p.name] = f"{reason}, but {_plausible_size(p, float(typical[j]))}"
    return unseen


def _plausible_size(parameter: Parameter, typical: float) -> str:
    """Return a clause on the plausible size of a parameter: typical size, nominal value, bounds."""
    clauses = []
    if np.isfinite(typical):
        clauses.append(
            f"with this force and motion, a typical parameter in {parameter.unit} is about "
            f"{typical:.2g}"
        )
    if parameter.nominal:
        clauses.append(f"its nominal value is {parameter.nominal:g}")
    return " and ".join(clauses) or "its bounds are far below that size"


def _advice_on_parameters(axis: GeneratedAxis, names: Sequence[str], *, without_turns: bool) -> str:
    """Return advice for parameters that a record does not show.

    The advice is to keep samples near reversals and rests, if they are left out; to record another
    motion; or to leave the parameters out.
    """
    expressions = {q.name: q.expression for q in axis.parameters if q.expression}
    to_leave_out = []
    for name in names:
        if name in expressions:
            to_leave_out.append(f"a parameter of {expressions[name]}")
        else:
            to_leave_out.append(setting("leave_out", name))
    keep = f"{_advice_to_keep_samples()} Otherwise record" if without_turns else "Record"
    parameters = "the parameter" if len(names) == 1 else "these parameters"
    return (
        f"{keep} a motion that stays longer where the force depends on {parameters}, or leave "
        f"{parameters} out ({' and '.join(to_leave_out)})."
    )


def typical_magnitudes(
    axis: GeneratedAxis, reach: SignalRanges, parameters: Sequence[Parameter] | None = None
) -> Array:
    """Return the typical magnitude of each parameter by its unit, force and motion, (p,).

    It is the product of powers of the force, the travel and the times of the motion that has the
    dimension of the unit. It is infinite for units with other dimensions (an ampere; a length on a
    rotary axis), and for parameters of terms with a recorded signal.

    Parameters
    ----------
    axis : GeneratedAxis
    reach : SignalRanges
        Ranges of force and motion.
    parameters : sequence of Parameter, optional
        Parameters of length p; those of the axis by default.
    """
    named = axis.axis_parameters if parameters is None else parameters
    sizes = np.array([_typical_magnitude(axis, p.unit, reach) for p in named])
    if axis.signals and [p.name for p in named] == list(axis.names):
        sizes[columns_by_signal(axis)["recorded"]] = np.inf
    return sizes


def detection_limits(axis: GeneratedAxis, reach: SignalRanges) -> Array:
    """Return the largest size that a detectable parameter may need to exceed the noise, (p,).

    It is the smaller of two sizes. The first is the size with ten times the record's largest force.
    The second is 1000 times the larger of declared and typical size; without a declared size, it is
    1e9 times the typical size.
    """
    typical = typical_magnitudes(axis, reach)
    with np.errstate(divide="ignore"):
        by_force = _MAX_CANCELLED_FORCE * reach.force / reach.columns
    sizes = [
        _largest_plausible(p, float(size))
        for p, size in zip(axis.axis_parameters, typical, strict=True)
    ]
    return np.minimum(by_force, sizes)


def _largest_plausible(parameter: Parameter, typical: float) -> float:
    """Return the largest plausible size of a parameter from its declared and typical size.

    The declared size is the largest magnitude of nominal value and finite bounds.
    """
    bounds = max(abs(parameter.lower), abs(parameter.upper))
    declared = max(abs(parameter.nominal), bounds if np.isfinite(bounds) else 0.0)
    if not declared:
        return _MAX_TIMES_UNIT * typical
    if not np.isfinite(typical):
        typical = 0.0
    return _MAX_TIMES_DECLARED * max(declared, typical)


def _typical_magnitude(axis: GeneratedAxis, unit: str, reach: SignalRanges) -> float:
    """Return the typical magnitude of a parameter with a unit; infinite if it has none.

    It is ``force^a travel^b time^c`` with the powers that give the unit. The largest magnitude is
    returned for three times of the motion: travel by speed, speed by acceleration, and the root of
    travel by acceleration.
    """
    mass, length, time, current, temperature = map(float, parse_unit(unit).exponents)
    travel = reach.travel[1] - reach.travel[0]
    # A unit does not show powers of the radian, which has no dimension.
    is_rotary = axis.coordinate.unit == "rad"
    lengths, times = length - (2 if is_rotary else 1) * mass, time + 2 * mass
    if current or temperature or (is_rotary and lengths):
        return np.inf
    with np.errstate(all="ignore"):
        speed, acceleration = np.float64(reach.velocity), np.float64(reach.acceleration)
        motion_times = np.array(
            [travel / speed, speed / acceleration, np.sqrt(travel / acceleration)]
        )
        sizes = reach.force**mass * np.float64(travel) ** lengths * motion_times**times
    usable = sizes[np.isfinite(sizes)]
    return float(usable.max()) if usable.size else np.inf
