"""Filtered record for the methods, with reversals and mean controls of its simulated loop.

Where a motion reverses or rests, noise decides the sign of the measured velocity. It makes false
reversals and hides rests, and so selects the rows by the quantity that is regressed. The loop that
is simulated with least squares reverses where the axis does, and has no noise.
"""

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.law_replay import control_at_ticks, law_ticks, start_of_law, two_clocks
from axisid.estimation.records import Record
from axisid.estimation.regression import simulated_position
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .methods import METHODS


def filtered_record(
    axis: GeneratedAxis, record: Record, prefilter: Prefilter, fastest: float = 0.0
) -> FilteredRecord:
    """Return a filtered record, with the reversals of the simulated loop if it follows the record.

    The loop is simulated with least squares. The reversals matter only where samples near them are
    left out. Without a reference, or where the loop cannot be simulated or does not follow the
    record, the reversals are those of the record.

    `fastest` is the largest speed of all records that are used together, see `FilteredRecord`.

    Raises
    ------
    UsageError, DataError
        As in `FilteredRecord.bind`.
    """
    data = FilteredRecord.bind(axis, record, prefilter, fastest)
    data = data.with_mean_control(_mean_until_next(axis, record))
    if data.prefilter.reversals != "leave-out" or record.reference is None:
        return data
    try:
        with np.errstate(all="ignore"):  # estimation refuses values that are not finite
            fit = METHODS["idm-ls"].fit(Problem(axis=axis, data=(data,)))
            return data.turning_as(simulated_position(fit.loops)) if fit.follows else data
    except AxisidError:
        return data  # estimation reports the reason


def _mean_until_next(axis: GeneratedAxis, record: Record) -> Array | None:
    """Return the mean control until the next sample minus the control at each sample, (N,).

    A law that runs faster than the log changes its control between the samples. The law is replayed
    along the record, and its control is averaged over each sample period.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record

    Returns
    -------
    (N,) array or None
        None where the law is evaluated at the samples or less often, where the reference is not
        held between samples, so that the control is no sawtooth, or where the law cannot be run.
    """
    law = axis.control
    if law is None or record.reference is None or record.control is None:
        return None
    pieces = []
    for span in record.spans:
        clocks = two_clocks(axis, record, span)
        if clocks is None or clocks.between != "held" or clocks.law_period > clocks.log_period:
            return None
        ticks = law_ticks(axis, record, span)
        control = control_at_ticks(axis, ticks, start_of_law(axis, record, span, ticks))
        # Each control is held until the next evaluation, the last one beyond the last sample. Times
        # are in samples of the log; the mean is the difference of the integral of the control.
        edges = np.append(clocks.times, clocks.times[-1] + clocks.law_period / clocks.log_period)
        integral = np.concatenate([[0.0], np.cumsum(control * np.diff(edges))])
        mean = np.diff(np.interp(np.arange(clocks.samples + 1), edges, integral))
        mean[-1] = control[ticks.held[-1]]  # the last control is held beyond the record
        change = mean - control[ticks.held]
        pieces.append(np.where(np.isfinite(change), change, 0.0))
    return np.concatenate(pieces)
