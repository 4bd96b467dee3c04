"""The diagnosis as a document."""

from collections.abc import Sequence
from typing import Any

import msgspec
from msgspec import UNSET, UnsetType

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Diagnosis, RecordDiagnosis
from axisid.estimation.diagnostics.estimates import Endogeneity, InstrumentTests
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.diagnostics.loop import Alignment
from axisid.estimation.noise import Attenuation
from axisid.estimation.regression import ResidualTests
from axisid.presentation.schema import (
    WrittenAlignment,
    WrittenAttenuation,
    WrittenAutocorrelation,
    WrittenBand,
    WrittenCheck,
    WrittenCrossCorrelation,
    WrittenEndogeneity,
    WrittenExcitation,
    WrittenInstruments,
    WrittenLackOfFit,
    WrittenLawCheck,
    WrittenMotionComparison,
    WrittenNoiseBias,
    WrittenNormality,
    WrittenResidualTests,
    WrittenSetting,
    WrittenStrength,
)
from axisid.support.arrays import Array, finite, finite_tree
from axisid.support.missing import Missing
from axisid.support.remedy import Setting, as_options

from .same_members import written_as

#: How the meaning of a law's check begins that could not be made.
NOT_EVALUATED = "not evaluated: "


def diagnosis_dict(diagnosis: Diagnosis) -> dict[str, Any]:
    """Everything that was measured of a result, as plain numbers, texts and lists."""
    members = diagnosis_members(diagnosis, [each.name for each in diagnosis.excitation])
    there = {name: each for name, each in members.items() if each is not UNSET}
    return dict(finite_tree(msgspec.to_builtins(there, enc_hook=lambda value: value.item())))


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
        "instruments": _instruments(diagnosis.instruments),
        "endogeneity": _endogeneity(diagnosis.endogeneity, names),
        "excitation": {e.name: written_as(WrittenExcitation, e) for e in diagnosis.excitation},
        **record_members(diagnosis, names),
        "model_bands": {
            method: {
                name: written_as(WrittenBand, band, interval_95=band.interval)
                for name, band in of_one.items()
            }
            for method, of_one in diagnosis.bands.items()
            if of_one
        }
        or UNSET,
        "noise_bias": {
            method: {name: written_as(WrittenNoiseBias, bias) for name, bias in of_one.items()}
            for method, of_one in diagnosis.noise_biases.items()
        }
        or UNSET,
        "attenuation": _attenuation(diagnosis.attenuation),
    }


def record_members(found: Diagnosis | RecordDiagnosis, names: Sequence[str]) -> dict[str, Any]:
    """What is measured of one record as well as of a whole result, by member of its document."""
    left = found.lack_of_fit
    return {
        "law_check": law_document(found.law),
        "alignment": _alignment(found.alignment, names),
        "verdict": tuple(map(check_document, found.verdict)),
        "lack_of_fit": UNSET if left is None else written_as(WrittenLackOfFit, left),
        "measured_motion": {
            role: written_as(WrittenMotionComparison, each)
            for role, each in found.motions.items()
            if not isinstance(each, Missing)
        }
        or UNSET,
    }


def law_document(check: LawCheck | Missing) -> WrittenLawCheck:
    """The control law's check; `passed` is None where it could not be made."""
    if isinstance(check, Missing):
        return WrittenLawCheck(
            passed=None, meaning=f"{NOT_EVALUATED}{check.note.worded(as_options)}"
        )
    return written_as(WrittenLawCheck, check, meaning=check.note.worded(as_options))


def _instruments(tests: InstrumentTests | None) -> WrittenInstruments | None:
    if tests is None:
        return None
    return WrittenInstruments(
        columns=tuple(written_as(WrittenStrength, column) for column in tests.columns),
        condition_number=finite(tests.condition_number),
    )


def _endogeneity(test: Endogeneity | Missing, names: Sequence[str]) -> WrittenEndogeneity | None:
    if isinstance(test, Missing):
        return None
    return WrittenEndogeneity(
        statistic=finite(test.statistic),
        p_value=finite(test.p_value),
        p_values=dict(zip(names, map(finite, test.by_parameter), strict=True)),
    )


def _alignment(profile: Alignment | Missing, names: Sequence[str]) -> WrittenAlignment:
    """The delay of the force; `names` are of the parameters where it has none of its own."""
    if isinstance(profile, Missing):
        return WrittenAlignment(best=None, reason=profile.note.worded(as_options))
    sensitivity = zip(profile.names or names, profile.sensitivity.tolist(), strict=True)
    return written_as(WrittenAlignment, profile, sensitivity=dict(sensitivity), reason=UNSET)


def _attenuation(found: Attenuation | Missing) -> WrittenAttenuation | UnsetType:
    return UNSET if isinstance(found, Missing) else written_as(WrittenAttenuation, found)


def check_document(check: Check) -> WrittenCheck:
    """One check; what is not finite becomes None."""
    remedy = UNSET if check.remedy is None else tuple(map(_part, check.remedy.parts))
    return written_as(WrittenCheck, check, meaning=check.note.worded(as_options), remedy=remedy)


def _part(part: str | Setting) -> str | WrittenSetting:
    """A text or a setting of a remedy."""
    if isinstance(part, str):
        return part
    return written_as(WrittenSetting, part)


def residual_document(tests: ResidualTests) -> WrittenResidualTests:
    """Statistics with the data of their plots; correlations from lag 0, or from ``-lags``.

    Of a handful of rows some statistics do not exist; they become None.
    """
    lags = len(tests.autocorrelation) - 1
    return WrittenResidualTests(
        durbin_watson=finite(tests.durbin_watson),
        autocorrelation=WrittenAutocorrelation(
            values=_finite(tests.autocorrelation), bound_95=finite(tests.bound)
        ),
        normality=WrittenNormality(
            jarque_bera=finite(tests.jarque_bera),
            p_value=finite(tests.jarque_bera_p),
            skewness=finite(tests.skewness),
            excess_kurtosis=finite(tests.excess_kurtosis),
            normal_quantiles=_finite(tests.normal_quantiles),
            residual_quantiles=_finite(tests.residual_quantiles),
        ),
        cross_correlation=WrittenCrossCorrelation(
            largest=finite(tests.cross_z),
            limit_95=finite(tests.cross_limit),
            p_value=finite(tests.cross_p),
            lags=tuple(range(-lags, lags + 1)),
            columns=tuple(map(_finite, tests.cross_correlation.T)),
            deviations=_finite(tests.cross_deviations),
        ),
    )


def _finite(values: Array) -> tuple[float | None, ...]:
    return tuple(map(finite, values.tolist()))
