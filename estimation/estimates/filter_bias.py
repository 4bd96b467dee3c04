"""How the prefilter biases an estimate, and how it depends on the drive gain.

Both keep the instruments: only what was measured is changed.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.estimation.regression import (
    Factored,
    Form,
    factor,
    instrumental_variables,
    least_squares,
    simulated_position,
)
from axisid.estimation.signals import FilteredRecord, Signals
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array

_STEP = 1e-4  # of the gain


def filter_bias(
    form: Form,
    data: FilteredRecord,
    loops: Sequence[Simulation],
    physical: Array,
    instruments: Factored | None,
) -> Array:
    """What filtering, differencing and decimation alone move the estimate by, (p,).

    The loops simulated with the estimate are a record without noise, delay or unknown friction;
    what the same filter and estimator make of it should be the estimate. Mostly it is rounding
    where friction reverses that moves it.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    data : FilteredRecord
        What the estimate was made from.
    loops : sequence of Simulation
        Of the record's reference, with `physical`; one for each segment.
    physical : (p,) array
    instruments : Factored or None
        Of the estimate; None for least squares.
    """
    record = data.record
    noise_free = replace(
        record,
        position=simulated_position(loops),
        control=None if record.control is None else np.concatenate([s.control for s in loops]),
        force=None if record.force is None else np.concatenate([s.force for s in loops]),
    )
    # Rows are those of the estimate, whose instruments they are held against.
    signals = replace(data, record=noise_free).signals
    theta = _solved(form, signals, data, instruments)
    return np.asarray(form.physical(theta)[0] - physical, dtype=float)


def slopes_by_gain(
    form: Form, data: FilteredRecord, instruments: Factored | None
) -> tuple[Array, Array]:
    """Slopes of the physical parameters, (p,), and of the regression's, (k,), by ln(gain).

    Without known terms every linear parameter is proportional to the gain; a known term keeps its
    size, so that the others take what it leaves.
    """
    signals = data.signals
    ahead, behind = (
        _solved(form, replace(signals, force=signals.force * scale), data, instruments)
        for scale in (1 + _STEP, 1 - _STEP)
    )
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _STEP), (ahead - behind) / (2 * _STEP)


def _solved(
    form: Form, signals: Signals, data: FilteredRecord, instruments: Factored | None
) -> Array:
    rows = form.equations(signals).reduced(data.prefilter, data.period)
    regressor = factor(rows.regressor, [q.expression or q.name for q in form.quantities])
    left = rows.left - rows.known
    if instruments is None:
        return least_squares(left, regressor).theta
    return instrumental_variables(left, regressor, instruments).theta
