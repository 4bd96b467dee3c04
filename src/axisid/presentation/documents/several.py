"""Several records of a result as a document."""

from typing import Any

import numpy as np

from axisid.estimation.diagnostics import Apart, RecordDiagnosis
from axisid.estimation.identification import Identification, OfRecord
from axisid.presentation.schema import (
    WrittenApart,
    WrittenKnown,
    WrittenMember,
    WrittenPrefilter,
    WrittenRecord,
)
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from axisid.support.remedy import Wording

from .diagnosis import record_members


def several_members(
    result: Identification,
    records: list[WrittenRecord],
    prefilters: list[WrittenPrefilter],
    wording: Wording,
) -> dict[str, Any]:
    """What a document has of several records alone, by member; nothing of one."""
    found: dict[str, Any] = {}
    if result.set_aside:
        found["set_aside"] = {n: why.worded(wording) for n, why in result.set_aside.items()}
    if not result.of_records:
        return found
    found["records"] = tuple(
        _member(of_one, diagnosis, record, prefilter, wording)
        for of_one, diagnosis, record, prefilter in zip(
            result.of_records, result.diagnosis.records, records, prefilters, strict=True
        )
    )
    if result.local_names:
        found["local"] = dict(result.local_names)
    if result.declared_gain is not None:
        found["declared_gain"] = result.declared_gain
    return found


def _member(
    of_one: OfRecord,
    diagnosis: RecordDiagnosis,
    record: WrittenRecord,
    prefilter: WrittenPrefilter,
    wording: Wording,
) -> WrittenMember:
    apart = diagnosis.apart
    return WrittenMember(
        name=of_one.name,
        record=record,
        prefilter=prefilter,
        known={name: WrittenKnown(value=v, sd=sd) for name, (v, sd) in of_one.known.items()},
        rows=of_one.rows,
        weight=of_one.weight,
        noise=of_one.noise,
        equation_error_percent=of_one.equation_error_percent,
        simulation_error_percent=of_one.simulation_error_percent,
        apart=None if isinstance(apart, Missing) else _apart(apart),
        **record_members(diagnosis, (), wording),
    )


def _apart(apart: Apart) -> WrittenApart:
    def named(values: Array) -> dict[str, float]:
        return dict(zip(apart.names, map(float, np.ravel(values)), strict=True))

    return WrittenApart(
        own=named(apart.own),
        common=named(apart.others),
        deviations=named(apart.deviations),
        statistic=apart.statistic,
        freedom=apart.freedom,
        p_value=apart.p_value,
        share_percent=apart.share_percent,
    )
