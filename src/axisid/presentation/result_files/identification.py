"""Identifications as documents, written and read, for all records or one of them.

The names of a document's members are a contract with other programs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

from msgspec import UNSET, UnsetType, structs

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.diagnostics import (
    ColumnComparison,
    HausmanTest,
    InstrumentTests,
    RecordDiagnosis,
    RecordDifference,
)
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
    record_index,
)
from axisid.estimation.misspecification import JackknifeInterval, LackOfFit
from axisid.estimation.model_validation import Validation, validate
from axisid.estimation.records import Record
from axisid.estimation.regression import Drawn, InverseForm
from axisid.estimation.signals import Prefilter, SampledFilter, Sampling
from axisid.estimation.unknowns import joint_form_of, known_of
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels
from axisid.modeling.declaration import Axis, Drive, left_out_text
from axisid.modeling.quantities import Parameter, Signal
from axisid.support.arrays import Exact
from axisid.support.checks import is_nothing
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable

from .checks import WrittenCheck, read_checks
from .diagnosis import (
    WrittenAlignment,
    WrittenExcitation,
    WrittenLawCheck,
    diagnosis_members,
    record_members,
)
from .estimate import (
    SavedEstimate,
    WrittenEstimate,
    arrays,
    left_out,
    named,
    written_estimate,
    written_physical,
)
from .json_objects import (
    JsonObject,
    WrittenKnown,
    WrittenResult,
    about,
    plain,
    read_as,
    written_as,
)
from .record import (
    WrittenDriveTime,
    WrittenPrefilter,
    WrittenRecord,
    WrittenRequest,
    WrittenResponse,
    WrittenSignal,
    written_prefilter,
    written_record,
)


class WrittenHeld(JsonObject, frozen=True, kw_only=True):
    """A parameter that is fixed at a declared bound."""

    unit: str
    bound: float
    free: Annotated[
        float, about("Estimate without the bound, minus its bias if the bias is known.")
    ]
    deviation: Annotated[float, about("Standard error of `free`, by the chosen covariance.")]
    interval_95: Annotated[tuple[float, float], about("One-sided interval from the bound.")]


class WrittenMethodValidation(JsonObject, frozen=True, kw_only=True):
    """One frozen estimate on the second record."""

    method: str
    equation_error_percent: float | None
    own_equation_error_percent: Annotated[
        float | None,
        about("Equation error on the record of the identification."),
    ]
    simulation_error_percent: float | None
    position_error_rms: Annotated[float | None, about("In the unit of the coordinate.")]
    tracking_error_percent: Annotated[
        float | None, about("Relative to the recorded tracking error.")
    ]
    reason: Annotated[str, about("Reason why there is no simulation error.")]
    holds: Annotated[
        bool | UnsetType,
        about(
            "True if force, simulated loop and parameters agree with the record of the "
            "identification; the control law is checked separately."
        ),
    ] = UNSET
    own_simulation_error_percent: float | UnsetType | None = UNSET
    own_tracking_error_percent: Annotated[
        float | UnsetType | None,
        about("null if unknown, for example for a result read from a file."),
    ] = UNSET
    anew: Annotated[
        Mapping[str, float | None] | UnsetType | None,
        about("Estimates from the second record by the same method."),
    ] = UNSET
    anew_distances: Annotated[
        Mapping[str, float | None] | UnsetType | None,
        about("Differences to the frozen estimates, in HAC standard errors of the difference."),
    ] = UNSET
    anew_share_percent: Annotated[
        float | UnsetType | None, about("Effect of the difference, relative to the force.")
    ] = UNSET


class WrittenValidation(WrittenResult, frozen=True, kw_only=True):
    """The frozen estimates on a second record."""

    record: WrittenRecord
    methods: tuple[WrittenMethodValidation, ...]
    time_base: Annotated[
        str | None,
        about("Reason to doubt the sampling period of the record; null for none."),
    ]
    law_check: Annotated[
        WrittenLawCheck | UnsetType,
        about("Comparison of the declared control law with the second record."),
    ] = UNSET
    holds: Annotated[
        bool | UnsetType,
        about("True if every estimate and the declared control law agree with the record."),
    ] = UNSET


class WrittenMember(JsonObject, frozen=True, kw_only=True):
    """One of several records, with errors by the judged estimate."""

    name: Annotated[str, about("Name in the verdict.")]
    record: WrittenRecord
    prefilter: WrittenPrefilter
    known: Annotated[Mapping[str, WrittenKnown], about("Known values of the record, SI, by name.")]
    rows: int
    weight: Annotated[float, about("Weight of its rows, proportional to the inverse of its noise.")]
    noise: Annotated[float, about("Root mean square of its residuals, in the unit of the force.")]
    equation_error_percent: float
    simulation_error_percent: float | None
    apart: Annotated[
        RecordDifference | None,
        about("Difference from the other records; null if the record alone is not sufficient."),
    ]
    law_check: WrittenLawCheck
    alignment: WrittenAlignment
    verdict: Annotated[tuple[WrittenCheck, ...], about("Checks of this record.")]
    lack_of_fit: LackOfFit | UnsetType = UNSET
    measured_motion: Annotated[
        Mapping[str, ColumnComparison] | UnsetType,
        about("Comparison of a measured velocity and acceleration with derivatives, by role."),
    ] = UNSET


class WrittenIdentification(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.identification/1"
):
    """Document written by `axisid identify --json`."""

    axis: str
    signature: Annotated[str, about("sha256 of the source of the generated code.")]
    left_out: Annotated[
        Mapping[str, float] | UnsetType,
        about("Values of the parameters that were left out, SI, by name."),
    ] = UNSET
    signals: Annotated[
        tuple[WrittenSignal, ...] | UnsetType,
        about("Recorded signals that the axis declares; absent if there are none."),
    ] = UNSET
    drive: Annotated[
        WrittenResponse | UnsetType, about("Response of the drive; absent for an ideal one.")
    ] = UNSET
    drive_force: Annotated[
        str | UnsetType, about("Force as a function of the control; absent for a constant gain.")
    ] = UNSET
    drive_remark: Annotated[
        str | UnsetType, about("Effects of the motor that the force of the drive does not contain.")
    ] = UNSET
    record: WrittenRecord
    prefilter: WrittenPrefilter
    requested: Annotated[
        WrittenRequest | None,
        about("Requested prefilter before automatic choices; null if unknown."),
    ]
    estimates: tuple[WrittenEstimate, ...]
    judged: Annotated[str, about("Method that the checks of a single estimate apply to.")]
    law_check: WrittenLawCheck
    instruments: InstrumentTests | None
    excitation: Annotated[Mapping[str, WrittenExcitation], about("By parameter.")]
    alignment: WrittenAlignment
    verdict: tuple[WrittenCheck, ...]
    lack_of_fit: Annotated[
        LackOfFit | UnsetType, about("Absent if the reference does not repeat.")
    ] = UNSET
    model_bands: Annotated[
        Mapping[str, Mapping[str, JackknifeInterval]] | UnsetType,
        about("Intervals that contain the model error, by method and parameter."),
    ] = UNSET
    with_missing_terms: Annotated[
        Mapping[str, tuple[float, ...]] | UnsetType,
        about(
            "Values of the parameters with the terms that *missing terms* names; two values "
            "(forward, backward) for a parameter that differs between directions."
        ),
    ] = UNSET
    differences: Annotated[
        Mapping[str, Mapping[str, HausmanTest]] | UnsetType,
        about("Differences of two estimators, as ``idm-iv less didim``, by parameter."),
    ] = UNSET
    measured_motion: Annotated[
        Mapping[str, ColumnComparison] | UnsetType,
        about("Comparison of a measured velocity and acceleration with derivatives, by role."),
    ] = UNSET
    skipped: Annotated[
        Mapping[str, str],
        about("Methods that the axis or the record does not allow, with the reason."),
    ]
    failed: Annotated[Mapping[str, str], about("Methods that failed, with the reason.")]
    levels: Levels | UnsetType = UNSET
    validation: Annotated[WrittenValidation | UnsetType, about("With --validate.")] = UNSET
    validations: Annotated[
        tuple[WrittenValidation, ...] | UnsetType,
        about("All validations, if there are several; `validation` is the first."),
    ] = UNSET
    records: Annotated[
        tuple[WrittenMember, ...] | UnsetType,
        about("All records, if several; `record` and `prefilter` are those of the first."),
    ] = UNSET
    local: Annotated[
        Mapping[str, tuple[str, ...]] | UnsetType,
        about(
            "Declared parameters with a separate value for each record: names by record, empty if "
            "identified only in products."
        ),
    ] = UNSET
    declared_gain: Annotated[
        float | UnsetType,
        about("Declared drive gain, if `drive_gain` is an estimated parameter."),
    ] = UNSET
    held: Annotated[
        Mapping[str, WrittenHeld] | UnsetType,
        about("With --bounded: parameters that are fixed at a declared bound, by name."),
    ] = UNSET
    set_aside: Annotated[
        Mapping[str, str] | UnsetType,
        about("Records that could not be used, with the reason."),
    ] = UNSET


def _member(result: RecordResult, diagnosis: RecordDiagnosis) -> WrittenMember:
    """Return one of several records as part of a document.

    Its member `apart` is the difference of the parameters from those of the other records; None if
    this record alone does not determine the parameters.
    """
    difference = None if isinstance(diagnosis.apart, Missing) else diagnosis.apart
    return written_as(
        WrittenMember,
        result,
        record=written_record(result.record),
        prefilter=written_prefilter(result.sampling),
        known={name: WrittenKnown(value=v, sd=sd) for name, (v, sd) in result.known.items()},
        apart=difference,
        **record_members(diagnosis),
    )


def written_identification(result: Identification, draws: int = 0) -> WrittenIdentification:
    """Return the document of an identification.

    With `draws` above 0 it has a summary of that many draws from the distribution of each estimate.
    """
    diagnosis, physical = result.diagnosis, result.physical
    drive = result.axis.axis.drive
    return written_as(
        WrittenIdentification,
        result,
        axis=result.axis.axis.name,
        signature=result.axis.signature,
        left_out=left_out(result.axis),
        held={
            each.name: written_as(WrittenHeld, each, interval_95=sorted((each.bound, each.reach)))
            for each in result.held
        }
        or UNSET,
        signals=tuple(written_as(WrittenSignal, s) for s in result.axis.axis.signals) or UNSET,
        drive=_response(drive, result.drive_time),
        drive_force=UNSET if drive.is_gain else drive.force_text(result.axis.axis.coordinate),
        drive_remark=drive.remark or UNSET,
        record=written_record(result.record),
        prefilter=written_prefilter(result.data.sampling),
        estimates=tuple(
            written_estimate(
                e,
                drawn=None
                if is_nothing(draws)
                else {n: written_as(Drawn, e.propagate(n, draws=draws)) for n in e.parameters},
                physical=written_physical(physical[name], e.chosen) if name in physical else UNSET,
            )
            for name, e in result.estimates.items()
        ),
        **diagnosis_members(diagnosis),
        records=tuple(map(_member, result.of_records, diagnosis.records)) or UNSET,
        local=result.local_names or UNSET,
        declared_gain=UNSET if result.declared_gain is None else result.declared_gain,
        set_aside=dict(result.set_aside.items()) or UNSET,
        validation=UNSET,
        validations=UNSET,
    )


def _response(drive: Drive, found: DriveTime | None) -> WrittenResponse | UnsetType:
    """Return the drive's response to its commands as part of a document.

    UNSET if the force follows each command at once. `found` is the estimated time of the drive;
    None if no time is estimated.
    """
    if not drive.of_held_commands and found is None:
        return UNSET
    declared: dict[str, Any] = {"logged": drive.logged, **drive.path.declared}
    return WrittenResponse(
        lag=drive.lag,
        delay=drive.delay,
        unit=drive.unit if drive.path.declared else UNSET,
        estimated=UNSET
        if found is None
        else written_as(
            WrittenDriveTime,
            found,
            name=found.parameter.name,
            of=found.name,
            nominal=found.parameter.nominal,
            sd=found.deviation,
        ),
        **declared,
    )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedIdentification(ByMethod[SavedEstimate], Presentable, Exact):
    """An identification that was read from a file; see `load_result`.

    It has the attributes of `Identification`: ``saved["idm-iv"].parameters``, `verdict`, `summary`,
    `plot`. Methods that need the rows of the record raise an error. Attributes that are not listed
    have the same meaning as in `Identification`.

    Attributes
    ----------
    file : str
        Name of the file; empty if the result was not read from a file.
    document : WrittenIdentification
        Content of the file.
    declared : Axis or None
        Declaration of the identified axis; None if it is unknown.
    name, signature : str
        Name of the axis, and signature of the generated code of the identification.
    signals : tuple of Signal
        Recorded signals of the axis.
    drive : Drive
        Response of the drive to its commands; its gain is 1.
    estimates : mapping of str to SavedEstimate
    physical : mapping of str to Physical
        Declared parameters by method; empty if they are estimated directly.
    checks : tuple of Check
        Same as `verdict`.
    prefilter : Prefilter
        Prefilter as applied to the record.
    record : RecordInfo
        Record without its samples.
    sampling : Sampling
        Filter and used samples; only the number of excluded samples near reversals is known.
    of_records : tuple of RecordResult
        Results of each record; empty for a single record.
    local_names : mapping of str to tuple of str
        Names by record of each declared parameter with a separate value for each record.
    declared_gain : float or None
        Declared drive gain if the gain is identified; None if the declared gain is used.
    """

    file: str
    document: WrittenIdentification
    declared: Axis | None = None
    name: str
    signature: str
    signals: tuple[Signal, ...]
    drive: Drive
    physical: PhysicalByMethod
    checks: tuple[Check, ...]
    prefilter: Prefilter
    record: RecordInfo
    sampling: Sampling
    of_records: tuple[RecordResult, ...]
    local_names: Mapping[str, tuple[str, ...]]
    declared_gain: float | None

    @classmethod
    def of(
        cls, file: str, written: WrittenIdentification, declared: Axis | None = None
    ) -> "SavedIdentification":
        """Return the identification that a document describes.

        Parameters
        ----------
        file : str
            Name of the file.
        written : WrittenIdentification
        declared : Axis, optional
            The identified axis.
        """
        record, drive, asked = written.record, written.drive, written.requested
        sampling, found = _sampling(written.prefilter, record), drive and drive.estimated
        step = record.period * written.prefilter.decimate
        estimates = {e.method: SavedEstimate.of(e, step) for e in written.estimates}
        path = {n: v for n, v in plain(drive).items() if n != "estimated"} if drive else {}
        physical = {method: _physical(estimate) for method, estimate in estimates.items()}
        return read_as(
            cls,
            written,
            file=file,
            document=written,
            declared=declared,
            name=written.axis,
            signals=tuple(Signal(s.name, s.unit, s.between) for s in written.signals or ()),
            drive=Drive(gain=1.0, **path),  # its times are numbers
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
            checks=read_checks(written.verdict),
            levels=written.levels or DEFAULT_LEVELS,
            requested=None if asked is None else read_as(Prefilter, asked),
            prefilter=sampling.filter.settings,
            record=record,
            sampling=sampling,
            of_records=tuple(
                read_as(
                    RecordResult,
                    member,
                    record=member.record,
                    sampling=_sampling(member.prefilter, member.record),
                    known={name: (v.value or 0.0, v.sd) for name, v in member.known.items()},
                    share_percent=member.apart and member.apart.share_percent,
                    p_value=member.apart and member.apart.p_value,
                )
                for member in written.records or ()
            ),
            local_names=written.local or {},
            declared_gain=written.declared_gain or None,
            set_aside=written.set_aside or {},
        )

    def __repr__(self) -> str:
        records = [self.document.record, *(m.record for m in (self.document.records or ())[1:])]
        return (
            f"saved identification of {self.name} from "
            f"{' and '.join(record.source for record in records)}: {', '.join(self.estimates)}"
        )

    @cached_property
    def axis(self) -> GeneratedAxis:
        """Return the identified axis, built on first use.

        Raises
        ------
        UsageError
            The axis is not in the library and was not given.
        """
        return build(self.own_axis)

    @property
    def own_axis(self) -> Axis:
        """Return the declaration of the axis; raise `UsageError` if it is unknown."""
        if self.declared is None:
            raise UsageError(
                f"{self.file} does not contain the declaration of the axis {self.name!r}. Give the "
                "identified axis (axis).",
                code="result-file",
            )
        return self.declared

    @property
    def left_out(self) -> str:
        """Return the values of the parameters that were left out, as text; empty for none."""
        if self.declared is not None:
            return left_out_text(self.declared)
        return ", ".join(f"{n} = {value:g}" for n, value in (self.document.left_out or {}).items())

    @property
    def declared_parameters(self) -> tuple[Parameter, ...]:
        """Return the declared parameters of the axis.

        Without the declaration they are those parameters in the file that are no combinations.
        """
        if self.declared is not None:
            return self.declared.parameters
        combined = {p.name for p in self.combined}
        values = next(iter(self.estimates.values())).parameters
        return tuple(
            Parameter(name, value.unit) for name, value in values.items() if name not in combined
        )

    @property
    def combined(self) -> tuple[Parameter, ...]:
        """Return the base parameters that are combinations of declared parameters."""
        return tuple({p.name: p for own in self.physical.values() for p in own.combined}.values())

    @property
    def preferred(self) -> SavedEstimate:
        """Return the judged estimate."""
        return self[self.document.judged]

    def part(self, number: int) -> "SavedIdentification":
        """Return the result for one of several records, by its number from 1.

        Separate values of the record are parameters of its axis. If the drive gain is estimated,
        the parameters refer to the declared gain, as in the part of a live result.

        Raises
        ------
        UsageError
            There is no such record.
        """
        place, records = record_index(number, len(self.of_records)), self.of_records
        if not records:
            return self
        record, gain = records[place], self.declared_gain
        part = replace(
            self,
            record=record.record,
            sampling=record.sampling,
            prefilter=record.sampling.filter.settings,
            of_records=(),
        )
        if not (self.local_names or record.known):
            return part
        # The common regression gives the parameters of the record from the common parameters.
        known = {name: [each.known[name] for each in records] for name in record.known}
        joint = joint_form_of(
            self.axis,
            len(records),
            known_of(known, len(records)),
            self.local_names,
            commanded=gain is not None,
        )
        axis = joint.members[place].axis
        estimates = {method: e.part(joint, place) for method, e in self.estimates.items()}
        physical = {
            method: physical_parameters(method, InverseForm(axis), e.distribution)
            for method, e in estimates.items()
        }
        return replace(
            part,
            declared=axis.declared,
            signature=axis.signature,
            estimates=estimates,
            physical=PhysicalByMethod((m, p) for m, p in physical.items() if p is not None),
            local_names={},
            declared_gain=None,
            # Diagnostics of the common parameters do not apply to a single record.
            document=structs.replace(self.document, instruments=None, differences=UNSET),
        )

    @property
    def parts(self) -> "tuple[SavedIdentification, ...]":
        """Return the result for each record; a single record is its own part."""
        return tuple(self.part(i + 1) for i in range(max(len(self.of_records), 1)))

    def validate(self, record: Record, *, like: int | None = None) -> Validation:
        """Return the validation of every frozen estimate on another record; see `validate`."""
        return validate(self, record, like=like)


def identification_facts(result: Identification, draws: int) -> SavedIdentification:
    """Return an identification without its rows, from which tables are made.

    The checks keep their findings, so that settings in sentences are spelled for the user. With
    `draws` above 0 it has a summary of that many draws from the distribution of each estimate.
    """
    written = written_identification(result, draws)
    saved = SavedIdentification.of("", written, result.axis.declared)
    checks = tuple(
        replace(read, finding=live.finding)
        for read, live in zip(saved.checks, result.checks, strict=True)
    )
    return replace(saved, checks=checks)


def _sampling(prefilter: WrittenPrefilter, record: WrittenRecord) -> Sampling:
    """Return filter and used samples of a record, as far as a document describes them."""
    filtered = SampledFilter(read_as(Prefilter, prefilter, drop=None), record.period)
    # Ends not longer than the transient of the filter were not cut off, but have no weight.
    if filtered.dropped != prefilter.drop:
        filtered = replace(filtered, settings=replace(filtered.settings, drop=prefilter.drop))
    return Sampling(
        filter=filtered,
        samples=record.samples,
        segments=record.segments,
        masked=record.masked,
        excluded=((0, prefilter.silent),) if prefilter.silent else (),
    )


def _physical(estimate: SavedEstimate) -> Physical | None:
    """Return the calculated declared parameters of an estimate; None if the file has none."""
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
        covariances=arrays({**(written.covariances or {}), "hac": written.covariance_hac}),
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
            Parameter(name, estimate.parameters[name].unit, description=combination)
            for name, combination in written.base.items()
        ),
    )
