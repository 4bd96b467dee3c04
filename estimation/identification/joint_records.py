"""The records that are used, under their filters as one problem: what they share, their weights."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import ROW_LOSSES
from axisid.estimation.estimation_problem import Problem, check_time_known
from axisid.estimation.methods import METHODS, bound_record, scale_of
from axisid.estimation.parameters import (
    JointForm,
    KnownValue,
    declared_names,
    known_of,
    layout_of,
    prefilters_of,
)
from axisid.estimation.records import Record, record_labels
from axisid.estimation.signals import (
    FilteredRecord,
    Prefilter,
    searches_friction,
    show_too_little,
)
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, DataError, UsageError, check_among, listed


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
        turned = [data.without(data.sampling.turns(data.motion[1], fastest)) for data in moving]
        reversals = "keep" if show_too_little(turned, into) else "leave-out"
    return tuple(bound_record(a, r, replace(f, reversals=reversals), fastest) for a, r, f in every)


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
    parts, of_squares = [residuals[span] for span in problem.spans], loss == ROW_LOSSES[0]
    if not all(map(len, parts)):
        return problem
    noise = np.array([np.sqrt(np.mean(e**2)) if of_squares else scale_of(e) for e in parts])
    # Less noise than a millionth of another's is rounding, and tells nothing of a record's worth.
    if not (np.all(np.isfinite(noise)) and noise.min() > 1e-6 * noise.max()):
        return problem
    # In the unit of the rows: the residuals of all keep their mean square.
    unit = 1 / np.sqrt(np.average(noise**-2.0, weights=[*map(len, parts)]))
    return replace(problem, weights=tuple(float(unit / each) for each in noise))


def check_bad(bad: Mapping[str, str], count: int, *, skip_bad: bool) -> None:
    """Refuse records that cannot be used, all of them at once, each with its reason.

    Raises
    ------
    DataError
        They are not to be skipped, or all are bad.
    """
    if not bad or (skip_bad and len(bad) < count):
        return
    # A reason may begin with the record's name.
    own = {name: f"^({re.escape(name)}|{re.escape(Path(name).name)})[:,] " for name in bad}
    reasons = "; ".join(f"{name}: {re.sub(own[name], '', note)}" for name, note in bad.items())
    said = f"{len(bad)} of {count} records cannot be used: {reasons}"
    if len(bad) < count:
        said += " Mend them, or go on without them: skip-bad."
    raise DataError(said, code="record")


def known_without(
    used: Sequence[int], known: Mapping[str, Sequence[KnownValue]] | None
) -> dict[str, list[KnownValue]]:
    """What is known of each record, of those that are used."""
    return {name: [values[i] for i in used] for name, values in (known or {}).items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRecords:
    """Records that are used, what is each one's own, and what is known of each.

    Attributes
    ----------
    axis : GeneratedAxis
        That was asked of.
    own_layout : JointForm or None
        Its own.
    records : tuple of Record
    local : tuple of str
    known : mapping of str to sequence
        As `identify` takes it.
    commanded : bool
        Whether a known force may tell the drive gain.
    set_aside : mapping of str to str
        Records that are not used, with the reason.
    """

    axis: GeneratedAxis
    own_layout: JointForm | None
    records: tuple[Record, ...]
    local: tuple[str, ...]
    known: Mapping[str, Sequence[KnownValue]]
    commanded: bool
    set_aside: Mapping[str, str]

    def layout(self, axis: GeneratedAxis) -> JointForm | None:
        """How the parameters of an axis are shared; None where all are, of all records.

        A candidate may be without a parameter that others have for each record.

        Raises
        ------
        UsageError, ModelError
            As `layout_of` does.
        """
        if axis is self.axis:
            return self.own_layout
        own = [n for n in self.local if n in {p.name for p in axis.declared.parameters}]
        return layout_for(axis, len(self.records), own, self.known, commanded=self.commanded)

    def axes(self, axis: GeneratedAxis, layout: JointForm | None) -> list[GeneratedAxis]:
        """That of each record, with what is known of it put in."""
        return [axis] * len(self.records) if layout is None else [m.axis for m in layout.members]

    def problem(
        self, axis: GeneratedAxis, prefilter: Prefilter, loss: str = ROW_LOSSES[0]
    ) -> Problem:
        """The records under a prefilter, each of its own axis, weighted by its own noise."""
        layout = self.layout(axis)
        into = () if layout is None else [*map(layout.record_jacobian, range(len(self.records)))]
        data = bound_records(self.axes(axis, layout), self.records, prefilter, into)
        return weighted(Problem(axis=axis, data=data, layout=layout), loss)


def shared_records(
    axis: GeneratedAxis,
    records: Sequence[Record],
    prefilter: Prefilter | None,
    local: str | Sequence[str],
    known: Mapping[str, Sequence[KnownValue]] | None,
    gain: str,
    *,
    skip_bad: bool,
) -> JointRecords:
    """The records that a prefilter serves, or all without one, and what is said of each.

    Parameters
    ----------
    axis : GeneratedAxis
        Of which names are checked.
    records : sequence of Record
    prefilter : Prefilter or None
        None where records are not filtered.
    local, known, gain, skip_bad
        As of `identify`.

    Raises
    ------
    DataError
        Records cannot be used, and are not to be skipped.
    UsageError, ModelError
        A name is none; or what is known is not of each record.
    """
    own = tuple(str(name) for name in listed(local) if name)
    check_among(("gain", gain, ("identified", "declared")))
    check_time_known(axis)
    if own and len(records) == 1:
        raise UsageError(
            f"{', '.join(own)} {'is' if len(own) == 1 else 'are'} to be each record's own, "
            "and there is 1 record; give several, or leave local out.",
            code="parameters",
        )
    # A known force may tell the gain of the drive, where nothing measures its force.
    commanded = gain == "identified" and all(record.force is None for record in records)
    layout = layout_for(axis, len(records), own, known, commanded=commanded)
    names, aside = record_labels(records), dict[str, str]()
    if len(records) > 1 and prefilter is not None:  # one is refused later
        filters = prefilters_of(prefilter, records[0].period, [each.period for each in records])
        for name, record, own_filter in zip(names, records, filters, strict=True):
            try:
                with np.errstate(all="ignore"):
                    _ = FilteredRecord.bind(axis, record, own_filter).force
            except AxisidError as error:
                aside[name] = str(error)
        check_bad(aside, len(records), skip_bad=skip_bad)
    used = [i for i, name in enumerate(names) if name not in aside]
    known = known_without(used, known)
    if aside:
        own = own if len(used) > 1 else ()
        layout = layout_for(axis, len(used), own, known, commanded=commanded)
    return JointRecords(
        axis=axis,
        own_layout=layout,
        records=tuple(records[i] for i in used),
        local=declared_names(axis, own),
        known=known,
        commanded=commanded,
        set_aside=aside,
    )
