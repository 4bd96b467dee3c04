"""Results as documents. The names are a contract with other programs."""

from collections.abc import Iterable, Mapping, Set
from typing import Any, TypeVar

import numpy as np
from msgspec import UNSET, UnsetType

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.diagnostics import RecordDiagnosis, RecordDifference
from axisid.estimation.estimates import Estimate, Physical, Value
from axisid.estimation.identification import DriveTime, Identification, RecordResult
from axisid.estimation.problems import ParameterAtBound
from axisid.estimation.records import Record
from axisid.estimation.regression import Drawn
from axisid.estimation.signals import Sampling
from axisid.modeling.declaration import Drive
from axisid.presentation.schema import (
    Matrix,
    WrittenApart,
    WrittenDirectValue,
    WrittenDriveTime,
    WrittenEstimate,
    WrittenHeld,
    WrittenIdentification,
    WrittenKnown,
    WrittenMember,
    WrittenPhysical,
    WrittenPrefilter,
    WrittenRecord,
    WrittenRequest,
    WrittenResponse,
    WrittenSignal,
    WrittenValue,
)
from axisid.support.arrays import Array, finite
from axisid.support.errors import Missing, is_nothing

from .diagnosis import diagnosis_members, record_members
from .same_members import written_as

T = TypeVar("T")
_NAMED = frozenset({"iid", "robust", "hac"})  # covariances that have members of their own
_NAMED_DIRECT = frozenset({"iid", "hac"})  # the same of the direct model's parameters
_NAMED_PHYSICAL = frozenset({"hac"})  # and of those that follow from known values


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
        held={each.name: _held(each) for each in result.held} or UNSET,
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
                drawn=None if is_nothing(draws) else _drawn(e, draws),
                physical=_physical(physical[name], e.chosen) if name in physical else UNSET,
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


def _held(held: ParameterAtBound) -> WrittenHeld:
    low, high = sorted((held.bound, held.reach))
    return written_as(WrittenHeld, held, interval_95=(low, high))


def _response(drive: Drive, found: DriveTime | None) -> WrittenResponse | UnsetType:
    if not drive.of_held_commands and found is None:
        return UNSET
    path: dict[str, Any] = {**drive.path.declared}
    if path:
        path["unit"] = drive.unit
    if found is not None:
        path["estimated"] = _drive_time(found)
    path |= {"lag": drive.lag, "delay": drive.delay, "logged": drive.logged}
    return WrittenResponse(**path)


def _drive_time(found: DriveTime) -> WrittenDriveTime:
    return written_as(
        WrittenDriveTime,
        found,
        name=found.parameter.name,
        of=found.name,
        nominal=found.parameter.nominal,
        sd=found.deviation,
    )


def written_record(record: Record) -> WrittenRecord:
    """Provenance and size of a record."""
    origin = record.provenance
    return written_as(
        WrittenRecord,
        record,
        source=origin.source,
        given=origin.given or None,
        path=origin.path or None,
        sha256=origin.sha256 or None,
        columns=origin.columns,
        truth=origin.truth or None,
        assumed=(*origin.assumed, *origin.doubts),
        repairs=origin.repairs,
        samples=len(record),
        injected_at=record.injected_at or UNSET,
        motion=UNSET if record.motion == ("position",) else record.motion,
        windows=record.windows or UNSET,
    )


def written_prefilter(sampling: Sampling) -> WrittenPrefilter:
    """Settings of a prefilter; `drop` as it was applied, nothing left open."""
    return written_as(
        WrittenPrefilter,
        sampling.prefilter,
        drop=sampling.filter.dropped,
        silent=sampling.excluded_samples,
    )


def written_estimate(
    estimate: Estimate,
    drawn: Mapping[str, Drawn] | Any = UNSET,
    physical: WrittenPhysical | Any = UNSET,
) -> WrittenEstimate:
    """One estimate; statistics that are not finite become None."""
    direct, iterates = bool(estimate.ddm_quantities), estimate.iterates
    return written_as(
        WrittenEstimate,
        estimate,
        parameters={name: written_value(v) for name, v in estimate.parameters.items()},
        theta_ddm=_direct(estimate) if direct else None,
        covariance=matrix(estimate.covariances["iid"]),
        covariance_robust=matrix(estimate.covariances["robust"]),
        covariance_hac=matrix(estimate.covariances["hac"]),
        covariances=_further(estimate.covariances, estimate.chosen, _NAMED),
        theta_ddm_covariance=matrix(estimate.ddm_covariances["iid"]) if direct else None,
        theta_ddm_covariance_hac=matrix(estimate.ddm_covariances["hac"]) if direct else None,
        theta_ddm_covariances=_further(estimate.ddm_covariances, estimate.chosen, _NAMED_DIRECT),
        chains=tuple(each.likeliest for each in estimate.inference.chains) or UNSET,
        chosen_covariance=estimate.chosen,
        rows=len(estimate.y),
        iterations=tuple(_named(estimate.quantities, i.physical) for i in iterates),
        theta_ddm_iterations=tuple(_named(estimate.ddm_quantities, i.theta) for i in iterates)
        if direct
        else None,
        iteration_simulation_errors_percent=tuple(i.simulation_error_percent for i in iterates),
        started=estimate.started or UNSET,
        loss=UNSET if estimate.counts is None else estimate.loss,
        light_rows=UNSET if estimate.counts is None else int(estimate.light_rows.sum()),
        curvatures={
            q.name: finite(c) for q, c in zip(estimate.quantities, estimate.curvatures, strict=True)
        },
        freedom=_named(estimate.quantities, estimate.freedom[estimate.chosen]),
        drawn=drawn,
        physical=physical,
        gain_slopes=_slopes(estimate.quantities, estimate.gain_slopes),
        theta_ddm_gain_slopes=_slopes(estimate.ddm_quantities, estimate.theta_gain_slopes)
        if direct
        else None,
    )


def _slopes(quantities: Iterable[Quantity], slopes: Array | None) -> dict[str, float] | None:
    return None if slopes is None else _named(quantities, slopes)


def _direct(estimate: Estimate) -> dict[str, WrittenDirectValue]:
    return {
        q.name: written_as(
            WrittenDirectValue,
            estimate.ddm_parameters[q.name],
            deviations=_others(estimate.ddm_parameters[q.name].deviations) or UNSET,
            expression=q.expression,
        )
        for q in estimate.ddm_quantities
    }


def _drawn(estimate: Estimate, draws: int) -> dict[str, Drawn]:
    """Every parameter over draws; None where no draw gave an axis."""
    return {
        name: written_as(Drawn, estimate.propagate(name, draws=draws))
        for name in estimate.parameters
    }


def _physical(physical: Physical, chosen: str) -> WrittenPhysical:
    return written_as(
        WrittenPhysical,
        physical,
        parameters={name: written_value(v) for name, v in physical.parameters.items()},
        covariance_hac=matrix(physical.covariances["hac"]),
        covariances=_further(physical.covariances, chosen, _NAMED_PHYSICAL),
        base={p.name: p.description for p in physical.combined},
        fixed={
            p.name: written_as(WrittenKnown, p, value=p.known, sd=p.known_sd)
            for p in physical.known
        },
    )


def left_out(axis: GeneratedAxis) -> dict[str, float]:
    """What stands for the parameters that were left out, by name."""
    return {p.name: p.known for p in axis.declared.left_out if p.known is not None}


def _others(by_covariance: Mapping[str, T]) -> dict[str, T]:
    """What is of covariances that have no member of their own."""
    return {name: each for name, each in by_covariance.items() if name not in _NAMED}


def _further(
    covariances: Mapping[str, Array], chosen: str, written: Set[str]
) -> dict[str, Matrix] | UnsetType:
    """Covariances that are not written elsewhere: the chosen one, and those of later rows.

    Robust and i.i.d. ones that no interval is of are left out, as in every file so far.
    """
    wanted = {chosen, *_others(covariances)} - written
    return {name: matrix(c) for name, c in covariances.items() if name in wanted} or UNSET


def written_value(value: Value) -> WrittenValue:
    """A number with unit, deviations and interval."""
    return written_as(WrittenValue, value, deviations=_others(value.deviations) or UNSET)


def matrix(values: Array) -> Matrix:
    """An array as a document holds it."""
    return tuple(map(tuple, values.tolist()))


def _named(quantities: Iterable[Quantity], values: Array) -> dict[str, float]:
    return {q.name: float(value) for q, value in zip(quantities, values, strict=True)}
