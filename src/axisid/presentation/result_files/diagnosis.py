"""What was measured of a result: its document, written and read back."""

from collections.abc import Mapping
from typing import Annotated, Any

from msgspec import UNSET, UnsetType

from axisid.estimation.diagnostics import Diagnosis, RecordDiagnosis
from axisid.estimation.diagnostics.control_law import LawAgreement
from axisid.support.arrays import MaybeInfinite, MaybeNan
from axisid.support.errors import Missing

from .checks import finding_data, written_checks
from .json_objects import JsonObject, about, by_name, written_as


class WrittenLawCheck(JsonObject, frozen=True, kw_only=True):
    """The declared control law against the record."""

    passed: Annotated[bool | None, about("null where it could not be made.")]
    factors: Annotated[
        Mapping[str, float] | UnsetType,
        about("Of the law's own terms; each is 1 if the law is the drive's."),
    ] = UNSET
    residual_percent: float | UnsetType | None = UNSET
    fitted_residual_percent: float | UnsetType | None = UNSET
    delay: Annotated[
        int | UnsetType,
        about("Samples by which the control follows the law best."),
    ] = UNSET
    meaning: str
    finding: Annotated[
        Mapping[str, Any] | UnsetType,
        about("What was found as data: its kind, and its numbers, names and units."),
    ] = UNSET


class WrittenExcitation(JsonObject, frozen=True, kw_only=True):
    """What the motion shows of one parameter."""

    share: Annotated[float, about("Of the force's norm.")]
    inflation: Annotated[MaybeInfinite, about("Variance inflation.")]
    alike: tuple[str, ...]
    lacking: Annotated[
        tuple[str, ...],
        about("What the motion lacks of what it acts by, in words: why, where it is vague."),
    ]
    rows: Annotated[
        float | UnsetType,
        about("How many rows of equal weight would tell of it what the rows do."),
    ] = UNSET
    largest_share: Annotated[
        float | UnsetType | None,
        about("Its largest part of the force along the record over the largest force."),
    ] = UNSET
    natural: Annotated[
        float | UnsetType | None,
        about("What the force and the motion of the record make of its unit."),
    ] = UNSET


class WrittenAlignment(JsonObject, frozen=True, kw_only=True):
    """The delay of the force."""

    best: Annotated[float | None, about("Samples earlier at which the force fits the motion best.")]
    deviation: Annotated[
        MaybeNan | UnsetType, about("Of it, samples, by twins; HAC without them.")
    ] = UNSET
    at_the_end: Annotated[
        bool | UnsetType, about("It left the range in which it is looked for.")
    ] = UNSET
    by_instruments: Annotated[
        bool | UnsetType, about("By the simulated loop and its twins; else by least squares.")
    ] = UNSET
    sensitivity: Annotated[
        Mapping[str, float] | UnsetType,
        about("Change of each parameter per sample."),
    ] = UNSET
    reason: Annotated[str | UnsetType, about("Why it could not be measured.")] = UNSET


def diagnosis_members(diagnosis: Diagnosis) -> dict[str, Any]:
    """Everything that was measured of a result, then the checks, by member of its document."""
    return {
        "judged": diagnosis.preferred,
        "instruments": diagnosis.instruments,
        "excitation": {e.name: written_as(WrittenExcitation, e) for e in diagnosis.excitation},
        **record_members(diagnosis),
        "model_bands": {
            method: dict(of_one) for method, of_one in diagnosis.bands.items() if of_one
        }
        or UNSET,
        "with_missing_terms": dict(diagnosis.with_missing_terms) or UNSET,
        "differences": {pair: dict(of_one) for pair, of_one in diagnosis.differences.items()}
        or UNSET,
    }


def record_members(found: RecordDiagnosis) -> dict[str, Any]:
    """What is measured of one record as well as of a whole result, by member of its document."""
    profile = found.alignment
    return {
        "law_check": written_law(found.law),
        "alignment": WrittenAlignment(best=None, reason=profile.reason)
        if isinstance(profile, Missing)
        else written_as(
            WrittenAlignment,
            profile,
            sensitivity=by_name(profile.names, profile.sensitivity),
            reason=UNSET,
        ),
        "verdict": written_checks(found.verdict),
        "lack_of_fit": found.lack_of_fit or UNSET,
        "measured_motion": {
            role: each for role, each in found.motions.items() if not isinstance(each, Missing)
        }
        or UNSET,
    }


def written_law(check: LawAgreement | Missing) -> WrittenLawCheck:
    """Return the control law's check; `passed` is None where it could not be made."""
    if isinstance(check, Missing):
        return WrittenLawCheck(passed=None, meaning=f"not evaluated: {check}")
    return written_as(WrittenLawCheck, check, finding=finding_data(check.finding))
