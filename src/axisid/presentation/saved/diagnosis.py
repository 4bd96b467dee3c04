"""What was measured of a result, read back; what was not finite is NaN or infinite."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from axisid.estimation.diagnostics import (
    Alignment,
    Diagnosis,
    Excitation,
    RecordDiagnosis,
    RecordDifference,
)
from axisid.estimation.diagnostics.law import LawCheck
from axisid.presentation.documents import NOT_EVALUATED, read_as
from axisid.presentation.schema import (
    WrittenAlignment,
    WrittenApart,
    WrittenIdentification,
    WrittenLawCheck,
    WrittenMember,
)
from axisid.support.arrays import Array, frozen
from axisid.support.missing import Missing


def read_diagnosis(written: WrittenIdentification) -> Diagnosis:
    """The diagnosis of a document."""
    units = {name: v.unit for name, v in written.estimates[0].parameters.items()}
    return Diagnosis(
        preferred=written.judged,
        instruments=written.instruments,
        excitation=tuple(
            read_as(Excitation, e, name=name) for name, e in written.excitation.items()
        ),
        **_of_record(written, units),
        bands=written.model_bands or {},
        differences=written.differences or {},
        records=tuple(
            RecordDiagnosis(**_of_record(member, units), apart=read_apart(member.apart))
            for member in written.records or ()
        ),
    )


def _of_record(
    written: WrittenIdentification | WrittenMember, units: Mapping[str, str]
) -> dict[str, Any]:
    """What is measured of one record as well as of a whole result."""
    return {
        "law": _law(written.law_check),
        "alignment": _alignment(written.alignment, units),
        "verdict": written.verdict,
        "lack_of_fit": written.lack_of_fit or None,
        "motions": written.measured_motion or {},
    }


def _law(written: WrittenLawCheck) -> LawCheck | Missing:
    if written.passed is None:
        return Missing(written.meaning.removeprefix(NOT_EVALUATED))
    return read_as(LawCheck, written, factors=dict(written.factors or {}), delay=written.delay or 0)


def _alignment(written: WrittenAlignment, units: Mapping[str, str]) -> Alignment | Missing:
    if written.best is None:
        return Missing(written.reason or "")
    sensitivity = frozen([*(written.sensitivity or {}).values()])
    return read_as(
        Alignment,
        written,
        at_the_end=bool(written.at_the_end),
        by_instruments=bool(written.by_instruments),
        sensitivity=sensitivity,
        names=tuple(written.sensitivity or {}),
        units=tuple(units.get(name, "") for name in written.sensitivity or {}),
    )


def read_apart(written: WrittenApart | None) -> RecordDifference | Missing:
    """A record alone beside the others."""
    if written is None:
        return Missing("the record alone does not tell the parameters")
    return read_as(
        RecordDifference,
        written,
        names=tuple(written.own),
        own=_numbers(written.own),
        others=_numbers(written.common),
        deviations=_numbers(written.deviations),
    )


def _numbers(written: Mapping[str, float]) -> Array:
    return frozen(np.array([*written.values()], dtype=float))
