"""The diagnosis as plain numbers, texts and lists."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from axisid.estimation.diagnostics import (
    Alignment,
    Diagnosis,
    Endogeneity,
    Excitation,
    InstrumentTests,
    LawCheck,
)
from axisid.estimation.regression import ResidualTests
from axisid.support.arrays import finite, finite_tree


def diagnosis_dict(diagnosis: Diagnosis, names: Sequence[str]) -> dict[str, Any]:
    """Everything that was measured of a result, then the checks.

    Parameters
    ----------
    diagnosis : Diagnosis
    names : sequence of str
        Of the physical parameters.
    """
    return {
        "judged": diagnosis.judged,
        "law_check": _law_check(diagnosis.law),
        "instruments": _instruments(diagnosis.instruments),
        "endogeneity": _endogeneity(diagnosis.endogeneity, names),
        "excitation": {e.name: _excitation(e) for e in diagnosis.excitation},
        "alignment": _alignment(diagnosis.alignment, names),
        "verdict": [finite_tree(asdict(check)) for check in diagnosis.verdict],
    }


def _law_check(check: LawCheck | str) -> dict[str, Any]:
    """The control law's check; `passed` is null where it could not be made."""
    if isinstance(check, str):
        return {"passed": None, "meaning": f"not evaluated: {check}"}
    return {
        "passed": check.passed,
        "factors": dict(check.factors),
        "residual_percent": check.residual_percent,
        "fitted_residual_percent": check.fitted_residual_percent,
        "delay": check.delay,
        "meaning": check.meaning,
    }


def _instruments(tests: InstrumentTests | None) -> dict[str, Any] | None:
    if tests is None:
        return None
    return {
        "columns": [{k: finite(v) for k, v in asdict(c).items()} for c in tests.columns],
        "condition_number": finite(tests.condition_number),
    }


def _endogeneity(test: Endogeneity | None, names: Sequence[str]) -> dict[str, Any] | None:
    if test is None:
        return None
    return {
        "statistic": finite(test.statistic),
        "p_value": finite(test.p_value),
        "p_values": dict(zip(names, map(finite, test.by_parameter), strict=True)),
    }


def _alignment(profile: Alignment | str, names: Sequence[str]) -> dict[str, Any]:
    if isinstance(profile, str):
        return {"best": None, "reason": profile}
    return {
        "best": profile.best,
        "deviation": finite(profile.deviation),
        "at_the_end": profile.at_the_end,
        "by_instruments": profile.by_instruments,
        "sensitivity": dict(zip(names, profile.sensitivity.tolist(), strict=True)),
        "delays": profile.delays.tolist(),
        "errors_percent": profile.errors_percent.tolist(),
    }


def _excitation(shown: Excitation) -> dict[str, Any]:
    """What the motion shows of one parameter."""
    return {
        "share": shown.share,
        "inflation": finite(shown.inflation),
        "alike": list(shown.alike),
        "lacking": list(shown.lacking),
        "rows": shown.rows,
        "largest_share": finite(shown.largest_share),
        "natural": finite(shown.natural),
    }


def residual_dict(tests: ResidualTests) -> dict[str, Any]:
    """Statistics with the data of their plots; correlations from lag 0, or from ``-lags``."""
    lags = len(tests.autocorrelation) - 1
    document = {
        "durbin_watson": tests.durbin_watson,
        "ljung_box": {"statistic": tests.ljung_box, "p_value": tests.ljung_box_p, "lags": lags},
        "autocorrelation": {"values": tests.autocorrelation.tolist(), "bound_95": tests.bound},
        "normality": {
            "jarque_bera": tests.jarque_bera,
            "p_value": tests.jarque_bera_p,
            "skewness": tests.skewness,
            "excess_kurtosis": tests.excess_kurtosis,
            "normal_quantiles": tests.normal_quantiles.tolist(),
            "residual_quantiles": tests.residual_quantiles.tolist(),
        },
        "cross_correlation": {
            "largest": tests.cross_z,
            "limit_95": tests.cross_limit,
            "p_value": tests.cross_p,
            "lags": list(range(-lags, lags + 1)),
            "columns": tests.cross_correlation.T.tolist(),
            "deviations": tests.cross_deviations.tolist(),
        },
        "runs": {
            "z": finite(tests.runs_z),
            "p_value": tests.runs_p,
            "lengths": tests.run_lengths.tolist(),
        },
    }
    # Of a handful of rows some statistics do not exist.
    return dict(finite_tree(document))
