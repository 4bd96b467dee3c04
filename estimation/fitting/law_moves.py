"""What a control law that is not the drive's moves an output-error estimate by.

The simulated loop answers to a law that is a little other as to what that adds to its control: each
term of the law with a factor of ``1 + eps`` is the loop with ``eps`` times that term injected. So
two lanes a term tell the slopes of the outputs, and with them what every percent of a term moves
each parameter by.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics.law import FoundGains, LawCheck, check_found_law
from axisid.estimation.methods import bound_record
from axisid.estimation.predictions import Predictions, record_rows
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.twins import Chain, twins_of
from axisid.support.arrays import Array
from axisid.support.missing import Missing

_PERCENT = 0.01
_TWINS = 8


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


def moves_of_all(of_records: Sequence[Mapping[str, Array]]) -> Mapping[str, Array]:
    """What each term, 1 % larger in all records, moves the parameters by, (P,), by its gains."""
    return {
        name: np.asarray(np.sum([moves[name] for moves in of_records], axis=0))
        for name in of_records[0]
    }


def spread_in_twins(
    law: LawCheck | Missing,
    axis: GeneratedAxis,
    record: Record,
    physical: Array,
    found: FoundGains,
    chain: Chain | None,
) -> LawCheck | Missing:
    """A law whose factors are as sure as those of twins, which are under the declared one, are.

    A control that answers to noise within a sample is no sum of its terms, and HAC deviations know
    of what stands in the rows alone. They remain where there are no twins.

    Parameters
    ----------
    law : LawCheck or Missing
    axis : GeneratedAxis
        Of the record.
    record : Record
    physical : (p,) array
        Its parameters.
    found : FoundGains
    chain : Chain or None
        The record's noise.
    """
    if not isinstance(law, LawCheck) or not law.factors or chain is None:
        return law
    twins = twins_of(bound_record(axis, record, Prefilter()), physical, chain, _TWINS)
    checked = (check_found_law(axis, twin.record, found) for twin in twins)
    told = [each.factors for each in checked if isinstance(each, LawCheck)]
    told = [each for each in told if each.keys() == law.factors.keys()]
    if 2 * len(told) < _TWINS:
        return law
    away = {name: np.array([each[name] - 1 for each in told]) for name in law.factors}
    spread = {name: float(np.sqrt(np.mean(each**2))) for name, each in away.items()}
    least = law.deviations
    return replace(law, deviations={n: max(s, least.get(n, 0.0)) for n, s in spread.items()})


def move_by_record(
    of_records: Sequence[Mapping[str, Array]], laws: Sequence[LawCheck | Missing]
) -> tuple[Array, Array] | None:
    """What the law as the records have it, less the declared one, moves the parameters by, (P,).

    Each record moves them by its own factors; one that does not tell them is taken for the mean of
    those that do.

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
    for moves, factors, law in zip(of_records, told, laws, strict=True):
        sure = law.deviations if isinstance(law, LawCheck) else {}
        for name in names:
            moved.append(moves[name] * ((factors or mean)[name] - 1) / _PERCENT)
            variances.append((moves[name] * sure.get(name, 0.0) / _PERCENT) ** 2)
    return np.asarray(np.sum(moved, axis=0)), np.sqrt(np.sum(variances, axis=0))
