"""When does the recorded force act? The residual over a delay between force and motion.

A drive holds its force from one sample to the next, so that a central-difference acceleration
belongs to the force half a sample earlier than the one recorded with it; a filter or a bus delays
further. Half a sample moves viscous friction by several of its deviations.
"""

from dataclasses import dataclass

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import Array
from .covariance import Hac
from .errors import EstimationError
from .forms import Equations, InverseForm
from .linear import Factored, factor, instrumental_variables, least_squares
from .prefilter import Prefilter
from .record import Record
from .signals import drive_force, measured_signals

_DELAYS = np.linspace(-1.0, 3.0, 17)  # samples
_STEPS, _STILL = 10, 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
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
    """

    delays: Array
    errors_percent: Array
    physical: Array
    best: float
    deviation: float
    at_the_end: bool
    by_instruments: bool
    sensitivity: Array


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
    form = InverseForm(axis, physical)
    equations = form.equations(measured_signals(axis, record, prefilter))
    reduced = equations.reduced(prefilter, record.period)
    regressor = factor(reduced.regressor, axis.names)
    force = drive_force(axis, record)
    estimates, errors = [], []
    for delay in _DELAYS:
        left = prefilter.reduce(_earlier(force, delay), record.period)
        solution = least_squares(left - reduced.known, regressor)
        estimates.append(solution.theta)
        errors.append(100 * np.linalg.norm(solution.residuals) / np.linalg.norm(left))
    found, percent = np.array(estimates), np.array(errors)
    best, at_the_end = _minimum(_DELAYS, percent), int(np.argmin(percent)) in (0, len(percent) - 1)
    deviation = _deviation(force, best, equations, regressor, prefilter, record.period)
    if instruments is not None:
        search = _Delay(force, equations, regressor, instruments, prefilter, record.period)
        best, deviation, at_the_end = search.found(min(max(best, 0.0), 1.0))
    slopes = np.gradient(found, _DELAYS, axis=0)
    return Alignment(
        delays=_DELAYS.copy(),
        errors_percent=percent,
        physical=found,
        best=best,
        deviation=deviation,
        at_the_end=at_the_end,
        by_instruments=instruments is not None,
        sensitivity=np.array([np.interp(best, _DELAYS, slope) for slope in slopes.T]),
    )


def _minimum(delays: Array, errors: Array) -> float:
    """Vertex of the parabola through the smallest error and its neighbours."""
    i = int(np.argmin(errors))
    if i in (0, len(errors) - 1):
        return float(delays[i])
    a, b, c = errors[i - 1] ** 2, errors[i] ** 2, errors[i + 1] ** 2
    bend = a - 2 * b + c
    shift = 0.5 * (a - c) / bend if bend > 0 else 0.0
    return float(delays[i] + shift * (delays[1] - delays[0]))


def _earlier(force: Array, delay: float) -> Array:
    """By a cubic spline: a straight line would smooth noise most between two samples.

    The smallest error would then be drawn there.
    """
    from scipy.ndimage import shift

    return np.asarray(shift(force, delay, order=3, mode="nearest"), dtype=float)


def _deviation(
    force: Array,
    delay: float,
    equations: Equations,
    X: Factored,
    prefilter: Prefilter,
    period: float,
) -> float:
    """Of the delay, to first order: ``y(t - d) = y(t - best) - (d - best) dy/dsample``.

    The change per sample is that of the fitted force; the recorded one's holds its noise.
    """
    known, left = (
        prefilter.reduce(each, period) for each in (equations.known, _earlier(force, delay))
    )
    theta = least_squares(left - known, X).theta
    fitted = equations.regressor @ theta + equations.known
    change = prefilter.reduce(np.gradient(fitted), period)
    columns = np.column_stack([X.columns, change])
    try:
        solution = least_squares(left - known, factor(columns, (*X.names, "delay")))
    except EstimationError:
        return float("inf")
    return float(np.sqrt(Hac().matrix(solution)[-1, -1]))


@dataclass(frozen=True, slots=True)
class _Delay:
    """The delay as one more parameter of an instrumental-variable estimate.

    Its column is the fitted force's change in a sample; its instrument that of the simulated force.
    """

    force: Array
    equations: Equations
    regressor: Factored
    instruments: tuple[Array, Array]
    prefilter: Prefilter
    period: float

    def found(self, start: float) -> tuple[float, float, bool]:
        """Delay, its deviation, and whether it left the range that is searched."""
        Z, simulated = self.instruments
        names = (*self.regressor.names, "delay")
        delay, deviation = start, float("inf")
        for _ in range(_STEPS):
            left, change = self._rows(delay, Z)
            try:
                X = factor(np.column_stack([self.regressor.columns, change]), names)
                extended = factor(np.column_stack([Z, np.gradient(simulated)]), names)
                solution = instrumental_variables(left, X, extended)
            except EstimationError:
                return start, float("inf"), False
            step = float(solution.theta[-1])
            deviation = float(np.sqrt(Hac().matrix(solution)[-1, -1]))
            delay += step
            if not _DELAYS[0] < delay < _DELAYS[-1]:
                return float(np.clip(delay, _DELAYS[0], _DELAYS[-1])), deviation, True
            if abs(step) < _STILL:
                break
        return delay, deviation, False

    def _rows(self, delay: float, Z: Array) -> tuple[Array, Array]:
        """Left side at a delay, and the fitted force's change in a sample."""
        known, left = (
            self.prefilter.reduce(each, self.period)
            for each in (self.equations.known, _earlier(self.force, delay))
        )
        instruments = factor(Z, self.regressor.names)
        theta = instrumental_variables(left - known, self.regressor, instruments).theta
        fitted = self.equations.regressor @ theta + self.equations.known
        return left - known, self.prefilter.reduce(np.gradient(fitted), self.period)
