"""Records under their filters as one problem: what they share, their rests, their weights."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.methods import METHODS, bound_record, scale_of
from axisid.estimation.parameters import JointForm, KnownValue, known_of, layout_of, prefilters_of
from axisid.estimation.problems import Problem
from axisid.estimation.records import Record
from axisid.estimation.signals import (
    FilteredRecord,
    Prefilter,
    searches_friction,
    show_too_little,
)
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

# of the noisiest record; less noise is rounding, and tells nothing of a record's worth
_MIN_NOISE_RATIO = 1e-6


def layout_for(
    axis: GeneratedAxis,
    records: int,
    local: Sequence[str],
    known: Mapping[str, Sequence[KnownValue]] | None,
    *,
    commanded: bool,
) -> JointForm | None:
    """How the parameters are shared; None where all are, of all records.

    Raises
    ------
    UsageError, ModelError
        As `known_of` and `layout_of` do.
    """
    if not local and not known:
        return None
    return layout_of(axis, records, known_of(known, records), local, commanded=commanded)


def tells_gain(records: Sequence[Record], gain: str = "identified") -> bool:
    """Whether a known force may tell the drive gain of the records, and is to."""
    return gain == "identified" and all(record.force is None for record in records)


def bound_records(
    axes: Sequence[GeneratedAxis],
    records: Sequence[Record],
    asked: Prefilter,
    into: Sequence[Array] = (),
) -> tuple[FilteredRecord, ...]:
    """Records of one machine under one filter: what rests in one would rest in all.

    Samples near reversals are left out of all or of none: what they tell of parameters that they
    share adds. Arguments as of `show_too_little`.

    Raises
    ------
    UsageError, DataError
        As `bound_record` does, with the record's name.
    """
    if len(records) == 1:
        return (bound_record(axes[0], records[0], asked),)
    filters = prefilters_of(asked, records[0].period, [record.period for record in records])
    every = tuple(zip(axes, records, filters, strict=True))
    moving = [FilteredRecord.bind(a, r, replace(f, reversals="keep")) for a, r, f in every]
    fastest = max(float(np.abs(data.motion[1]).max()) for data in moving)
    reversals = asked.reversals
    if reversals is None and axes[0].has_direction and not searches_friction(axes[0]):
        little = show_too_little([data.without_turns(fastest) for data in moving], into)
        reversals = "keep" if little else "leave-out"
    every = tuple((a, r, replace(f, reversals=reversals)) for a, r, f in every)
    return tuple(bound_record(a, r, f, fastest) for a, r, f in every)


def weighted(problem: Problem, loss: str = ROW_LOSSES[0]) -> Problem:
    """A problem of several records with each weighted by its own noise, from a first pass.

    Feasible generalised least squares: the noise of a record is what least squares of all leaves of
    its rows, root mean square, or by the median under a loss that is not of squares. Where that
    comes to nothing the records count alike, and whoever asks for an estimate is told why there is
    none.

    References
    ----------
    [Wooldridge2010]_, chapter 7.
    """
    if len(problem.data) == 1:
        return problem
    try:
        with np.errstate(all="ignore"):
            residuals = replace(METHODS["idm-ls"], loss=loss).fit(problem).solution.residuals
    except AxisidError:
        return problem
    sizes = [len(residuals[span]) for span in problem.spans]
    if not min(sizes):
        return problem
    sized = scale_of if loss != ROW_LOSSES[0] else _rms
    noise = np.array([sized(residuals[span]) for span in problem.spans])
    if not (np.all(np.isfinite(noise)) and noise.min() > _MIN_NOISE_RATIO * noise.max()):
        return problem
    # In the unit of the rows: the residuals of all keep their mean square.
    unit = 1 / np.sqrt(np.average(noise**-2.0, weights=sizes))
    return replace(problem, weights=tuple(float(unit / each) for each in noise))


def _rms(residuals: Array) -> float:
    return float(np.sqrt(np.mean(residuals**2)))
