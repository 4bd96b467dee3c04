"""Twins of a fit: its loops with the noise that is measured in the records, and what they tell."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import is_

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.predictions import Predictions, record_rows
from axisid.estimation.problems import noise_free_record
from axisid.estimation.records import Record
from axisid.estimation.regression import Hac, recorded_loops, score_products
from axisid.estimation.signals import FilteredRecord, Prefilter, RowTimes
from axisid.estimation.twins import Chain, measured_chain, twins_of
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

from .spread import Scores


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordLoops:
    """A record's loops at a fit, and the noise that it has beside them.

    Attributes
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of its axis.
    chain : Chain
    quiet : Record
        The same without noise.
    """

    data: FilteredRecord
    physical: Array
    chain: Chain
    quiet: Record

    @classmethod
    def at(cls, axis: GeneratedAxis, record: Record, physical: Array) -> "RecordLoops":
        """Simulate the loops of a record, and measure its noise.

        Raises
        ------
        EstimationError
            There are too few rows, or its loops cannot be simulated.
        """
        # Friction that remembers has no rows near turns that others would do without.
        prefilter = Prefilter(reversals="keep" if axis.states else None)
        data = FilteredRecord.bind(axis, record, prefilter)
        data = data.by_position or data
        loops = recorded_loops(data, physical)
        chain, quiet = measured_chain(data, physical, loops), noise_free_record(data, loops).record
        return cls(data=data, physical=physical, chain=chain, quiet=quiet)

    def twins(self, chain: Chain, count: int, *, paired: bool) -> list[Record]:
        """As many with a chain's noise as can be simulated; of a silent one all are quiet."""
        if chain.is_silent:
            return [self.quiet] * count
        drawn = twins_of(self.data, self.physical, chain, count, paired=paired)
        return [each.record for each in drawn]


def outputs_by_noise(
    records: Sequence[RecordLoops | Missing],
    physical: Array,
    predictions: Predictions,
    count: int,
    *,
    disturbed: bool,
    paired: bool,
) -> Array:
    """What the noise of records makes of the outputs of a fit, (n, R).

    Parameters
    ----------
    records : sequence of RecordLoops or Missing
    physical : (P,) array
    predictions : Predictions
        Of the records, settled there.
    count : int
    disturbed : bool
        Whether twins have the forces beside the control, or the noise of what is measured alone.
    paired : bool
        Whether they come in pairs of opposite noise.

    Raises
    ------
    EstimationError
        A record's noise could not be measured, or more than half of the twins cannot be simulated.
    """
    twins: list[list[Record]] = []
    quiet: list[Record] = []
    for of in records:
        if isinstance(of, Missing):
            raise EstimationError(of.reason, code="noise")
        chain = of.chain if disturbed else replace(of.chain.likeliest, disturbances=())
        twins.append(of.twins(chain, count, paired=paired))
        quiet.append(of.quiet)
    fewest = min(map(len, twins))
    if 2 * fewest < count:
        raise EstimationError(
            f"{fewest} of {count} twins could be simulated with the noise of the records; leave "
            "the bootstrap out.",
            code="noise",
        )
    still = predictions.outputs_of(quiet, physical)
    # As many of each record as the one with the fewest has.
    rows = [
        still if all(map(is_, each, quiet)) else predictions.outputs_of(each, physical)
        for each in zip(*twins, strict=False)
    ]
    return np.reshape(rows, (-1, len(still))).T - still[:, None]


def calibrated_covariance(scores: Scores, errors: Array, moved: Array, left: Array) -> Array:
    """Covariance of parameters, (k, k), by twins, the HAC covariance of scores as the pivot.

    Parameters
    ----------
    scores : Scores
    errors : (n,) array
        Weighted, of the records.
    moved : (k, R) array
        What noise moves the parameters by.
    left : (n, R) array
        Weighted errors of the twins, less what their parameters make of them.
    """
    every = np.arange(len(errors))
    pieces = [every[own][scores.counted[own]] for own in map(record_rows, scores.spans)]
    neighbours = RowTimes.joined([RowTimes(each) for each in pieces])
    chosen = np.concatenate(pieces)
    columns = scores.jacobian[chosen] @ scores.inverse

    def deviations(errors: Array) -> Array:
        products = partial(score_products, columns * errors[chosen, None], neighbours)
        return np.sqrt(np.maximum(np.diag(Hac().of_scores(products, columns.shape).matrix), 0.0))

    own, twins = deviations(errors), np.array([*map(deviations, left.T)])
    apart = (moved.T - moved.mean(axis=1)) / np.where(twins > 0, twins, np.inf)
    return np.asarray(np.cov((apart * own).T).reshape(len(own), -1))
