"""A record under its filter, as methods have it: turns and means by the loop that it tells.

Where a motion turns or rests, noise decides the sign of the measured velocity: it makes reversals
where there are none, hides rests, and so chooses the rows by what is to be regressed. The loop that
is simulated with least squares turns where the axis does, and has no noise.
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
    """A record under a filter, its reversals those of the simulated loop where that follows it.

    `fastest` is the largest speed of the records beside it, see `FilteredRecord`.

    Raises
    ------
    UsageError, DataError
        As `FilteredRecord.bind` does.
    """
    data = FilteredRecord.bind(axis, record, prefilter, fastest)
    data = data.with_mean_control(_mean_until_next(axis, record))
    if data.prefilter.reversals != "leave-out" or record.reference is None:
        return data
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused where it is estimated
            fit = METHODS["idm-ls"].fit(Problem(axis=axis, data=(data,)))
            return data.turning_as(simulated_position(fit.loops)) if fit.follows else data
    except AxisidError:
        return data  # whoever asks for an estimate is told why there is none


def _mean_until_next(axis: GeneratedAxis, record: Record) -> Array | None:
    """By how much the mean of the control until the next sample is more than that at each, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record

    Returns
    -------
    (N,) array or None
        None where the law is evaluated at the samples or seldomer, where the reference is not held
        between them, so that the control is no sawtooth, or where the law cannot be run.
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
        # Each is held until the next evaluation; the last beyond the last sample.
        edges = np.append(clocks.times, clocks.times[-1] + clocks.law_period / clocks.log_period)
        until = np.concatenate([[0.0], np.cumsum(control * np.diff(edges))])
        mean = np.diff(np.interp(np.arange(clocks.samples + 1), edges, until))
        mean[-1] = control[ticks.held[-1]]  # it goes on beyond the record
        change = mean - control[ticks.held]
        pieces.append(np.where(np.isfinite(change), change, 0.0))
    return np.concatenate(pieces)
