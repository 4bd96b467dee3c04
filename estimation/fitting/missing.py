"""What the model of a fit lacks: the rows of its records, and of their twins, as identified ones.

What a model lacks is no matter of what is followed: the residuals of instruments at the fit's
parameters tell it, whatever output these are of.
"""

from collections.abc import Collection, Mapping
from contextlib import suppress

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Levels
from axisid.estimation.lacking import Lack, found_beside, scores_of
from axisid.estimation.methods import bound_record
from axisid.estimation.records import Record
from axisid.estimation.regression import recorded_loops
from axisid.estimation.signals import Prefilter
from axisid.estimation.twins import measured_chain
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError
from axisid.support.missing import Missing


def missing_of(
    axis: GeneratedAxis,
    record: Record,
    physical: Array,
    half_widths: Mapping[str, float],
    held: Collection[str],
    records: int,
    levels: Levels,
) -> tuple[Lack, ...] | Missing:
    """What is found beside the model of one record.

    Parameters
    ----------
    axis : GeneratedAxis
        Of the record, under the law that was found.
    record : Record
    physical : (p,) array
        Its parameters.
    half_widths : mapping of str to float
        Of their intervals, by name; none of what has no interval.
    held : collection of str
        Names of those that the record did not tell.
    records : int
        How many there are.
    levels : Levels
    """
    if axis.axis.states:
        return Missing("friction that remembers has no rows in which that could be looked for")
    data = bound_record(axis, record, Prefilter())
    data = data.by_position or data
    chain = None
    with suppress(AxisidError):
        chain = measured_chain(data, physical, recorded_loops(data, physical))
    names = [q.name for q in axis.parameters]
    free = [j for j, name in enumerate(names) if name not in held]
    scores = scores_of(data, physical, chain, free)
    if isinstance(scores, Missing):
        return scores
    half = np.array([half_widths.get(name, np.inf) for name in names])
    return found_beside(scores, half, records, levels)
