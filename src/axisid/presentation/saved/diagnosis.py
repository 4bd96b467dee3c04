"""What was measured of a result, read back; what was not finite is NaN or infinite."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import UNSET

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Diagnosis, RecordDiagnosis
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

from .several import read_apart


def read_diagnosis(written: WrittenIdentification) -> Diagnosis:
    """The diagnosis of a document."""
    units = {name: v.unit for name, v in written.estimates[0].parameters.items()}
    return Diagnosis(
        preferred=written.judged,
        law=_law(written.law_check),
        instruments=_instruments(written.instruments),
        endogeneity=_endogeneity(written.endogeneity),
        excitation=tuple(_excitation(name, e) for name, e in written.excitation.items()),
        alignment=_alignment(written.alignment, units),
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
        records=tuple(
            RecordDiagnosis(
                law=_law(member.law_check),
                alignment=_alignment(member.alignment, units),
                lack_of_fit=_lack_of_fit(member.lack_of_fit) if member.lack_of_fit else None,
                verdict=tuple(map(_check, member.verdict)),
                apart=read_apart(member.apart),
            )
            for member in written.records or ()
        ),
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
        hac_excess={name: _number(ratio, math.inf) for name, ratio in written.hac_excess.items()},
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
        p_value=_number(written.p_value, math.nan),
        joint_p_value=_number(written.joint_p_value, math.nan),
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
                r_squared=_number(c.r_squared),
                shea=_number(c.shea),
                f=_number(c.f, math.inf),
                conditional_f=_number(c.conditional_f, math.inf),
            )
            for c in written.columns
        ),
        condition_number=_number(written.condition_number, math.inf),
    )


def _endogeneity(written: WrittenEndogeneity | None) -> Endogeneity | Missing:
    if written is None:
        return NO_ENDOGENEITY
    return Endogeneity(
        statistic=_number(written.statistic),
        p_value=_number(written.p_value),
        by_parameter=tuple(map(_number, written.p_values.values())),
    )


def _excitation(name: str, written: WrittenExcitation) -> Excitation:
    return Excitation(
        name=name,
        share=written.share,
        inflation=_number(written.inflation, math.inf),
        alike=written.alike,
        lacking=written.lacking,
        rows=_number(written.rows),
        largest_share=_number(written.largest_share),
        natural=_number(written.natural),
    )


def _alignment(written: WrittenAlignment, units: Mapping[str, str]) -> Alignment | Missing:
    if written.best is None:
        return Missing(written.reason or "")
    sensitivity = frozen([*(written.sensitivity or {}).values()])
    delays = frozen(written.delays or ())
    return Alignment(
        delays=delays,
        errors_percent=frozen(written.errors_percent or ()),
        physical=frozen(np.full((len(delays), len(sensitivity)), math.nan)),  # in no document
        best=written.best,
        deviation=_number(written.deviation),
        at_the_end=bool(written.at_the_end),
        by_instruments=bool(written.by_instruments),
        sensitivity=sensitivity,
        names=tuple(written.sensitivity or {}),
        units=tuple(units.get(name, "") for name in written.sensitivity or {}),
    )


def read_residual_tests(written: WrittenResidualTests) -> ResidualTests:
    """The tests of the residuals of a document."""
    w, normality, crossed = written, written.normality, written.cross_correlation
    return ResidualTests(
        durbin_watson=_number(w.durbin_watson),
        ljung_box=_number(w.ljung_box.statistic),
        ljung_box_p=_number(w.ljung_box.p_value),
        ljung_box_freedom=w.ljung_box.lags,
        jarque_bera=_number(normality.jarque_bera),
        jarque_bera_p=_number(normality.p_value),
        skewness=_number(normality.skewness),
        excess_kurtosis=_number(normality.excess_kurtosis),
        runs_z=_number(w.runs.z),
        runs_p=_number(w.runs.p_value),
        autocorrelation=_array(w.autocorrelation.values),
        bound=_number(w.autocorrelation.bound_95),
        cross_correlation=frozen(np.array([_array(c) for c in crossed.columns]).T),
        cross_deviations=_array(crossed.deviations),
        cross_z=_number(crossed.largest),
        cross_limit=_number(crossed.limit_95),
        cross_p=_number(crossed.p_value),
        normal_quantiles=_array(normality.normal_quantiles),
        residual_quantiles=_array(normality.residual_quantiles),
        run_lengths=np.array(w.runs.lengths, dtype=np.int64),
    )


def _array(values: Sequence[float | None]) -> Array:
    return frozen([*map(_number, values)])


def _number(value: object, otherwise: float = math.nan) -> float:
    """A figure; of one that was not finite, or not written, what it was most likely."""
    return value if isinstance(value, float) else otherwise
