"""When does the recorded force act? The residual over a delay between force and motion.

A drive holds its force from one sample to the next, so that a central-difference acceleration
belongs to the force half a sample earlier than the one recorded with it; a filter or a bus delays
further. Half a sample moves viscous friction by several of its deviations.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.lacking import Lack
from axisid.estimation.methods import bound_record
from axisid.estimation.records import Record, clock_of, hold_delay
from axisid.estimation.regression import (
    Equations,
    Hac,
    InverseForm,
    QrFactors,
    factor,
    fitted,
    instrumental_variables,
    least_squares,
)
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.thresholds import MAX_DELAY_DEVIATION, MAX_MISALIGNMENT, NO_DELAY
from axisid.support.arrays import Array, Exact
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_EARLIEST, _LATEST, _STEP = -1, 3, 0.25  # samples
_MOST_DECLARED = 8  # samples of a declared delay that may be told as none
_STEPS, _STILL = 10, 1e-3
_BEYOND = 12  # samples that a spline goes on; what happens at their end does not come back


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alignment(Exact):
    """Least squares over the delay of the force.

    Attributes
    ----------
    delays : (d,) array
        Samples by which the force is taken earlier; 0 is `hold` raw, 0.5 is nearly zoh.
    errors_percent : (d,) array
        Equation error at each.
    physical : (d, p) array
        Estimate at each.
    best : float
        Delay of the smallest error, between the samples by a parabola.
    deviation : float
        Its standard deviation, HAC: that of the factor of the fitted force's change in a sample, as
        one more column of the regressor.
    at_the_end : bool
        The error has no minimum within `delays`.
    by_instruments : bool
        Whether `best` and `deviation` are those of instruments; the profile is of least squares.
    sensitivity : (p,) array
        Change of each parameter per sample of delay, at the best one.
    names : tuple of str
        Of these parameters, which are those of the record's axis.
    units : tuple of str
    """

    delays: Array
    errors_percent: Array
    physical: Array
    best: float
    deviation: float
    at_the_end: bool
    by_instruments: bool
    sensitivity: Array
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()


def profile_alignment(
    axis: GeneratedAxis,
    record: Record,
    prefilter: Prefilter,
    physical: Array | None = None,
    instruments: tuple[Array, Array] | None = None,
) -> Alignment:
    """Profile the equation error of IDM-LS over the delay of the force.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        Its hold is not used.
    physical : (p,) array, optional
        Where a partially linear model is linearised.
    instruments : ((n, k) array, (n,) array), optional
        Of the inverse model, and the simulated force of the same rows: the delay is then estimated
        by instruments too, since noise in the motion moves that of least squares.
    """
    return alignment_of(bound_record(axis, record, prefilter), physical, instruments)


def alignment_of(
    data: FilteredRecord,
    physical: Array | None = None,
    instruments: tuple[Array, Array] | None = None,
    quiet: FilteredRecord | None = None,
) -> Alignment:
    """`profile_alignment` of a record that is filtered already.

    With the noise-free loop under the same filter, `quiet`, the delay that the filter alone makes
    there is taken off.
    """
    axis = data.axis
    form = InverseForm(axis, physical)
    equations = form.equations(data.signals)
    reduced = equations.reduced(data)
    regressor = factor(reduced.regressor, axis.names, neighbours=data.neighbours)
    rows = _Rows(data, data.force, equations)
    delays = _tried(data)
    lefts = np.column_stack([rows.left(delay) for delay in delays])
    estimates, residuals = fitted(lefts - reduced.intercept[:, None], regressor)
    found = np.ascontiguousarray(estimates.T)
    percent = 100 * np.linalg.norm(residuals, axis=0) / np.linalg.norm(lefts, axis=0)
    best, at_the_end = _minimum(delays, percent), int(np.argmin(percent)) in (0, len(percent) - 1)
    deviation = _deviation(rows, best, reduced.intercept, regressor)
    if instruments is not None:
        start = min(max(best, 0.0), 1.0)
        arguments = (start, reduced.intercept, regressor, *instruments)
        by_filter = 0.0 if quiet is None else _filter_shift(quiet, form, *instruments)
        tried = (delays[0] + by_filter, delays[-1] + by_filter)
        best, deviation, at_the_end = _by_instruments(rows, *arguments, tried=tried)
        best -= by_filter
    slopes = np.gradient(found, delays, axis=0)
    return Alignment(
        delays=delays,
        errors_percent=percent,
        physical=found,
        best=best,
        deviation=deviation,
        at_the_end=at_the_end,
        by_instruments=instruments is not None,
        sensitivity=np.array([np.interp(best, delays, slope) for slope in slopes.T]),
        names=data.axis.names,
        units=tuple(p.unit for p in data.axis.parameters),
    )


def _tried(data: FilteredRecord) -> Array:
    """Delays that are tried, (d,): as far back as what a drive declares may not be there."""
    declared = math.floor(declared_lateness(data) / data.record.period)
    earliest = min(_EARLIEST, -1 - min(declared, _MOST_DECLARED))
    return np.arange(earliest, _LATEST + _STEP, _STEP)


def _minimum(delays: Array, errors: Array) -> float:
    """Vertex of the parabola through the smallest error and its neighbours."""
    i = int(np.argmin(errors))
    if i in (0, len(errors) - 1):
        return float(delays[i])
    a, b, c = errors[i - 1] ** 2, errors[i] ** 2, errors[i + 1] ** 2
    bend = a - 2 * b + c
    shift = 0.5 * (a - c) / bend if bend > 0 else 0.0
    return float(delays[i] + shift * (delays[1] - delays[0]))


def _by_segment(values: Array, edges: Sequence[int], change: Callable[[Array], Array]) -> Array:
    """What changes (n,) values from row to row, in each of the segments that begin at `edges`.

    Neighbouring rows of two segments were not measured one after the other.
    """
    return np.concatenate([change(piece) for piece in np.split(values, edges)])


def _later(coefficients: Array, samples: int) -> Array:
    """A spline's coefficients so many samples later, of the samples that it was made of."""
    wanted = np.arange(_BEYOND, len(coefficients) - _BEYOND) + samples
    return coefficients[np.clip(wanted, 0, len(coefficients) - 1)]


def _slope(values: Array) -> Array:
    """Change from row to row, (n,); none where there is one row."""
    return np.gradient(values) if len(values) > 1 else np.zeros_like(values)


@dataclass(frozen=True)
class _Rows:
    """A record's force, and the equations of its motion, at any delay between them."""

    data: FilteredRecord
    force: Array
    equations: Equations
    _moved: dict[int, Array] = field(default_factory=dict)

    def left(self, delay: float) -> Array:
        """The force a delay earlier, reduced, (n,).

        By a cubic spline: a straight line would smooth noise most between two samples, and draw
        the smallest error there. A value of the spline is a sum of four of its coefficients, whose
        rows are filtered once for all delays.
        """
        whole = math.floor(-delay)
        t = -delay - whole
        weights = np.array(
            [(1 - t) ** 3, 4 - 6 * t**2 + 3 * t**3, 1 + 3 * t + 3 * t**2 - 3 * t**3, t**3]
        )
        places = range(whole - 1, whole + 3)
        self._move([place for place in places if place not in self._moved])
        return np.column_stack([self._moved[place] for place in places]) @ (weights / 6)

    def _move(self, places: Sequence[int]) -> None:
        """Reduce the coefficients so many samples later."""
        if places:
            moved = [np.concatenate([_later(c, place) for c in self._splines]) for place in places]
            self._moved.update(zip(places, self.data.reduce(np.column_stack(moved)).T, strict=True))

    @cached_property
    def _splines(self) -> list[Array]:
        """Coefficients of the force in each segment, which stays beyond its ends as it is there."""
        from scipy.ndimage import spline_filter1d

        pieces = np.split(self.force, self._starts)
        held = [np.pad(piece, _BEYOND, mode="edge") for piece in pieces]
        return [np.asarray(spline_filter1d(piece, order=3, mode="nearest")) for piece in held]

    def fitted_change(self, theta: Array) -> Array:
        """Change in a sample of the force fitted by parameters (p,), reduced, (n,).

        The recorded one's holds its noise.
        """
        fitted = self.equations.regressor @ theta + self.equations.intercept
        change = _by_segment(fitted, self._starts, _slope)
        return self.data.reduce(change)

    def reduced_change(self, values: Array) -> Array:
        """Change from row to row of reduced values, (n,), of rows that follow each other."""
        return np.concatenate([_slope(piece) for piece in self.data.neighbours.split(values)])

    @property
    def _starts(self) -> list[int]:
        """Of all segments but the first."""
        return [start for start, _ in self.data.record.spans[1:]]


def _deviation(rows: _Rows, delay: float, intercept: Array, X: QrFactors) -> float:
    """Of the delay, to first order: ``y(t - d) = y(t - best) - (d - best) dy/dsample``."""
    left = rows.left(delay) - intercept
    change = rows.fitted_change(least_squares(left, X).theta)
    columns = np.column_stack([X.columns, change])
    try:
        solution = least_squares(
            left, factor(columns, (*X.names, "delay"), neighbours=X.neighbours)
        )
    except EstimationError:
        return float("inf")
    # A parameter beside the others, which the fit took: of few scores as they are.
    return float(np.sqrt(Hac().matrix(solution)[-1, -1]))


def _by_instruments(
    rows: _Rows,
    start: float,
    intercept: Array,
    X: QrFactors,
    Z: Array,
    simulated: Array,
    *,
    tried: tuple[float, float],
) -> tuple[float, float, bool]:
    """The delay as one more parameter: it, its deviation, and whether it left what is `tried`.

    Its column is the fitted force's change in a sample; its instrument that of the simulated force.
    """
    names = (*X.names, "delay")
    delay, deviation = start, float("inf")
    instruments = factor(Z, X.names)
    try:
        extended = factor(np.column_stack([Z, rows.reduced_change(simulated)]), names)
        for _ in range(_STEPS):
            left = rows.left(delay) - intercept
            change = rows.fitted_change(instrumental_variables(left, X, instruments).theta)
            both = np.column_stack([X.columns, change])
            columns = factor(both, names, neighbours=X.neighbours)
            solution = instrumental_variables(left, columns, extended)
            step = float(solution.theta[-1])
            deviation = float(np.sqrt(Hac().matrix(solution)[-1, -1]))
            delay += step
            if not tried[0] < delay < tried[1]:
                return float(np.clip(delay, *tried)), deviation, True
            if abs(step) < _STILL:
                break
    except EstimationError:
        return start, float("inf"), False
    return delay, deviation, False


def _filter_shift(quiet: FilteredRecord, form: InverseForm, Z: Array, simulated: Array) -> float:
    """What the filter alone moves the delay by: of the noise-free loop's it is known."""
    equations = form.equations(quiet.signals)
    reduced = equations.reduced(quiet)
    law = quiet.axis.axis.control
    sensed = quiet.prefilter.hold == "raw" and (
        quiet.record.force is not None or not quiet.axis.axis.jumps
    )
    # By the loop itself: what is commanded is held, what is sensed the mean about a sample.
    still = law is None or law.continuous or sensed
    made = 0.0 if still else hold_delay(law, quiet.period, clock_of(quiet.record))
    regressor = factor(reduced.regressor, quiet.axis.names, neighbours=quiet.neighbours)
    rows = _Rows(quiet, quiet.force, equations)
    arguments = (rows, made, reduced.intercept, regressor, Z, simulated)
    tried = (made - _LATEST, made + _LATEST)
    delay, deviation, at_the_end = _by_instruments(*arguments, tried=tried)
    return 0.0 if at_the_end or not np.isfinite(deviation) else delay - made


def alignment_check(
    preferred: Estimate,
    profile: Alignment | Missing,
    data: FilteredRecord,
    *,
    late: Lack | None,
    weak: bool,
    remedy: Remedy | None = None,
    by_log: bool = False,
) -> Check | Missing:
    """The delay that fits best against the one that the hold takes; `weak` are the instruments.

    It fails where the model lacks a delay, `late`, by the search for all that it may lack.
    The `remedy` is for a force that acts whole samples after it is recorded. `by_log` the control
    law says that the log wrote it at another time, by as much: that is the only remedy then, and
    counts once.
    """
    if isinstance(profile, Missing):
        return profile
    if weak:
        return Missing("the instruments are too weak to measure a delay")
    hold, used = str(data.prefilter.hold), data.hold_delay
    apart = profile.best - used
    if profile.deviation > MAX_DELAY_DEVIATION.value:
        return Missing(
            f"the record tells the force's delay to +-{profile.deviation:.2g} samples only, which "
            "is no more than a guess"
        )
    moved = ", ".join(
        f"{p.name} by {slope:+.2g} {p.unit}"
        for p, slope in zip(preferred.quantities, profile.sensitivity, strict=True)
    )
    by_ls = "" if profile.by_instruments else " (by least squares, which noise may bias)"
    fits = (
        f"the force fits the motion best {_delay(profile)} {_side(profile.best)} it is recorded; "
        f"hold {hold} supposes {abs(used):g} samples {_side(used)}{by_ls}"
    )
    other, moves = _other_hold(profile, data), f"A sample of delay moves {moved}"
    advice = Remedy.of("Try ", other) if other is not None else remedy
    if not by_log and other is None:
        advice = _of_drive(profile, data, remedy)
    aligned = not (late or profile.at_the_end)
    return Check(
        name="alignment",
        status=passed(aligned, matters=not by_log),
        figure=apart,
        p_value=late.p_value if late else None,
        source="samples between the delay of least equation error and the one that is used; fails "
        "where the model lacks a delay, see missing terms, or the least is beyond the delays that "
        "are tried; a drive that holds its force is half a sample late",
        meaning=fits
        if aligned
        else f"{fits}{_early(data, apart)}. {moves if advice is None else ''}",
        remedy=None if aligned or advice is None else Remedy.of(advice, f". {moves}"),
    )


def _of_drive(profile: Alignment, data: FilteredRecord, remedy: Remedy | None) -> Remedy | None:
    """To declare what is between a command and its force, before what else there is to do."""
    axis, record, apart = data.axis.axis, data.record, profile.best - data.hold_delay
    sampled = axis.control is None or not axis.control.continuous
    if record.force is not None or not sampled:
        return remedy
    if apart < 0 and declared_lateness(data):
        return Remedy.of(_too_long(profile, data), ". " if remedy else "", remedy)
    if apart <= 0 or profile.at_the_end:
        return remedy
    more = "more " if declared_lateness(data) else ""
    said = (
        f"Declare what lies between command and force, the drive's delay or its lag, "
        f"{apart * record.period:.3g} s {more}in all"
    )
    return Remedy.of(said) if remedy is None else Remedy.of(said, ". ", remedy)


def declared_lateness(data: FilteredRecord) -> float:
    """Seconds by which a drive declares that its force follows the recorded control."""
    drive = data.axis.axis.drive
    behind = {"command": drive.delay + drive.lag, "applied": drive.lag}
    return float(behind.get(drive.logged, 0.0))


def _too_long(profile: Alignment, data: FilteredRecord) -> str:
    """By how much a declared delay or lag is too long, and what to declare."""
    declared = declared_lateness(data)
    off = (data.hold_delay - profile.best) * data.record.period
    least = "at least " if profile.at_the_end else ""
    rest = declared - off
    instead = "none" if rest < NO_DELAY.value * declared else f"{rest:.3g} s"
    return (
        f"The drive's delay or lag, declared as {declared:.3g} s in all, is {least}{off:.3g} s too "
        f"long: declare {instead}{' or less' if profile.at_the_end and rest > 0 else ''}"
    )


def _other_hold(profile: Alignment, data: FilteredRecord) -> Setting | None:
    """The other hold, where the delay is its own."""
    zoh = hold_delay(data.axis.axis.control, data.period, clock_of(data.record))
    other, own = ("zoh", zoh) if data.prefilter.hold == "raw" else ("raw", 0.0)
    near = abs(profile.best - own) <= MAX_MISALIGNMENT.value
    early = (data.hold_delay - profile.best) * data.record.period
    if 0 < early * (1 - NO_DELAY.value) < declared_lateness(data):
        return None  # a delay that is not there is declared
    return Setting("hold", other) if near else None


def _delay(profile: Alignment) -> str:
    size = abs(profile.best)
    if profile.at_the_end:
        return f"{size:g} samples, the end of the range that was tried, or more"
    return f"{size:.2f} +- {profile.deviation:.2g} samples"


def _side(delay: float) -> str:
    return "before" if delay < 0 else "after"


def _early(data: FilteredRecord, apart: float) -> str:
    """Which column is early or late beside the other."""
    column, way = (
        "control" if data.record.force is None else "force",
        "early" if apart > 0 else "late",
    )
    return f", so that the {column} is {abs(apart):.2g} samples {way} beside the position"
