"""What was measured of a result, read back; what was not finite is NaN or infinite."""

import math
from collections.abc import Sequence

import numpy as np
from msgspec import UNSET

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.diagnostics.estimates import (
    NO_ENDOGENEITY,
    Endogeneity,
    Excitation,
    InstrumentTests,
    Strength,
)
from axisid.estimation.diagnostics.loop import Alignment, LawCheck
from axisid.estimation.moves import Band, LackOfFit
from axisid.estimation.noise import NO_ATTENUATION, Attenuation, NoiseBias
from axisid.estimation.regression import ResidualTests
from axisid.presentation.documents import NOT_EVALUATED
from axisid.presentation.schema import (
    WrittenAlignment,
    WrittenAttenuation,
    WrittenBand,
    WrittenCheck,
    WrittenEndogeneity,
    WrittenExcitation,
    WrittenIdentification,
    WrittenInstruments,
    WrittenLackOfFit,
    WrittenLawCheck,
    WrittenNoiseBias,
    WrittenResidualTests,
    WrittenSetting,
)
from axisid.support.arrays import Array, frozen
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting, as_options


def read_diagnosis(written: WrittenIdentification) -> Diagnosis:
    """The diagnosis of a document."""
    return Diagnosis(
        preferred=written.judged,
        law=_law(written.law_check),
        instruments=_instruments(written.instruments),
        endogeneity=_endogeneity(written.endogeneity),
        excitation=tuple(_excitation(name, e) for name, e in written.excitation.items()),
        alignment=_alignment(written.alignment),
        verdict=tuple(map(_check, written.verdict)),
        lack_of_fit=_lack_of_fit(written.lack_of_fit) if written.lack_of_fit else None,
        bands={
            method: {name: _band(band) for name, band in of_one.items()}
            for method, of_one in (written.model_bands or {}).items()
        },
        noise_biases={
            method: {name: _noise_bias(bias) for name, bias in of_one.items()}
            for method, of_one in (written.noise_bias or {}).items()
        },
        attenuation=_attenuation(written.attenuation) if written.attenuation else NO_ATTENUATION,
    )


def _lack_of_fit(written: WrittenLackOfFit) -> LackOfFit:
    return LackOfFit(
        period=written.period,
        span=written.span,
        times=written.times,
        rows=written.rows,
        share=written.share,
        deviation=written.deviation,
        chance=written.chance,
        repeated=written.repeated,
        noise=written.noise,
        left=written.left,
        smoothness=written.smoothness,
        hac_excess={name: _known(ratio, math.inf) for name, ratio in written.hac_excess.items()},
        time=frozen(written.time),
        mean=frozen(written.mean),
        count=frozen(written.count),
    )


def _band(written: WrittenBand) -> Band:
    return Band(
        deviation=written.deviation,
        interval=written.interval_95,
        groups=written.groups,
        by=written.by,
        exceeds=written.exceeds,
    )


def _noise_bias(written: WrittenNoiseBias) -> NoiseBias:
    return NoiseBias(
        difference=written.difference,
        deviation=written.deviation,
        p_value=_known(written.p_value, math.nan),
        joint_p_value=_known(written.joint_p_value, math.nan),
        shift=written.shift,
    )


def _attenuation(written: WrittenAttenuation) -> Attenuation:
    return Attenuation(
        parameter=written.parameter,
        inverse=written.inverse,
        direct=written.direct,
        r_squared=written.r_squared,
        identity_error=written.identity_error,
        shift=written.shift,
    )


def _check(written: WrittenCheck) -> Check:
    remedy = None if written.remedy is UNSET else Remedy.of(*map(_part, written.remedy))
    said = "" if remedy is None else remedy.worded(as_options)
    return Check(
        name=written.name,
        status=written.status,
        meaning=written.meaning.removesuffix(said),
        remedy=remedy if written.meaning.endswith(said) else None,
        figure=written.figure,
        threshold=written.threshold,
        p_value=written.p_value,
        source=written.source,
    )


def _part(part: str | WrittenSetting) -> str | Setting:
    """A text or a setting of a remedy."""
    return part if isinstance(part, str) else Setting(part.name, part.value, part.given)


def _law(written: WrittenLawCheck) -> LawCheck | Missing:
    if written.passed is None:
        return Missing(written.meaning.removeprefix(NOT_EVALUATED))
    residual, fitted = written.residual_percent, written.fitted_residual_percent
    return LawCheck(
        factors=dict(written.factors or {}),
        residual_percent=None if residual is UNSET else residual,
        fitted_residual_percent=None if fitted is UNSET else fitted,
        delay=written.delay or 0,
        constant=None,  # the verdict's own, which no document has
        passed=written.passed,
        meaning=written.meaning,
    )


def _instruments(written: WrittenInstruments | None) -> InstrumentTests | None:
    if written is None:
        return None
    return InstrumentTests(
        columns=tuple(
            Strength(
                r_squared=_known(c.r_squared),
                shea=_known(c.shea),
                f=_known(c.f, math.inf),
                conditional_f=_known(c.conditional_f, math.inf),
            )
            for c in written.columns
        ),
        condition_number=_known(written.condition_number, math.inf),
    )


def _endogeneity(written: WrittenEndogeneity | None) -> Endogeneity | Missing:
    if written is None:
        return NO_ENDOGENEITY
    return Endogeneity(
        statistic=_known(written.statistic),
        p_value=_known(written.p_value),
        by_parameter=tuple(map(_known, written.p_values.values())),
    )


def _excitation(name: str, written: WrittenExcitation) -> Excitation:
    return Excitation(
        name=name,
        share=written.share,
        inflation=_known(written.inflation, math.inf),
        alike=written.alike,
        lacking=written.lacking,
        rows=_known(written.rows),
        largest_share=_known(written.largest_share),
        natural=_known(written.natural),
    )


def _alignment(written: WrittenAlignment) -> Alignment | Missing:
    if written.best is None:
        return Missing(written.reason or "")
    sensitivity = frozen([*(written.sensitivity or {}).values()])
    delays = frozen(written.delays or ())
    return Alignment(
        delays=delays,
        errors_percent=frozen(written.errors_percent or ()),
        physical=frozen(np.full((len(delays), len(sensitivity)), math.nan)),  # in no document
        best=written.best,
        deviation=_known(written.deviation),
        at_the_end=bool(written.at_the_end),
        by_instruments=bool(written.by_instruments),
        sensitivity=sensitivity,
    )


def read_residual_tests(written: WrittenResidualTests) -> ResidualTests:
    """The tests of the residuals of a document."""
    w, normality, crossed = written, written.normality, written.cross_correlation
    return ResidualTests(
        durbin_watson=_known(w.durbin_watson),
        ljung_box=_known(w.ljung_box.statistic),
        ljung_box_p=_known(w.ljung_box.p_value),
        ljung_box_freedom=w.ljung_box.lags,
        jarque_bera=_known(normality.jarque_bera),
        jarque_bera_p=_known(normality.p_value),
        skewness=_known(normality.skewness),
        excess_kurtosis=_known(normality.excess_kurtosis),
        runs_z=_known(w.runs.z),
        runs_p=_known(w.runs.p_value),
        autocorrelation=_array(w.autocorrelation.values),
        bound=_known(w.autocorrelation.bound_95),
        cross_correlation=frozen(np.array([_array(c) for c in crossed.columns]).T),
        cross_deviations=_array(crossed.deviations),
        cross_z=_known(crossed.largest),
        cross_limit=_known(crossed.limit_95),
        cross_p=_known(crossed.p_value),
        normal_quantiles=_array(normality.normal_quantiles),
        residual_quantiles=_array(normality.residual_quantiles),
        run_lengths=np.array(w.runs.lengths, dtype=np.int64),
    )


def _array(values: Sequence[float | None]) -> Array:
    return frozen([*map(_known, values)])


def _known(value: object, otherwise: float = math.nan) -> float:
    """A figure; of one that was not finite, or not written, what it was most likely."""
    return value if isinstance(value, float) else otherwise
