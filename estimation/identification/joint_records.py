"""The used records and their filters as one problem, with shared parameters and weights."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.estimation_problem import Problem, check_time_known
from axisid.estimation.methods import METHODS, filtered_record, robust_scale
from axisid.estimation.records import Record, is_same_period, record_labels
from axisid.estimation.signals import (
    FilteredRecord,
    Prefilter,
    has_nonlinear_speed_friction,
    matching_decimation,
    show_too_little,
)
from axisid.estimation.unknowns import (
    JointForm,
    KnownValue,
    declared_names,
    joint_form_of,
    known_of,
)
from axisid.support.arrays import Array
from axisid.support.checks import check_among, listed
from axisid.support.errors import AxisidError, DataError, UsageError
from axisid.support.settings import setting

_MOST_ROWS_APART = 1000  # largest distance of rows, in samples of the fastest record
_FARTHER = 1.2  # times the requested distance of rows; beyond it a smaller distance is taken
_FINEST = 50  # largest denominator of a ratio of periods


def _joint_form(
    axis: GeneratedAxis,
    records: int,
    local: Sequence[str],
    known: Mapping[str, Sequence[KnownValue]] | None,
    *,
    commanded: bool,
) -> JointForm | None:
    """Return the form of shared and local parameters; None where records share all parameters.

    Parameters
    ----------
    axis : GeneratedAxis
    records : int
        Number of records.
    local : sequence of str
        Parameters with a separate value in each record.
    known : mapping or None
        Known values of each record, by name.
    commanded : bool
        True if the drive gain may be identified, which a known force shows.

    Raises
    ------
    UsageError, ModelError
        As in `known_of` and `joint_form_of`.
    """
    if not local and not known:
        return None
    return joint_form_of(axis, records, known_of(known, records), local, commanded=commanded)


def prefilters_of(asked: Prefilter, designed: float, periods: Sequence[float]) -> list[Prefilter]:
    """Return the filter of each record, with decimations that give rows at one distance in time.

    Parameters
    ----------
    asked : Prefilter
        Filter for a record with the sample period `designed`.
    designed : float
        Sample period that `asked` was designed for, s.
    periods : sequence of float
        Sample periods of the records, s.

    Raises
    ------
    UsageError
        The periods have no common multiple that can be the distance of rows.
    """
    if all(is_same_period(period, designed) for period in periods):
        return [asked] * len(periods)
    # Periods relative to the designed one, as fractions; `whole` if they are such fractions.
    ratios = [Fraction(period / designed).limit_denominator(_FINEST) for period in periods]
    whole = all(
        ratio > 0 and is_same_period(float(ratio) * designed, period)
        for ratio, period in zip(ratios, periods, strict=True)
    )
    decimations = _decimations(asked, designed, ratios) if whole else []
    if not decimations or any(d.denominator != 1 or d > _MOST_ROWS_APART for d in decimations):
        listed_periods = ", ".join(f"{period:.6g}" for period in periods)
        raise UsageError(
            f"the sampling periods of the records, {listed_periods} s, have no common multiple, "
            "which the rows of all records need as their distance in time. Check the unit of each "
            f"record's time with {setting('columns', {'time': 'NAME:UNIT'})}, or resample the "
            f"records to one rate with {setting('resample', 'HZ')}.",
            code="parameters",
        )
    return [
        replace(asked.at_period(designed, period), decimate=int(decimation))
        for period, decimation in zip(periods, decimations, strict=True)
    ]


def _decimations(asked: Prefilter, designed: float, ratios: list[Fraction]) -> list[Fraction]:
    """Return the decimation of each record, so that the rows of all have one distance in time.

    The distance is a common multiple of the sample periods near the requested distance: the next
    larger multiple, or the next smaller multiple where the larger one exceeds the requested
    distance by more than 20 %. The smaller multiple is not used if it is below both the requested
    distance and the distance that matches the cut-off.

    Parameters
    ----------
    asked : Prefilter
        Filter for a record with the period `designed`, with the requested distance of rows.
    designed : float
        Sample period that `asked` was designed for, s.
    ratios : list of Fraction
        Sample period of each record divided by `designed`.
    """
    # All distances in units of `designed`. The least common multiple of fractions is the lcm of the
    # numerators divided by the gcd of the denominators.
    step = math.lcm(*(ratio.numerator for ratio in ratios))
    least = Fraction(step, math.gcd(*(ratio.denominator for ratio in ratios)))
    above = least * max(1, math.ceil(Fraction(asked.decimate) / least))
    below, finest = above - least, matching_decimation(asked.cutoff, designed)
    takes_smaller = above > _FARTHER * asked.decimate and below >= min(finest, asked.decimate)
    distance = below if takes_smaller else above
    return [distance / ratio for ratio in ratios]


def filtered_records(
    axes: Sequence[GeneratedAxis],
    records: Sequence[Record],
    asked: Prefilter,
    into: Sequence[Array] = (),
) -> tuple[FilteredRecord, ...]:
    """Return the filtered records of one machine, with rows at one distance in time.

    Samples near rests and reversals are left out of all records or of none, because all records add
    to the information on shared parameters.

    Parameters
    ----------
    axes : sequence of GeneratedAxis
        Axis of each record.
    records : sequence of Record
    asked : Prefilter
        Filter of the first record.
    into : sequence of array
        Maps from the parameters of each record to those of all, as in `show_too_little`; empty
        where all records share all parameters.

    Raises
    ------
    UsageError, DataError
        As in `filtered_record`, with the record's name.
    """
    if len(records) == 1:
        return (filtered_record(axes[0], records[0], asked),)
    filters = prefilters_of(asked, records[0].period, [record.period for record in records])
    every = tuple(zip(axes, records, filters, strict=True))
    # The largest speed of all records decides what counts as rest in each of them.
    moving = [FilteredRecord.bind(a, r, replace(f, reversals="keep")) for a, r, f in every]
    fastest = max(float(np.abs(data.motion[1]).max()) for data in moving)
    reversals = asked.reversals
    if reversals is None and axes[0].has_direction and not has_nonlinear_speed_friction(axes[0]):
        # Without the samples near rests and reversals, unless the others show too little.
        without = [data.without(data.sampling.turns(data.motion[1], fastest)) for data in moving]
        reversals = "keep" if show_too_little(without, into) else "leave-out"
    return tuple(
        filtered_record(a, r, replace(f, reversals=reversals), fastest) for a, r, f in every
    )


def weighted(problem: Problem, loss: str = ROW_LOSSES[0]) -> Problem:
    """Return a problem with the rows of each record weighted by the inverse of its noise.

    This is feasible generalised least squares. In a first pass, all records are estimated together
    by least squares. The noise of a record is the root mean square of its residuals, or a robust
    scale by the median with a robust `loss`. If least squares fails, or if a record has no rows or
    no noise to compare, the problem is returned without weights, and the estimation reports the
    reason. A single record has no weight.

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
    parts = [residuals[span] for span in problem.spans]
    if not all(map(len, parts)):
        return problem
    if loss == ROW_LOSSES[0]:
        noise = np.array([np.sqrt(np.mean(e**2)) for e in parts])
    else:
        noise = np.array([robust_scale(e) for e in parts])
    # Noise below a millionth of another record's is rounding, and no measure of a record's quality.
    if not (np.all(np.isfinite(noise)) and noise.min() > 1e-6 * noise.max()):
        return problem
    # Scaled so that the mean square of the weights of all rows is 1: rows keep their unit.
    unit = 1 / np.sqrt(np.average(noise**-2.0, weights=[*map(len, parts)]))
    return replace(problem, weights=tuple(float(unit / each) for each in noise))


def check_usable(bad: Mapping[str, str], count: int, *, skip_bad: bool) -> None:
    """Refuse the records that cannot be used, in one error with the reason for each.

    Parameters
    ----------
    bad : mapping of str to str
        Names of records that cannot be used, with the reason.
    count : int
        Number of all records.
    skip_bad : bool
        True to accept bad records as long as another record is good.

    Raises
    ------
    DataError
        Bad records are not to be skipped, or all records are bad.
    """
    if not bad or (skip_bad and len(bad) < count):
        return
    reasons = []
    for name, reason in bad.items():
        # A reason may begin with the record's name, which is then not repeated.
        own_name = f"^({re.escape(name)}|{re.escape(Path(name).name)})[:,] "
        reasons.append(f"{name}: {re.sub(own_name, '', reason)}")
    message = f"{len(bad)} of {count} records cannot be used: {'; '.join(reasons)}"
    if len(bad) < count:
        message += (
            f" Correct these records, or continue without them with {setting('skip_bad', True)}."
        )
    raise DataError(message, code="record")


def known_of_used(
    used: Sequence[int], known: Mapping[str, Sequence[KnownValue]] | None
) -> dict[str, list[KnownValue]]:
    """Return the known values by name, with one value for each used record.

    `used` has the indices of the used records. `known` has a value for every record, or is None
    without known values.
    """
    return {name: [values[i] for i in used] for name, values in (known or {}).items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRecords:
    """The records that are used, with their local parameters and known values.

    Attributes
    ----------
    axis : GeneratedAxis
        Requested axis.
    own_form : JointForm or None
        Form of the shared and local parameters of `axis`; None where records share all parameters.
    records : tuple of Record
    local : tuple of str
        Parameters with a separate value in each record.
    known : mapping of str to sequence
        Known values of each record, as in `identify`.
    commanded : bool
        True if the drive gain may be identified, which a known force shows.
    set_aside : mapping of str to str
        Records that are not used, with the reason.
    """

    axis: GeneratedAxis
    own_form: JointForm | None
    records: tuple[Record, ...]
    local: tuple[str, ...]
    known: Mapping[str, Sequence[KnownValue]]
    commanded: bool
    set_aside: Mapping[str, str]

    def joint_form(self, axis: GeneratedAxis) -> JointForm | None:
        """Return the form of the shared and local parameters of an axis.

        None if the records share all parameters. The axis may be another candidate model, which
        may lack a parameter that is local in other candidates.

        Raises
        ------
        UsageError, ModelError
            As in `joint_form_of`.
        """
        if axis is self.axis:
            return self.own_form
        declared = {p.name for p in axis.declared.parameters}
        local = [name for name in self.local if name in declared]
        return _joint_form(axis, len(self.records), local, self.known, commanded=self.commanded)

    def axes(self, axis: GeneratedAxis, joint: JointForm | None) -> list[GeneratedAxis]:
        """Return the axis of each record, with the record's known values fixed.

        With `joint` None, all records have the same `axis`.
        """
        return [axis] * len(self.records) if joint is None else [m.axis for m in joint.members]

    def problem(
        self, axis: GeneratedAxis, prefilter: Prefilter, loss: str = ROW_LOSSES[0]
    ) -> Problem:
        """Return the regression of an axis on all records, filtered and weighted by their noise."""
        joint = self.joint_form(axis)
        into: list[Array] = []  # maps from the parameters of each record to those of all records
        if joint is not None:
            into = [joint.record_jacobian(i) for i in range(len(self.records))]
        data = filtered_records(self.axes(axis, joint), self.records, prefilter, into)
        return weighted(Problem(axis=axis, data=data, joint_form=joint), loss)


def joint_records(
    axis: GeneratedAxis,
    records: Sequence[Record],
    prefilter: Prefilter | None,
    local: str | Sequence[str],
    known: Mapping[str, Sequence[KnownValue]] | None,
    gain: str,
    *,
    skip_bad: bool,
) -> JointRecords:
    """Return the records that can be filtered, with their local parameters and known values.

    Each of several records is filtered on trial. A record that cannot be filtered is set aside with
    the reason, or refused. The names of local parameters and known values are checked.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis that has the parameters named in `local` and `known`.
    records : sequence of Record
    prefilter : Prefilter or None
        Filter of the first record; None to use all records without filtering them.
    local, known, gain, skip_bad
        As in `identify`.

    Raises
    ------
    DataError
        Records cannot be used, and are not to be skipped.
    UsageError, ModelError
        A name does not exist, or a known value is not given for each record.
    """
    local_names = tuple(str(name) for name in listed(local) if name)
    check_among(("gain", gain, ("identified", "declared")))
    check_time_known(axis)
    if local_names and len(records) == 1:
        raise UsageError(
            f"{', '.join(local_names)} cannot be local, because there is only one record. Give "
            "several records, or omit local.",
            code="parameters",
        )
    # A known force can only show the gain of the drive if the force of the drive is not measured.
    commanded = gain == "identified" and all(record.force is None for record in records)
    joint = _joint_form(axis, len(records), local_names, known, commanded=commanded)
    # Filter each of several records on trial, for the records that cannot be used.
    names, aside = record_labels(records), dict[str, str]()
    if len(records) > 1 and prefilter is not None:  # a single bad record is refused later
        filters = prefilters_of(prefilter, records[0].period, [each.period for each in records])
        for name, record, own_filter in zip(names, records, filters, strict=True):
            try:
                with np.errstate(all="ignore"):
                    _ = FilteredRecord.bind(axis, record, own_filter).force
            except AxisidError as error:
                aside[name] = str(error)
        check_usable(aside, len(records), skip_bad=skip_bad)
    used = [i for i, name in enumerate(names) if name not in aside]
    known = known_of_used(used, known)
    # The same for the used records alone; a single one has no local parameters.
    if aside:
        local_names = local_names if len(used) > 1 else ()
        joint = _joint_form(axis, len(used), local_names, known, commanded=commanded)
    return JointRecords(
        axis=axis,
        own_form=joint,
        records=tuple(records[i] for i in used),
        local=declared_names(axis, local_names),
        known=known,
        commanded=commanded,
        set_aside=aside,
    )
