"""When does the recorded force act? The residual over a delay between force and motion.

A drive holds its force from one sample to the next, so that a central-difference acceleration
belongs to the force half a sample earlier than the one recorded with it; a filter or a bus delays
further. Half a sample moves viscous friction by several of its deviations.
"""

from dataclasses import dataclass

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import Array
from .forms import InverseForm
from .linear import factor, least_squares
from .prefilter import Prefilter
from .record import Record
from .signals import drive_force, measured_signals

_DELAYS = np.linspace(-1.0, 3.0, 17)  # samples


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
    """Least squares over the delay of the force.

    Attributes
    ----------
    delays : (d,) array
        Samples by which the force is taken earlier; 0 is `hold` raw, 0.5 is zoh.
    errors_percent : (d,) array
        Equation error at each.
    physical : (d, p) array
        Estimate at each.
    best : float
        Delay of the smallest error, between the samples by a parabola.
    sensitivity : (p,) array
        Change of each parameter per sample of delay, at the best one.
    """

    delays: Array
    errors_percent: Array
    physical: Array
    best: float
    sensitivity: Array


def profile_alignment(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Alignment:
    """Profile the equation error of IDM-LS over the delay of the force.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        Its hold is not used.
    """
    form = InverseForm(axis)
    equations = form.equations(measured_signals(axis, record, prefilter))
    reduced = equations.reduced(prefilter, record.period)
    regressor = factor(reduced.regressor, axis.names)
    force = drive_force(axis, record)
    samples = np.arange(len(force), dtype=np.float64)
    estimates, errors = [], []
    for delay in _DELAYS:
        earlier = np.interp(samples - delay, samples, force)
        left = prefilter.reduce(earlier, record.period)
        solution = least_squares(left - reduced.known, regressor)
        estimates.append(solution.theta)
        errors.append(100 * np.linalg.norm(solution.residuals) / np.linalg.norm(left))
    physical, percent = np.array(estimates), np.array(errors)
    best = _minimum(_DELAYS, percent)
    slopes = np.gradient(physical, _DELAYS, axis=0)
    return Alignment(
        delays=_DELAYS.copy(),
        errors_percent=percent,
        physical=physical,
        best=best,
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
