"""Twins of a fit: its loops with the noise that is measured in the records, and what they tell."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, Hac, Solution, simulated_loops
from axisid.estimation.signals import FilteredRecord, Neighbours, Prefilter
from axisid.estimation.twins import Chain, measured_chain, twins_of
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .spread import Scores


@dataclass(frozen=True, slots=True, kw_only=True)
class FitTwins:
    """What noise makes of the outputs of a fit.

    Attributes
    ----------
    changed : (n, R) array
        Outputs of the twins, less those of the loops without noise.
    chains : tuple of Chain
        One for each record.
    """

    changed: Array
    chains: tuple[Chain, ...]

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.changed.shape[1])


def fit_twins(
    form: Form,
    axes: Sequence[GeneratedAxis],
    records: Sequence[Record],
    physical: Array,
    outputs: Sequence[str],
    count: int,
) -> FitTwins:
    """Measure the noise of the records at a fit, and simulate their loops with it.

    Parameters
    ----------
    form : Form
        Says which parameters of its axis each record has.
    axes : sequence of GeneratedAxis
        By record.
    records : sequence of Record
    physical : (P,) array
    outputs : sequence of str
        That are followed, each a column of the records.
    count : int

    Raises
    ------
    EstimationError
        More than half of the twins cannot be simulated.
    """
    pieces, chains = [], []
    for place, (axis, record) in enumerate(zip(axes, records, strict=True)):
        data, own = FilteredRecord.bind(axis, record, Prefilter()), form.own(physical, place)
        data = data.by_position or data
        loops = simulated_loops(axis, record, own)
        chain = measured_chain(data, own, loops)
        twins = [_rows(each.record, outputs) for each in twins_of(data, own, chain, count)]
        quiet = np.stack(
            [np.concatenate([getattr(loop, name) for loop in loops]) for name in outputs], axis=1
        ).ravel()
        pieces.append([each - quiet for each in twins])
        chains.append(chain)
    fewest = min(map(len, pieces))
    if 2 * fewest < count:
        raise EstimationError(
            f"{fewest} of {count} twins could be simulated with the noise of the records; leave "
            "the bootstrap out.",
            code="bootstrap-lost",
        )
    changed = np.concatenate([np.column_stack(piece[:fewest]) for piece in pieces])
    return FitTwins(changed=changed, chains=tuple(chains))


def _rows(record: Record, outputs: Sequence[str]) -> Array:
    """Outputs sample by sample, as fits have them."""
    columns = np.stack([getattr(record, name) for name in outputs], axis=1)
    return np.concatenate([columns[first:last].ravel() for first, last in record.spans])


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
    own, count = _hac_deviations(scores, errors), moved.shape[1]
    twins = np.array([_hac_deviations(scores, each) for each in left.T])
    apart = (moved.T - moved.mean(axis=1)) / np.where(twins > 0, twins, np.inf)
    return np.asarray(np.cov((apart * own).T).reshape(len(own), -1) * (1 + 1 / count))


def _hac_deviations(scores: Scores, errors: Array) -> Array:
    """Of the parameters of scores for errors (n,) that are autocorrelated, (k,)."""
    rows = scores.counted
    pieces = [np.arange(*_ends(spans))[rows[slice(*_ends(spans))]] for spans in scores.spans]
    neighbours = Neighbours.joined([Neighbours.of(piece, 1) for piece in pieces])
    chosen = np.concatenate(pieces)
    solution = Solution(
        theta=np.zeros(len(scores.inverse)),
        residuals=errors[chosen],
        inverse_factor=scores.inverse,
        influence=scores.jacobian[chosen] @ scores.inverse,
        neighbours=neighbours,
    )
    return np.sqrt(np.maximum(np.diag(Hac(widened=False).matrix(solution)), 0.0))


def _ends(spans: Sequence[slice]) -> tuple[int, int]:
    return spans[0].start, spans[-1].stop
