"""An identification that was written as JSON, read again, whole or as one of its records has it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.checks import DEFAULT_LEVELS, Levels
from axisid.estimation.diagnostics import (
    Alignment,
    Diagnosis,
    Excitation,
    RecordDiagnosis,
    RecordDifference,
)
from axisid.estimation.diagnostics.control_law import LawCheck
from axisid.estimation.estimates import (
    Physical,
    PhysicalByMethod,
    physical_parameters,
)
from axisid.estimation.identification import (
    ByMethod,
    DriveTime,
    Identification,
    RecordInfo,
    RecordResult,
    record_place,
)
from axisid.estimation.parameters import known_of, layout_of
from axisid.estimation.records import Record
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import Prefilter, SampledFilter, Sampling
from axisid.estimation.studies import Validation, validate
from axisid.modeling.declaration import Axis, Drive, left_out_text
from axisid.modeling.quantities import Parameter, Signal
from axisid.support.arrays import Array, Exact
from axisid.support.errors import Missing, UsageError
from axisid.support.presentable import Presentable, view_of

from .diagnosis import NOT_EVALUATED, WrittenAlignment
from .estimate import SavedEstimate, arrays, named, written_physical_covariances
from .record import WrittenPrefilter, WrittenRecord, written_drive
from .values import read_as
from .written_identification import (
    WrittenIdentification,
    WrittenMember,
    written_identification,
)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedIdentification(ByMethod, Presentable, Exact):
    """An identification that was read from a file; see `load_result`.

    It has the names of `Identification`: ``saved["idm-iv"].parameters``, `verdict`, `summary`,
    `plot`; what needs the rows of the record is refused with a sentence.

    Attributes
    ----------
    file : str
    document : WrittenIdentification
        What the file holds.
    declared : Axis or None
        The axis that was identified, if it is known.
    name, signature : str
        Of the axis, and of the generated code that identified it.
    signals : tuple of Signal
        Recorded signals that the axis has.
    drive : Drive
        How it follows its commands; its gain is 1.
    drive_time : DriveTime or None
        The drive's lag or delay where it was estimated.
    estimates : mapping of str to SavedEstimate
    physical : mapping of str to Physical
        Declared parameters by method; empty where the estimates are of them already.
    diagnosis : Diagnosis
        What the tests of the result measured.
    levels : Levels
        From when on something was told as missing of the model.
    requested : Prefilter or None
        The prefilter before what it left open was chosen for the record, if that is known.
    prefilter : Prefilter
        With what was chosen for the record.
    record : RecordInfo
        Without its samples.
    sampling : Sampling
        The samples that counted; of those near reversals how many, not which.
    of_records : tuple of RecordResult
        What there is to say of each of several records; empty for one.
    local_names : mapping of str to tuple of str
        Of each declared parameter that records have for themselves, its names by record.
    declared_gain : float or None
        The declared drive gain where it is identified; None where it is believed.
    skipped, failed, set_aside : mapping of str to str
        Methods that axis or record did not allow, methods that came to nothing, and records that
        could not be used, with the reason.
    """

    file: str
    document: WrittenIdentification
    declared: Axis | None = None
    name: str
    signature: str
    signals: tuple[Signal, ...]
    drive: Drive
    drive_time: DriveTime | None
    estimates: Mapping[str, SavedEstimate]
    physical: PhysicalByMethod[Physical]
    diagnosis: Diagnosis
    levels: Levels
    requested: Prefilter | None
    prefilter: Prefilter
    record: RecordInfo
    sampling: Sampling
    of_records: tuple[RecordResult, ...]
    local_names: Mapping[str, tuple[str, ...]]
    declared_gain: float | None
    skipped: Mapping[str, str]
    failed: Mapping[str, str]
    set_aside: Mapping[str, str]

    @classmethod
    def of(
        cls, file: str, written: WrittenIdentification, declared: Axis | None = None
    ) -> "SavedIdentification":
        """What a document tells."""
        record, drive, asked = written.record, written.drive, written.requested
        sampling, found = _sampling(written.prefilter, record), drive and drive.estimated
        step = record.period * written.prefilter.decimate
        estimates = {e.method: SavedEstimate.of(e, step) for e in written.estimates}
        physical = {method: _physical(estimate) for method, estimate in estimates.items()}
        return read_as(
            cls,
            written,
            file=file,
            document=written,
            declared=declared,
            name=written.axis,
            signals=tuple(Signal(s.name, s.unit, s.between) for s in written.signals or ()),
            drive=written_drive(drive) if drive else Drive(gain=1.0),
            drive_time=DriveTime(
                name=found.of,
                parameter=Parameter(found.name, "s", nominal=found.nominal),
                value=found.value,
                deviation=found.sd,
                interval=found.interval_95,
            )
            if found
            else None,
            estimates=estimates,
            physical=PhysicalByMethod((m, p) for m, p in physical.items() if p is not None),
            diagnosis=read_diagnosis(written),
            levels=written.levels or DEFAULT_LEVELS,
            requested=None if asked is None else read_as(Prefilter, asked),
            prefilter=sampling.filter.settings,
            record=record,
            sampling=sampling,
            of_records=tuple(
                read_as(
                    RecordResult,
                    of_one,
                    record=of_one.record,
                    sampling=_sampling(of_one.prefilter, of_one.record),
                    known={name: (v.value or 0.0, v.sd) for name, v in of_one.known.items()},
                    share_percent=of_one.apart and of_one.apart.share_percent,
                    p_value=of_one.apart and of_one.apart.p_value,
                )
                for of_one in written.records or ()
            ),
            local_names=written.local or {},
            declared_gain=written.declared_gain or None,
            set_aside=written.set_aside or {},
        )

    def __repr__(self) -> str:
        records = [self.document.record, *(m.record for m in (self.document.records or ())[1:])]
        source = " and ".join(record.source for record in records)
        return f"saved identification of {self.name} from {source}: {', '.join(self.estimates)}"

    @cached_property
    def axis(self) -> GeneratedAxis:
        """The axis that was identified, built when it is first asked for.

        Raises
        ------
        UsageError
            It is none of the library, and was not given.
        """
        return build(self.own_axis)

    @property
    def own_axis(self) -> Axis:
        """The declaration of the axis; a `UsageError` where it is not known."""
        if self.declared is None:
            raise UsageError(
                f"{self.file} does not hold the axis {self.name!r}; give the one it was "
                "identified with (axis).",
                code="result-file",
            )
        return self.declared

    @property
    def left_out(self) -> str:
        """What stands for the parameters that were left out, in words; empty for none."""
        if self.declared is not None:
            return left_out_text(self.declared)
        return ", ".join(f"{n} = {value:g}" for n, value in (self.document.left_out or {}).items())

    @property
    def declared_parameters(self) -> tuple[Parameter, ...]:
        """Of the axis, or as far as the file has them."""
        if self.declared is not None:
            return self.declared.parameters
        made = {p.name for p in self.combined}
        own = next(iter(self.estimates.values())).parameters
        return tuple(Parameter(n, value.unit) for n, value in own.items() if n not in made)

    @property
    def combined(self) -> tuple[Parameter, ...]:
        """Base parameters that are no declared ones."""
        every = (p for physical in self.physical.values() for p in physical.combined)
        return tuple({p.name: p for p in every}.values())

    @property
    def preferred(self) -> SavedEstimate:
        """The estimate that is judged."""
        return self[self.document.judged]

    def summary(self, draws: int = 0, *, every: bool = False, full: bool = False) -> str:
        """The same text as `Identification.summary`, of what the file holds.

        Parameters
        ----------
        draws : int
            As many as were drawn when the file was written, for their table; 0 for none.
        every, full : bool
            As there.
        """
        return str(view_of("as_text", self, draws=draws, every=every, full=full))

    def part(self, number: int) -> "SavedIdentification":
        """The result as one of several records has it, by its number from 1.

        What is the record's own is a parameter of its axis; with the drive gain among the
        parameters of all, they are of the declared gain, as in the part of a live result.

        Raises
        ------
        UsageError
            There is no such record.
        """
        place, records = record_place(number, len(self.of_records)), self.of_records
        if not records:
            return self
        one, gain = records[place], self.declared_gain
        own = replace(
            self,
            record=one.record,
            sampling=one.sampling,
            prefilter=one.sampling.filter.settings,
            of_records=(),
        )
        if not (self.local_names or one.known):
            return own
        told = {name: [each.known[name] for each in records] for name in one.known}
        known, count = known_of(told, len(records)), len(records)
        joint = layout_of(self.axis, count, known, self.local_names, commanded=gain is not None)
        axis = joint.members[place].axis
        estimates = {method: e.part(joint, place) for method, e in self.estimates.items()}
        physical = {
            method: physical_parameters(method, InverseForm(axis), e.distribution)
            for method, e in estimates.items()
        }
        return replace(
            own,
            declared=axis.declared,
            signature=axis.signature,
            estimates=estimates,
            physical=PhysicalByMethod((m, p) for m, p in physical.items() if p is not None),
            local_names={},
            declared_gain=None,
        )

    def validate(self, record: Record, *, like: int | None = None) -> Validation:
        """Hold every estimate, frozen, against another record of the axis, as `validate` does."""
        return validate(self, record, like=like)


def identification_facts(result: Identification, draws: int) -> SavedIdentification:
    """What an identification tells without its rows, which is all that tables show."""
    document = written_identification(result, draws)
    return SavedIdentification.of("", document, result.axis.declared)


def _sampling(prefilter: WrittenPrefilter, record: WrittenRecord) -> Sampling:
    filtered = SampledFilter(read_as(Prefilter, prefilter, drop=None), record.period)
    # Ends that are no longer than the filter's transient were not cut off, but given no weight.
    if filtered.dropped != prefilter.drop:
        filtered = replace(filtered, settings=replace(filtered.settings, drop=prefilter.drop))
    return Sampling(
        filter=filtered,
        samples=record.samples,
        segments=record.segments,
        masked=record.masked,
        excluded=((0, prefilter.silent),) if prefilter.silent else (),
    )


def read_diagnosis(written: WrittenIdentification) -> Diagnosis:
    """The diagnosis of a document."""
    units = {name: v.unit for name, v in written.estimates[0].parameters.items()}
    return Diagnosis(
        preferred=written.judged,
        instruments=written.instruments,
        excitation=tuple(
            read_as(Excitation, e, name=name) for name, e in written.excitation.items()
        ),
        **_measured(written, units),
        bands=written.model_bands or {},
        differences=written.differences or {},
        records=tuple(
            RecordDiagnosis(
                **_measured(member, units),
                apart=Missing("the record alone does not tell the parameters")
                if member.apart is None
                else read_as(
                    RecordDifference,
                    member.apart,
                    names=tuple(member.apart.own),
                    own=_numbers(member.apart.own),
                    others=_numbers(member.apart.common),
                    deviations=_numbers(member.apart.deviations),
                ),
            )
            for member in written.records or ()
        ),
    )


def _measured(
    written: WrittenIdentification | WrittenMember, units: Mapping[str, str]
) -> dict[str, Any]:
    """What is measured of one record as well as of a whole result."""
    law = written.law_check
    return {
        "law": Missing(law.meaning.removeprefix(NOT_EVALUATED))
        if law.passed is None
        else read_as(LawCheck, law, factors=dict(law.factors or {}), delay=law.delay or 0),
        "alignment": _read_alignment(written.alignment, units),
        "verdict": written.verdict,
        "lack_of_fit": written.lack_of_fit or None,
        "motions": written.measured_motion or {},
    }


def _read_alignment(written: WrittenAlignment, units: Mapping[str, str]) -> Alignment | Missing:
    if written.best is None:
        return Missing(written.reason or "")
    sensitivity = np.array([*(written.sensitivity or {}).values()])
    return read_as(
        Alignment,
        written,
        at_the_end=bool(written.at_the_end),
        by_instruments=bool(written.by_instruments),
        sensitivity=sensitivity,
        names=tuple(written.sensitivity or {}),
        units=tuple(units.get(name, "") for name in written.sensitivity or {}),
    )


def _numbers(written: Mapping[str, float]) -> Array:
    return np.array([*written.values()], dtype=float)


def _physical(estimate: SavedEstimate) -> Physical | None:
    written = estimate.document.physical
    if not written:
        return None
    parameters = named(written.parameters, estimate.chosen)
    return read_as(
        Physical,
        written,
        method=estimate.method,
        own=tuple(estimate.parameters),
        parameters=parameters,
        covariances=arrays(written_physical_covariances(written)),
        known=tuple(
            Parameter(
                name,
                parameters[name].unit if name in parameters else "1",
                known=fixed.value,
                known_sd=fixed.sd,
            )
            for name, fixed in written.fixed.items()
        ),
        combined=tuple(
            Parameter(name, estimate.parameters[name].unit, description=made)
            for name, made in written.base.items()
        ),
    )
