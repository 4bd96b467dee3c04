"""What a control law that is not the drive's moves an output-error estimate by.

The simulated loop answers to a law that is a little other as to what that adds to its control: each
term of the law with a factor of ``1 + eps`` is the loop with ``eps`` times that term injected. So
two lanes a term tell the slopes of the outputs, and with them what every percent of a term moves
each parameter by.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import ndtri, stdtrit

from axisid.estimation.diagnostics.law import FoundGains, LawCheck, check_found_law
from axisid.estimation.predictions import Predictions, record_rows
from axisid.support.arrays import Array
from axisid.support.errors import Missing

from .twins import RecordLoops

_PERCENT = 0.01
_TWINS = 8
_LEVEL = 0.975  # at which eight twins are as sure as the normal law has it


def moves_per_percent(
    predictions: Predictions, physical: Array, influence: Array
) -> tuple[Mapping[str, Array], ...]:
    """What each term of a record's law, 1 % larger, moves the parameters by, (P,), by its gains.

    Parameters
    ----------
    predictions : Predictions
    physical : (P,) array
        The estimate.
    influence : (P, n) array
        Of the errors on the estimate.

    Returns
    -------
    tuple of mapping of str to (P,) array
        By record.
    """
    slopes = predictions.slopes_by_law(physical)
    return tuple(
        {name: -_PERCENT * (influence[:, rows] @ slope[rows]) for name, slope in slopes.items()}
        for rows in map(record_rows, predictions.spans)
    )


def factors_in_twins(
    law: LawCheck | Missing, loops: RecordLoops | Missing, found: FoundGains
) -> list[Mapping[str, float]]:
    """Factors that the law has in twins, which are under the declared one; none without twins.

    A control that answers to noise within a sample is no sum of its terms, and HAC deviations know
    of what stands in the rows alone.

    Parameters
    ----------
    law : LawCheck or Missing
    loops : RecordLoops or Missing
        Of the record.
    found : FoundGains
    """
    if not isinstance(law, LawCheck) or not law.factors:
        return []
    if isinstance(loops, Missing) or loops.chain.is_silent:
        return []
    twins = loops.twins(loops.chain, _TWINS, paired=False)
    checked = (check_found_law(loops.data.axis, twin, found) for twin in twins)
    every = [each.factors for each in checked if isinstance(each, LawCheck)]
    told: list[Mapping[str, float]] = [f for f in every if f.keys() == law.factors.keys()]
    return told if 2 * len(told) >= _TWINS else []


def move_by_record(
    of_records: Sequence[Mapping[str, Array]],
    laws: Sequence[LawCheck | Missing],
    in_twins: Sequence[Sequence[Mapping[str, float]]] = (),
) -> tuple[Array, Array] | None:
    """What the law as the records have it, less the declared one, moves the parameters by, (P,).

    Each record moves them by its own factors, less what those of its twins do in the mean; one that
    does not tell them is taken for the mean of those that do.

    Parameters
    ----------
    of_records : sequence of mapping of str to (P,) array
        As `moves_per_percent` has it.
    laws : sequence of LawCheck or Missing
    in_twins : sequence of sequence of mapping of str to float
        Factors in each record's twins; by HAC where there are none.

    Returns
    -------
    ((P,) array, (P,) array) or None
        With its deviations, of how sure the factors are. None where no record tells the law's
        factors, or only those of another sign.
    """
    names = [*of_records[0]]
    told = [law.factors if isinstance(law, LawCheck) else {} for law in laws]
    # Of a law with another sign, straight lines from the declared one tell nothing.
    told = [f if all(f.get(name, 0.0) > 0 for name in names) else {} for f in told]
    telling = [factors for factors in told if factors]
    if not telling or not names:
        return None
    mean = {name: float(np.mean([each[name] for each in telling])) for name in names}
    moved, variances = [], []
    every = zip(of_records, told, laws, in_twins or [[]] * len(laws), strict=True)
    for moves, factors, law, twins in every:
        of_twins = [_moved_by(moves, each) for each in twins]
        by_chance = np.mean(of_twins, axis=0) if twins else 0.0
        moved.append(_moved_by(moves, factors or mean) - by_chance)
        if twins:
            count = len(twins)
            widened = (1 + 1 / count) * (stdtrit(count - 1, _LEVEL) / ndtri(_LEVEL)) ** 2
            variances.append(widened * np.var(of_twins, axis=0, ddof=1))
        elif isinstance(law, LawCheck):
            sure = [moves[n] * law.deviations.get(n, 0.0) / _PERCENT for n in names]
            variances.append(np.sum(np.square(sure), axis=0))
    return np.asarray(np.sum(moved, axis=0)), np.sqrt(np.sum(variances, axis=0))


def _moved_by(moves: Mapping[str, Array], factors: Mapping[str, float]) -> Array:
    return np.asarray(
        np.sum([moves[name] * (factors[name] - 1) / _PERCENT for name in moves], axis=0)
    )
