"""Identifications as documents. The names are a contract with other programs."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from msgspec import UNSET, UnsetType

from axisid.estimation.checks import Check, Levels
from axisid.estimation.diagnostics import (
    ColumnComparison,
    InstrumentTests,
    RecordDiagnosis,
    RecordDifference,
)
from axisid.estimation.estimates import HausmanTest
from axisid.estimation.identification import DriveTime, Identification, RecordResult
from axisid.estimation.lack_of_fit import JackknifeInterval, LackOfFit
from axisid.modeling.declaration import Drive
from axisid.support.arrays import Array
from axisid.support.errors import Missing, is_nothing

from .diagnosis import (
    WrittenAlignment,
    WrittenExcitation,
    WrittenLawCheck,
    diagnosis_members,
    record_members,
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
from .values import JsonObject, WrittenKnown, WrittenResult, about, written_as
from .written_estimate import (
    WrittenEstimate,
    drawn_parameters,
    left_out,
    written_estimate,
    written_physical,
)


class WrittenHeld(JsonObject, frozen=True, kw_only=True):
    """A parameter that is held at a declared bound."""

    unit: str
    bound: float
    free: Annotated[float, about("Without the bound, less its bias if it is known.")]
    deviation: Annotated[float, about("Of `free`, by the chosen covariance.")]
    interval_95: Annotated[tuple[float, float], about("To one side of the bound.")]


class WrittenMethodValidation(JsonObject, frozen=True, kw_only=True):
    """One frozen estimate on the second record."""

    method: str
    equation_error_percent: float | None
    own_equation_error_percent: Annotated[
        float | None,
        about("On the record that the estimate was made from."),
    ]
    simulation_error_percent: float | None
    position_error_rms: Annotated[float | None, about("In the coordinate's unit.")]
    tracking_error_percent: Annotated[float | None, about("Of the recorded tracking error.")]
    reason: Annotated[str, about("Why there are no simulated figures.")]
    holds: Annotated[
        bool | UnsetType,
        about(
            "Whether force, simulated loop and parameters are what they are on its own record; the "
            "control law is looked at by itself."
        ),
    ] = UNSET
    own_simulation_error_percent: float | UnsetType | None = UNSET
    own_tracking_error_percent: Annotated[
        float | UnsetType | None,
        about("null where it is not known, as of a result read from a file."),
    ] = UNSET
    anew: Annotated[
        Mapping[str, float | None] | UnsetType | None,
        about("What the second record itself says of the parameters, by the same method."),
    ] = UNSET
    anew_distances: Annotated[
        Mapping[str, float | None] | UnsetType | None,
        about("How far those are from the frozen ones, in HAC deviations of the difference."),
    ] = UNSET
    anew_share_percent: Annotated[
        float | UnsetType | None, about("Force that the difference makes, of all of it.")
    ] = UNSET


class WrittenValidation(WrittenResult, frozen=True, kw_only=True):
    """The frozen estimates on a second record."""

    record: WrittenRecord
    methods: tuple[WrittenMethodValidation, ...]
    time_base: Annotated[
        str | None,
        about("What speaks against the record's sampling period; null for nothing."),
    ]
    law_check: Annotated[
        WrittenLawCheck | UnsetType, about("The declared control law against the second record.")
    ] = UNSET
    holds: Annotated[
        bool | UnsetType,
        about("Whether every estimate does, and the control law is the declared one."),
    ] = UNSET


class WrittenApart(JsonObject, frozen=True, kw_only=True):
    """A record alone beside the others, in the parameters that both tell."""

    own: Annotated[Mapping[str, float], about("As the record alone has them, SI.")]
    common: Annotated[Mapping[str, float], about("As the others have them without it, SI.")]
    deviations: Annotated[
        Mapping[str, float], about("Of the difference, as twins scatter, or HAC.")
    ]
    statistic: Annotated[float, about("Hotelling's, over its degrees of freedom.")]
    freedom: Annotated[tuple[float, float], about("Of F.")]
    p_value: Annotated[float, about("That chance alone makes as much, of one record.")]
    share_percent: Annotated[float, about("Force that the difference makes, of the record's.")]


class WrittenMember(JsonObject, frozen=True, kw_only=True):
    """One of several records, by the estimate that is judged."""

    name: Annotated[str, about("As the verdict names it.")]
    record: WrittenRecord
    prefilter: WrittenPrefilter
    known: Annotated[Mapping[str, WrittenKnown], about("What is known of it, SI, by name.")]
    rows: int
    weight: Annotated[float, about("Of its rows, by the inverse of its noise.")]
    noise: Annotated[float, about("Root mean square of its residuals.")]
    equation_error_percent: float
    simulation_error_percent: float | None
    apart: Annotated[
        WrittenApart | None, about("null where the record alone does not tell the parameters.")
    ]
    law_check: WrittenLawCheck
    alignment: WrittenAlignment
    verdict: Annotated[tuple[Check, ...], about("The checks that are of one record.")]
    lack_of_fit: LackOfFit | UnsetType = UNSET
    measured_motion: Annotated[
        Mapping[str, ColumnComparison] | UnsetType,
        about("A measured velocity and acceleration beside what is differentiated, by role."),
    ] = UNSET


class WrittenIdentification(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.identification/1"
):
    """What `axisid identify --json` writes."""

    axis: str
    signature: Annotated[str, about("sha256 of what the generated code was made from.")]
    left_out: Annotated[
        Mapping[str, float] | UnsetType,
        about("What stands for the parameters that were left out, SI, by name."),
    ] = UNSET
    signals: Annotated[
        tuple[WrittenSignal, ...] | UnsetType,
        about("Recorded signals that the axis declares, if there are any."),
    ] = UNSET
    drive: Annotated[
        WrittenResponse | UnsetType, about("Of one that does not act as commanded.")
    ] = UNSET
    drive_force: Annotated[
        str | UnsetType, about("What the drive makes of the control, where it is no gain alone.")
    ] = UNSET
    drive_remark: Annotated[
        str | UnsetType, about("What of the motor is not in the drive's force, if anything.")
    ] = UNSET
    record: WrittenRecord
    prefilter: WrittenPrefilter
    requested: Annotated[
        WrittenRequest | None, about("The prefilter before it suited the record; null if unknown.")
    ]
    estimates: tuple[WrittenEstimate, ...]
    judged: Annotated[str, about("The method that the checks of one estimate are of.")]
    law_check: WrittenLawCheck
    instruments: InstrumentTests | None
    excitation: Annotated[Mapping[str, WrittenExcitation], about("By parameter.")]
    alignment: WrittenAlignment
    verdict: tuple[Check, ...]
    lack_of_fit: Annotated[LackOfFit | UnsetType, about("Where the reference repeats.")] = UNSET
    model_bands: Annotated[
        Mapping[str, Mapping[str, JackknifeInterval]] | UnsetType,
        about("Of the model's error, by method and parameter."),
    ] = UNSET
    differences: Annotated[
        Mapping[str, Mapping[str, HausmanTest]] | UnsetType,
        about("Of two estimates, as ``idm-iv less didim``, by parameter."),
    ] = UNSET
    measured_motion: Annotated[
        Mapping[str, ColumnComparison] | UnsetType,
        about("A measured velocity and acceleration beside what is differentiated, by role."),
    ] = UNSET
    skipped: Annotated[
        Mapping[str, str],
        about("Methods that axis or record do not allow, with the reason."),
    ]
    failed: Annotated[Mapping[str, str], about("Methods that came to nothing, with the reason.")]
    levels: Levels | UnsetType = UNSET
    validation: Annotated[WrittenValidation | UnsetType, about("With --validate.")] = UNSET
    validations: Annotated[
        tuple[WrittenValidation, ...] | UnsetType,
        about("With --validate more than once, each of them; `validation` is the first."),
    ] = UNSET
    records: Annotated[
        tuple[WrittenMember, ...] | UnsetType,
        about("Where there are several, all of them; `record` and `prefilter` are the first's."),
    ] = UNSET
    local: Annotated[
        Mapping[str, tuple[str, ...]] | UnsetType,
        about("Parameters that records have for themselves: their names by record."),
    ] = UNSET
    declared_gain: Annotated[
        float | UnsetType,
        about("Of the drive, where `drive_gain` is among the parameters."),
    ] = UNSET
    held: Annotated[
        Mapping[str, WrittenHeld] | UnsetType,
        about("With --bounded: parameters that are held at a declared bound, by name."),
    ] = UNSET
    set_aside: Annotated[
        Mapping[str, str] | UnsetType,
        about("Records that could not be used, with the reason."),
    ] = UNSET


def _member(of_one: RecordResult, diagnosis: RecordDiagnosis) -> WrittenMember:
    apart = diagnosis.apart
    return written_as(
        WrittenMember,
        of_one,
        record=written_record(of_one.record),
        prefilter=written_prefilter(of_one.sampling),
        known={name: WrittenKnown(value=v, sd=sd) for name, (v, sd) in of_one.known.items()},
        apart=None if isinstance(apart, Missing) else _apart(apart),
        **record_members(diagnosis, ()),
    )


def _apart(apart: RecordDifference) -> WrittenApart:
    def named(values: Array) -> dict[str, float]:
        return dict(zip(apart.names, map(float, np.ravel(values)), strict=True))

    return written_as(
        WrittenApart,
        apart,
        own=named(apart.own),
        common=named(apart.others),
        deviations=named(apart.deviations),
    )


def written_identification(result: Identification, draws: int = 0) -> WrittenIdentification:
    """An identification with its diagnosis; `draws` as in `Identification.to_dict`."""
    diagnosis, physical = result.diagnosis, result.physical
    drive = result.axis.axis.drive
    return written_as(
        WrittenIdentification,
        result,
        axis=result.axis.axis.name,
        signature=result.axis.signature,
        left_out=left_out(result.axis),
        held={
            each.name: written_as(
                WrittenHeld, each, interval_95=tuple(sorted((each.bound, each.reach)))
            )
            for each in result.held
        }
        or UNSET,
        signals=tuple(written_as(WrittenSignal, s) for s in result.axis.axis.signals) or UNSET,
        drive=_response(drive, result.drive_time),
        drive_force=UNSET if drive.is_gain else drive.force_text(result.axis.axis.coordinate),
        drive_remark=drive.remark or UNSET,
        record=written_record(result.record),
        prefilter=written_prefilter(result.data.sampling),
        requested=None
        if result.requested is None
        else written_as(WrittenRequest, result.requested),
        estimates=tuple(
            written_estimate(
                e,
                drawn=None if is_nothing(draws) else drawn_parameters(e, draws),
                physical=written_physical(physical[name], e.chosen) if name in physical else UNSET,
            )
            for name, e in result.estimates.items()
        ),
        **diagnosis_members(diagnosis, [q.name for q in result.preferred.quantities]),
        records=tuple(map(_member, result.of_records, diagnosis.records)) or UNSET,
        local=result.local_names or UNSET,
        declared_gain=UNSET if result.declared_gain is None else result.declared_gain,
        set_aside=dict(result.set_aside.items()) or UNSET,
        validation=UNSET,
        validations=UNSET,
    )


def _response(drive: Drive, found: DriveTime | None) -> WrittenResponse | UnsetType:
    if not drive.of_held_commands and found is None:
        return UNSET
    told: dict[str, Any] = {"logged": drive.logged, **drive.path.declared}
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
        **told,
    )
