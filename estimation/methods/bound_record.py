"""Reversals and rests as the simulated loop has them.

Where a motion turns or rests, noise decides the sign of the measured velocity: it makes reversals
where there are none, hides rests, and so chooses the rows by what is to be regressed. The loop that
is simulated with least squares turns where the axis does, and has no noise.
"""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import mean_until_next
from axisid.estimation.problems import Problem
from axisid.estimation.records import Record
from axisid.estimation.regression import simulated_position
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.errors import AxisidError

from .methods import METHODS


def bound_record(
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
    data = data.with_mean_control(mean_until_next(axis, record))
    if data.prefilter.reversals != "leave-out" or record.reference is None:
        return data
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused where it is estimated
            fit = METHODS["idm-ls"].fit(Problem(axis=axis, data=(data,)))
            return data.turning_as(simulated_position(fit.loops)) if fit.follows else data
    except AxisidError:
        return data  # whoever asks for an estimate is told why there is none
