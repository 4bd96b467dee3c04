"""Diagnostics of a result as members of its document, written and read back."""

from collections.abc import Mapping
from typing import Annotated, Any

from msgspec import UNSET, UnsetType

from axisid.estimation.diagnostics import Diagnosis, RecordDiagnosis
from axisid.estimation.diagnostics.control_law import LawAgreement
from axisid.support.arrays import MaybeInfinite, MaybeNan
from axisid.support.missing import Missing
from axisid.support.settings import settings_in_python

from .checks import finding_data, written_checks
from .json_objects import JsonObject, about, by_name, written_as


class WrittenLawCheck(JsonObject, frozen=True, kw_only=True):
    """Comparison of the declared control law with the record."""

    passed: Annotated[bool | None, about("null if it could not be evaluated.")]
    factors: Annotated[
        Mapping[str, float] | UnsetType,
        about("Factors of the terms of the law; each is 1 if the drive follows the declared law."),
    ] = UNSET
    residual_percent: float | UnsetType | None = UNSET
    fitted_residual_percent: float | UnsetType | None = UNSET
    delay: Annotated[
        int | UnsetType,
        about("Delay of the control that fits the law best, in samples."),
    ] = UNSET
    meaning: str
    finding: Annotated[
        Mapping[str, Any] | UnsetType,
        about("Result of the check as data: its kind, and its numbers, names and units."),
    ] = UNSET


class WrittenExcitation(JsonObject, frozen=True, kw_only=True):
    """Excitation of one parameter by the motion."""

    share: Annotated[
        float, about("Norm of its part of the force, relative to the norm of the force.")
    ]
    inflation: Annotated[MaybeInfinite, about("Variance inflation factor.")]
    alike: Annotated[tuple[str, ...], about("Parameters that are nearly collinear with it.")]
    lacking: Annotated[
        tuple[str, ...],
        about("Missing excitation, as text: the reason if the parameter is not identified well."),
    ]
    rows: Annotated[
        float | UnsetType,
        about("Effective number of rows: rows of equal weight with the same information."),
    ] = UNSET
    largest_share: Annotated[
        float | UnsetType | None,
        about("Largest magnitude of its part of the force, relative to the largest force."),
    ] = UNSET
    natural: Annotated[
        float | UnsetType | None,
        about("Usual magnitude of a parameter in its unit, from force and motion of the record."),
    ] = UNSET


class WrittenAlignment(JsonObject, frozen=True, kw_only=True):
    """Delay of the force relative to the motion."""

    best: Annotated[float | None, about("Samples by which the force acts after it is recorded.")]
    deviation: Annotated[
        MaybeNan | UnsetType,
        about("Standard error of `best`, samples, from simulated replicas; HAC without them."),
    ] = UNSET
    at_the_end: Annotated[
        bool | UnsetType, about("True if `best` is at the end of the search range.")
    ] = UNSET
    by_instruments: Annotated[
        bool | UnsetType,
        about("True if estimated with instruments and simulated replicas; else least squares."),
    ] = UNSET
    sensitivity: Annotated[
        Mapping[str, float] | UnsetType,
        about("Change of each parameter per sample."),
    ] = UNSET
    reason: Annotated[str | UnsetType, about("Reason why it could not be measured.")] = UNSET


def diagnosis_members(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return all diagnostics and checks of a result, by member of its document."""
    return {
        "judged": diagnosis.preferred,
        "instruments": diagnosis.instruments,
        "excitation": {e.name: written_as(WrittenExcitation, e) for e in diagnosis.excitation},
        **record_members(diagnosis),
        "model_bands": {
            method: dict(by_parameter)
            for method, by_parameter in diagnosis.bands.items()
            if by_parameter
        }
        or UNSET,
        "with_missing_terms": dict(diagnosis.with_missing_terms) or UNSET,
        "differences": {
            pair: dict(by_parameter) for pair, by_parameter in diagnosis.differences.items()
        }
        or UNSET,
    }


def record_members(found: RecordDiagnosis) -> dict[str, Any]:
    """Return the diagnostics that single records and whole results both have, by member."""
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
    """Return the check of the control law; `passed` is None if it could not be evaluated."""
    if isinstance(check, Missing):
        return WrittenLawCheck(passed=None, meaning=f"not evaluated: {check}")
    with settings_in_python():
        return written_as(WrittenLawCheck, check, finding=finding_data(check.finding))
