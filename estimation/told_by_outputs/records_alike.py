"""Whether records that were fitted together are of one machine, by the errors of their outputs.

A parameter that is another in one record leaves errors there that its slopes in that record alone
explain, less what all parameters make of them. They are tested as any force beside the model is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check
from axisid.estimation.thresholds import MAX_RECORD_CHANCE, MIN_RECORD_SHARE
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .missing import Left, lacking_of

_NAME = "records alike"
_MOST = 3  # differences that are told


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherInRecord:
    """A parameter that is another in one record than in the others.

    Attributes
    ----------
    record : int
    place : int
        Of the parameter.
    more, deviation : float
        By how much it is more there, in its unit.
    chance : float
        That records of one machine differ as much, over all that was tested.
    share_percent : float
        What the difference changes of the record's outputs, percent of what the largest of the
        parameters makes of them.
    """

    record: int
    place: int
    more: float
    deviation: float
    chance: float
    share_percent: float


def others_in_records(
    left: Left, slopes: Array, physical: Array, shared: NDArray[np.bool_]
) -> tuple[OtherInRecord, ...] | Missing:
    """Parameters that are others in a record, the surest first; that one whether it is or not.

    Parameters
    ----------
    left : Left
    slopes : (n, P) array
        Of the errors by the parameters; not weighted.
    physical : (P,) array
    shared : (P,) array of bool
        Which parameters are asked for.
    """
    places = np.flatnonzero(shared)
    asked = [(record, int(j)) for record in range(len(left.spans)) for j in places]
    columns = np.zeros((len(slopes), len(asked)))
    for k, (record, j) in enumerate(asked):
        for rows in left.spans[record]:
            columns[rows, k] = slopes[rows, j]
    found = lacking_of(left, columns, _MOST, MAX_RECORD_CHANCE.value)
    if not found:
        return Missing("no record alone tells a parameter from the others'")
    made = left.weights[:, None] * slopes * physical
    others = []
    for each in found:
        record, j = asked[each.number]
        largest = max(float(np.linalg.norm(_of(made, left, record), axis=0).max()), 1e-300)
        change = each.factor * np.linalg.norm(left.weights * columns[:, each.number])
        others.append(
            OtherInRecord(
                record=record,
                place=j,
                more=each.factor,
                deviation=each.deviation,
                chance=each.chance,
                share_percent=100 * abs(float(change)) / largest,
            )
        )
    return tuple(others)


def _of(columns: Array, left: Left, record: int) -> Array:
    return np.concatenate([columns[rows] for rows in left.spans[record]])


def alike_by_outputs(
    found: tuple[OtherInRecord, ...] | Missing,
    names: Sequence[str],
    units: Sequence[str],
    records: int,
) -> Check:
    """Whether so many records are alike, as a check; parameters have names and units."""
    if isinstance(found, Missing):
        return Check.not_evaluated(_NAME, found)
    there = [each for each in found if each.chance <= MAX_RECORD_CHANCE.value]
    large = [each for each in there if each.share_percent > MIN_RECORD_SHARE.value]
    return Check(
        name=_NAME,
        status="fail" if large else "note" if there else "pass",
        figure=max(each.share_percent for each in found),
        threshold=MIN_RECORD_SHARE.value,
        p_value=found[0].chance,
        source="percent that a parameter of a record's own changes of its output, by what the "
        "largest parameter makes of it; fails where that is more, and chance would make as much in "
        "less than 1 % (allowed for the number of parameters and records)",
        meaning=_meaning(there, large, names, units, records),
        remedy=_remedy(large, names) if large else None,
    )


def _meaning(
    there: Sequence[OtherInRecord],
    large: Sequence[OtherInRecord],
    names: Sequence[str],
    units: Sequence[str],
    records: int,
) -> str:
    if not there:
        return "no record asks for another parameter than the others, but for chance"
    said = "; ".join(
        f"{names[each.place]} is {abs(each.more):.3g} +- {each.deviation:.1g} {units[each.place]} "
        f"{'more' if each.more > 0 else 'less'} in record {each.record + 1} than in "
        f"{f'record {2 - each.record}' if records == 2 else 'the others'}"
        for each in large or there
    )
    if large:
        return (
            f"the records are not of one machine as it is declared: {said}. What is found of all "
            "is no record's, nor need the other parameters be"
        )
    return (
        f"the records differ by more than chance, in what makes less than "
        f"{MIN_RECORD_SHARE.value:g} % of the output: {said}"
    )


def _remedy(large: Sequence[OtherInRecord], names: Sequence[str]) -> Remedy:
    differing = ",".join(dict.fromkeys(names[each.place] for each in large))
    return Remedy.of(
        "; say what is known to differ, as a payload that the axis declares (",
        Setting("known", "NAME=V1,V2"),
        "), or let each record have its own (",
        Setting("local", differing),
        ")",
    )
