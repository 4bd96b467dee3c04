"""What a result of several records says of each of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import Problem
from axisid.estimation.records import Record, record_labels
from axisid.estimation.signals import Sampling
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

#: A record, or what a file holds of one: what is told of it, without its samples.
RecordInfo: TypeAlias = Record | Any


@dataclass(frozen=True, slots=True, kw_only=True)
class OfRecord:
    """One of several records in a result, by the estimate that is judged.

    Attributes
    ----------
    name : str
    record : RecordInfo
    sampling : Sampling
    known : mapping of str to (float, float)
        What is known of it, with its standard deviation, SI.
    rows : int
    weight : float
        Of its rows, 1 for a record of the mean noise.
    noise : float
        Root mean square of the residuals, in the unit of the left side.
    equation_error_percent : float
    simulation_error_percent : float or None
    share_percent : float or None
        Force that the parameters it has alone make otherwise than those of all; None where it alone
        does not tell them.
    p_value : float or None
        That chance alone makes as much.
    """

    name: str
    record: RecordInfo
    sampling: Sampling
    known: Mapping[str, tuple[float, float]]
    rows: int
    weight: float
    noise: float
    equation_error_percent: float
    simulation_error_percent: float | None
    share_percent: float | None
    p_value: float | None


def record_place(number: object, records: int) -> int:
    """Where one of several records is, by its number from 1; one by itself is the first.

    Raises
    ------
    UsageError
        There is no such record.
    """
    count = max(records, 1)
    if not is_whole(number) or not 1 <= number <= count:
        there = "there is 1" if count == 1 else f"there are {count}, numbered from 1"
        raise UsageError(
            f"the result has no record {quoted(number)}; {there}.", code="no-record-of-result"
        )
    return int(number) - 1


def of_records(
    problem: Problem, parts: tuple[Estimate, ...], diagnosis: Diagnosis
) -> tuple[OfRecord, ...]:
    """What there is to say of each record; empty for one by itself.

    Parameters
    ----------
    problem : Problem
    parts : tuple of Estimate
        The judged estimate, as each record has it.
    diagnosis : Diagnosis
    """
    if not diagnosis.records:
        return ()
    names = record_labels([data.record for data in problem.data])
    layout = problem.layout
    found = []
    for i, (data, part) in enumerate(zip(problem.data, parts, strict=True)):
        apart = diagnosis.records[i].apart
        told = None if isinstance(apart, Missing) else apart
        known = () if layout is None else layout.known
        found.append(
            OfRecord(
                name=names[i],
                record=data.record,
                sampling=data.sampling,
                known={each.name: (each.values[i], each.deviations[i]) for each in known},
                rows=len(part.y),
                weight=problem.weights[i] if problem.weights else 1.0,
                noise=float(np.linalg.norm(part.residuals)) / max(len(part.y), 1) ** 0.5,
                equation_error_percent=part.equation_error_percent,
                simulation_error_percent=part.simulation_error_percent,
                share_percent=None if told is None else told.share_percent,
                p_value=None if told is None else told.p_value,
            )
        )
    return tuple(found)
