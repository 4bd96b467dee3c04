"""The diagnosis as a document."""

from collections.abc import Sequence
from typing import Any

from msgspec import UNSET

from axisid.estimation.diagnostics import Alignment, Diagnosis, RecordDiagnosis
from axisid.estimation.diagnostics.law import LawCheck
from axisid.presentation.schema import (
    WrittenAlignment,
    WrittenExcitation,
    WrittenLawCheck,
)
from axisid.support.missing import Missing

from .same_members import written_as

#: How the meaning of a law's check begins that could not be made.
NOT_EVALUATED = "not evaluated: "


def written_diagnosis(diagnosis: Diagnosis) -> dict[str, Any]:
    """Everything that was measured of a result, by member."""
    names = [each.name for each in diagnosis.excitation]
    members = diagnosis_members(diagnosis, names)
    return {name: each for name, each in members.items() if each is not UNSET}


def diagnosis_members(diagnosis: Diagnosis, names: Sequence[str]) -> dict[str, Any]:
    """Everything that was measured of a result, then the checks, by member of its document.

    Parameters
    ----------
    diagnosis : Diagnosis
    names : sequence of str
        Of the physical parameters.
    """
    return {
        "judged": diagnosis.preferred,
        "instruments": diagnosis.instruments,
        "excitation": {e.name: written_as(WrittenExcitation, e) for e in diagnosis.excitation},
        **record_members(diagnosis, names),
        "model_bands": {
            method: dict(of_one) for method, of_one in diagnosis.bands.items() if of_one
        }
        or UNSET,
        "differences": {pair: dict(of_one) for pair, of_one in diagnosis.differences.items()}
        or UNSET,
    }


def record_members(found: Diagnosis | RecordDiagnosis, names: Sequence[str]) -> dict[str, Any]:
    """What is measured of one record as well as of a whole result, by member of its document."""
    return {
        "law_check": written_law(found.law),
        "alignment": _alignment(found.alignment, names),
        "verdict": found.verdict,
        "lack_of_fit": found.lack_of_fit or UNSET,
        "measured_motion": {
            role: each for role, each in found.motions.items() if not isinstance(each, Missing)
        }
        or UNSET,
    }


def written_law(check: LawCheck | Missing) -> WrittenLawCheck:
    """The control law's check; `passed` is None where it could not be made."""
    if isinstance(check, Missing):
        return WrittenLawCheck(passed=None, meaning=f"{NOT_EVALUATED}{check}")
    return written_as(WrittenLawCheck, check, meaning=check.sentence)


def _alignment(profile: Alignment | Missing, names: Sequence[str]) -> WrittenAlignment:
    """The delay of the force; `names` are of the parameters where it has none of its own."""
    if isinstance(profile, Missing):
        return WrittenAlignment(best=None, reason=profile.reason)
    sensitivity = zip(profile.names or names, profile.sensitivity.tolist(), strict=True)
    return written_as(WrittenAlignment, profile, sensitivity=dict(sensitivity), reason=UNSET)
