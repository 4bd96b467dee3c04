"""The diagnosis as a document."""

from collections.abc import Sequence
from typing import Any

import msgspec
from msgspec import UNSET, UnsetType

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.diagnostics.estimates import Endogeneity, Excitation, InstrumentTests
from axisid.estimation.diagnostics.loop import Alignment, LawCheck
from axisid.estimation.moves import Band, LackOfFit
from axisid.estimation.noise import Attenuation, NoiseBias
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
    WrittenLjungBox,
    WrittenNoiseBias,
    WrittenNormality,
    WrittenResidualTests,
    WrittenRuns,
    WrittenSetting,
    WrittenStrength,
)
from axisid.support.arrays import Array, finite, finite_tree
from axisid.support.missing import Missing
from axisid.support.remedy import Setting, as_options

#: How the meaning of a law's check begins that could not be made.
NOT_EVALUATED = "not evaluated: "


def diagnosis_dict(diagnosis: Diagnosis) -> dict[str, Any]:
    """Everything that was measured of a result, as plain numbers, texts and lists."""
    members = diagnosis_members(diagnosis, [each.name for each in diagnosis.excitation])
    return dict(finite_tree(msgspec.to_builtins(members, enc_hook=lambda value: value.item())))


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
        "law_check": law_document(diagnosis.law),
        "instruments": _instruments(diagnosis.instruments),
        "endogeneity": _endogeneity(diagnosis.endogeneity, names),
        "excitation": {e.name: _excitation(e) for e in diagnosis.excitation},
        "alignment": alignment_document(diagnosis.alignment, names),
        "verdict": tuple(map(check_document, diagnosis.verdict)),
        "lack_of_fit": UNSET
        if diagnosis.lack_of_fit is None
        else lack_of_fit_document(diagnosis.lack_of_fit),
        "model_bands": {
            method: {name: _band(band) for name, band in of_one.items()}
            for method, of_one in diagnosis.bands.items()
            if of_one
        }
        or UNSET,
        "noise_bias": {
            method: {name: noise_bias_document(bias) for name, bias in of_one.items()}
            for method, of_one in diagnosis.noise_biases.items()
        }
        or UNSET,
        "attenuation": _attenuation(diagnosis.attenuation),
    }


def law_document(check: LawCheck | Missing) -> WrittenLawCheck:
    """The control law's check; `passed` is None where it could not be made."""
    if isinstance(check, Missing):
        return WrittenLawCheck(
            passed=None, meaning=f"{NOT_EVALUATED}{check.note.worded(as_options)}"
        )
    return WrittenLawCheck(
        passed=check.passed,
        factors=dict(check.factors),
        residual_percent=check.residual_percent,
        fitted_residual_percent=check.fitted_residual_percent,
        delay=check.delay,
        meaning=check.note.worded(as_options),
    )


def _instruments(tests: InstrumentTests | None) -> WrittenInstruments | None:
    if tests is None:
        return None
    return WrittenInstruments(
        columns=tuple(
            WrittenStrength(
                r_squared=finite(c.r_squared),
                shea=finite(c.shea),
                f=finite(c.f),
                conditional_f=finite(c.conditional_f),
            )
            for c in tests.columns
        ),
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


def alignment_document(profile: Alignment | Missing, names: Sequence[str]) -> WrittenAlignment:
    """The delay of the force; `names` are of the parameters where it has none of its own."""
    if isinstance(profile, Missing):
        return WrittenAlignment(best=None, reason=profile.note.worded(as_options))
    return WrittenAlignment(
        best=profile.best,
        deviation=finite(profile.deviation),
        at_the_end=profile.at_the_end,
        by_instruments=profile.by_instruments,
        sensitivity=dict(zip(profile.names or names, profile.sensitivity.tolist(), strict=True)),
        delays=tuple(profile.delays.tolist()),
        errors_percent=tuple(profile.errors_percent.tolist()),
    )


def lack_of_fit_document(found: LackOfFit) -> WrittenLackOfFit:
    """What is left at phases of the reference that repeat."""
    return WrittenLackOfFit(
        period=found.period,
        span=found.span,
        times=found.times,
        rows=found.rows,
        share=found.share,
        deviation=found.deviation,
        chance=found.chance,
        repeated=found.repeated,
        noise=found.noise,
        left=found.left,
        smoothness=found.smoothness,
        hac_excess={name: finite(ratio) for name, ratio in found.hac_excess.items()},
        time=tuple(found.time.tolist()),
        mean=tuple(found.mean.tolist()),
        count=tuple(found.count.tolist()),
    )


def _band(band: Band) -> WrittenBand:
    return WrittenBand(
        deviation=band.deviation,
        interval_95=band.interval,
        groups=band.groups,
        by=band.by,
        exceeds=band.exceeds,
    )


def noise_bias_document(bias: NoiseBias) -> WrittenNoiseBias:
    """What noise does to a parameter of least squares."""
    return WrittenNoiseBias(
        difference=bias.difference,
        deviation=bias.deviation,
        p_value=finite(bias.p_value),
        joint_p_value=finite(bias.joint_p_value),
        shift=bias.shift,
        misses=bias.misses,
    )


def _attenuation(found: Attenuation | Missing) -> WrittenAttenuation | UnsetType:
    if isinstance(found, Missing):
        return UNSET
    return WrittenAttenuation(
        parameter=found.parameter,
        inverse=found.inverse,
        direct=found.direct,
        r_squared=found.r_squared,
        identity_error=found.identity_error,
        shift=found.shift,
    )


def _excitation(shown: Excitation) -> WrittenExcitation:
    return WrittenExcitation(
        share=shown.share,
        inflation=finite(shown.inflation),
        alike=shown.alike,
        lacking=shown.lacking,
        rows=shown.rows,
        largest_share=finite(shown.largest_share),
        natural=finite(shown.natural),
    )


def check_document(check: Check) -> WrittenCheck:
    """One check; what is not finite becomes None."""
    return WrittenCheck(
        name=check.name,
        status=check.status,
        meaning=check.note.worded(as_options),
        figure=finite_tree(check.figure),
        threshold=finite_tree(check.threshold),
        p_value=finite_tree(check.p_value),
        source=check.source,
        remedy=UNSET if check.remedy is None else tuple(map(_part, check.remedy.parts)),
    )


def _part(part: str | Setting) -> str | WrittenSetting:
    """A text or a setting of a remedy."""
    if isinstance(part, str):
        return part
    return WrittenSetting(name=part.name, value=part.value, given=part.given)


def residual_document(tests: ResidualTests) -> WrittenResidualTests:
    """Statistics with the data of their plots; correlations from lag 0, or from ``-lags``.

    Of a handful of rows some statistics do not exist; they become None.
    """
    lags = len(tests.autocorrelation) - 1
    return WrittenResidualTests(
        durbin_watson=finite(tests.durbin_watson),
        ljung_box=WrittenLjungBox(
            statistic=finite(tests.ljung_box),
            p_value=finite(tests.ljung_box_p),
            lags=tests.ljung_box_freedom,
        ),
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
        runs=WrittenRuns(
            z=finite(tests.runs_z),
            p_value=finite(tests.runs_p),
            lengths=tuple(tests.run_lengths.tolist()),
        ),
    )


def _finite(values: Array) -> tuple[float | None, ...]:
    return tuple(map(finite, values.tolist()))
