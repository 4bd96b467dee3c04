"""What the residuals are made of where they are no noise: a constant force, a ripple.

Each comes with what to do about it: the element to declare, the cut-off to take.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import factor, instrumental_variables, least_squares
from axisid.estimation.signals import Prefilter, Signals
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

from .check import Check, passed
from .control_law import LawCheck

_CONSTANT, _RIPPLE = "constant force", "ripple"
_STANDS_OUT = 3.0  # deviations
_NOTICED = 0.01  # of the force
_SAME = 0.3  # of the constant
_LINE = 0.15  # of the residuals' power
_BY_CHANCE = 1e-4
_NEIGHBOURS, _OWN = 41, 3  # frequencies that a line is held against, and that are its own
_REVERSALS = 8.0  # times the rate of reversals, from which on a frequency is not the motion's
_BELOW = 0.8  # of a ripple's frequency
_FEWEST = 100  # rows
_MOST_ROWS, _MOST_CYCLES = 2000, 400  # over the positions


@dataclass(frozen=True, slots=True)
class Line:
    """A line in a spectrum: its frequency, its amplitude, its part of the power."""

    frequency: float
    amplitude: float
    share: float


def constant_check(judged: Estimate, weights: Array, law: LawCheck | Missing, gain: float) -> Check:
    """Whether a constant force is left in the residuals.

    Parameters
    ----------
    judged : Estimate
    weights : (n,) array
        Of its rows: what a constant force of 1 makes of them.
    law : LawCheck or Missing
    gain : float
        Of the drive.
    """
    if judged.ddm_quantities:
        return Check.missing(_CONSTANT, "the rows of a direct model are accelerations")
    found = _constant(judged, weights)
    force, deviation = found or (0.0, 0.0)  # nothing beside terms that make a constant themselves
    unit = judged.form.axis.axis.coordinate.force_unit
    size = abs(force) * float(np.linalg.norm(weights)) / float(np.linalg.norm(judged.y))
    good = abs(force) <= _STANDS_OUT * deviation or size <= _NOTICED
    said = f"{force:.3g} +- {deviation:.1g} {unit}"
    return Check(
        name=_CONSTANT,
        status=passed(good),
        figure=100 * size,
        threshold=100 * _NOTICED,
        source="percent of the force that a constant beside the model's terms would be, estimated "
        "as they are; fails where it is three of its deviations too",
        meaning="no constant force is left in the residuals"
        if good
        else f"a constant force of {said} is left in the residuals: {_whose(force, law, gain)}",
    )


def ripple_check(judged: Estimate, signals: Signals, prefilter: Prefilter) -> Check:
    """Whether one frequency, over time or over the position, stands out of the residuals."""
    if len(judged.y) < _FEWEST:
        return Check.missing(_RIPPLE, f"{len(judged.y)} rows are too few for a spectrum")
    residuals = judged.residuals - np.mean(judged.residuals)  # a constant has a check of its own
    time = _over_time(judged, signals, residuals)
    place = _over_position(judged, signals, residuals)
    line = max((each for each in (time, place) if each), key=lambda line: line.share, default=None)
    return Check(
        name=_RIPPLE,
        status=passed(line is None, matters=False),
        figure=None if line is None else 100 * line.share,
        threshold=100 * _LINE,
        source="percent of the residuals' power that one frequency has, over time beyond eight "
        "times the rate of reversals, or over the position; it stands out of its neighbours but "
        "for a chance of 1e-4",
        meaning="no frequency stands out of the residuals"
        if line is None
        else _by_position(line, judged)
        if line is place
        else _by_time(line, judged, prefilter),
    )


def _constant(judged: Estimate, weights: Array) -> tuple[float, float] | None:
    """A constant force with its deviation, estimated beside the parameters; None for nothing."""
    y = judged.residuals + judged.X @ judged.theta
    names = [*(q.name for q in judged.quantities), _CONSTANT]
    try:
        columns = np.column_stack([judged.X, weights])
        regressor = factor(columns, names, neighbours=judged.neighbours)
        if judged.Z is None:
            solution = least_squares(y, regressor)
        else:
            instruments = factor(np.column_stack([judged.Z, weights]), names, "the simulated loop")
            solution = instrumental_variables(y, regressor, instruments)
    except EstimationError:
        return None
    covariance = judged.assumed.matrix(solution)
    return float(solution.theta[-1]), float(np.sqrt(covariance[-1, -1]))


def _whose(force: float, law: LawCheck | Missing, gain: float) -> str:
    """Where a constant comes from, and what to do."""
    recorded = None if isinstance(law, Missing) else law.constant
    if recorded is not None and abs(gain * recorded - force) < _SAME * abs(force):
        return (
            f"it is in the recorded control ({recorded:.3g}) and not in the law, so the converter "
            "that records it is off; take that off the control"
        )
    return (
        f"declare an offset (offset(F0), F0 about {force:.3g}), or what depends on the position "
        "and has such a mean; or check the zero of what records the force"
    )


def _over_time(judged: Estimate, signals: Signals, residuals: Array) -> Line | None:
    rows = judged.rows.astype(int)
    step = int(np.diff(rows).min())
    places = (rows - rows[0]) // step
    values = np.zeros(int(places[-1]) + 1)
    values[places] = residuals
    size = 2 * len(values)
    power = np.abs(np.fft.rfft(values, size)) ** 2
    frequencies = np.arange(len(power)) / (size * step * judged.period)
    turns = np.count_nonzero(np.diff(np.sign(signals.velocity[rows])))
    lasting = (rows[-1] - rows[0]) * judged.period
    return _line(frequencies, power, residuals, _REVERSALS * turns / (2 * lasting))


def _over_position(judged: Estimate, signals: Signals, residuals: Array) -> Line | None:
    rows = judged.rows.astype(int)
    chosen = rows[:: max(len(rows) // _MOST_ROWS, 1)]
    position = signals.position[chosen]
    apart = float(np.median(np.abs(signals.velocity[chosen])) * np.diff(rows).min() * judged.period)
    travel = float(np.ptp(position))
    most = min(2 * _MOST_CYCLES, int(travel / max(apart, travel / (2 * _MOST_CYCLES))))
    frequencies = np.arange(1, most) / (2 * travel)
    waves = np.exp(-2j * np.pi * np.outer(frequencies, position))
    values = residuals[:: max(len(rows) // _MOST_ROWS, 1)]
    return _line(frequencies, np.abs(waves @ values) ** 2, values, _REVERSALS / travel)


def _line(frequencies: Array, power: Array, values: Array, lowest: float) -> Line | None:
    """The strongest frequency beyond the lowest, if it stands out of its neighbours."""
    beyond = frequencies >= lowest
    if beyond.sum() < _NEIGHBOURS:
        return None
    best = int(np.argmax(np.where(beyond, power, 0.0)))
    first = max(best - _NEIGHBOURS // 2, 0)
    around = np.r_[first : max(best - _OWN, 0), best + _OWN + 1 : best + _NEIGHBOURS // 2 + 1]
    background = float(np.median(power[around[around < len(power)]]))
    total = float(values @ values)
    share = min(2 * float(power[best]) / (len(values) * total), 1.0)
    chance = len(frequencies) * 0.5 ** (float(power[best]) / background) if background else 0.0
    if share < _LINE or chance > _BY_CHANCE:
        return None
    return Line(float(frequencies[best]), float(np.sqrt(2 * share * total / len(values))), share)


def _by_time(line: Line, judged: Estimate, prefilter: Prefilter) -> str:
    unit = "" if judged.ddm_quantities else f" {judged.form.axis.axis.coordinate.force_unit}"
    return (
        f"a ripple of {line.frequency:.3g} Hz is {100 * line.share:.0f} % of the residuals' power, "
        f"with an amplitude of {line.amplitude:.2g}{unit}: a cut-off of "
        f"{_BELOW * line.frequency:.2g} Hz (it is {prefilter.cutoff:g} Hz) leaves it out, if the "
        "motion is slow against that; otherwise find what vibrates, or the mains"
    )


def _by_position(line: Line, judged: Estimate) -> str:
    unit, period = judged.form.axis.axis.coordinate.unit, 1 / line.frequency
    return (
        f"a ripple over the position, every {period:.3g} {unit}, is {100 * line.share:.0f} % of "
        f"the residuals' power: declare it, cogging(a, b, q, period={period:.3g}), or "
        "periodic_coulomb where it changes with the direction"
    )
