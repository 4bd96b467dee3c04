"""Functions of the parameters: values, units, uncertainty, and what cannot be read."""

import warnings
from functools import cache

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

from axisid import EstimationError, Parameter, UsageError, build, identify, load_axis, twin_record
from axisid.estimation.estimates.estimate import Estimate
from tests.refusals import refuses


@cache
def fitted() -> Estimate:
    axis = build(load_axis("emps2015"))
    return identify(axis, twin_record(axis))["idm-ls"]


@pytest.fixture(scope="module")
def estimate() -> Estimate:
    return fitted()


def test_time_constant_is_the_closed_form(estimate: Estimate) -> None:
    M, Fv = estimate.physical[:2]
    tau = estimate.derive("M/Fv")
    assert tau.unit == "s"
    assert tau.value == pytest.approx(M / Fv, rel=1e-14)
    for name, sd in (("iid", tau.sd), ("robust", tau.sd_robust), ("hac", tau.sd_hac)):
        C = estimate.covariances[name]
        variance = (C[0, 0] - 2 * tau.value * C[0, 1] + tau.value**2 * C[1, 1]) / Fv**2
        assert sd == pytest.approx(np.sqrt(variance), rel=1e-10)


def test_text_sympy_and_declared_parameters_are_the_same(estimate: Estimate) -> None:
    M, Fv = Parameter("M", "kg"), Parameter("Fv", "N/(m/s)")
    assert estimate.derive("M/Fv") == estimate.derive(M / Fv)
    assert estimate.derive("M/Fv") == estimate.derive(sympy.Symbol("M") / sympy.Symbol("Fv"))
    assert estimate.derive("M") == estimate.derive(M)


@pytest.mark.parametrize(
    ("function", "unit"),
    [
        ("2*M", "kg"),
        ("M + 3*M", "kg"),
        ("1/Fc", "s^2/(kg m)"),
        ("abs(-Fc) + Fc", "N"),
        ("log(M/M**1.5*M**0.5) + exp(Fc/(2*Fc))", "1"),
        ("pi*M/Fv**2*Fc", "m"),
        ("(M*Fc)**0.5/Fc**0.5/M**0.5", "1"),
    ],
)
def test_units_follow_the_arithmetic(estimate: Estimate, function: str, unit: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert estimate.derive(function).unit == unit


@pytest.mark.parametrize(
    ("function", "code", "says"),
    [
        ("M + Fv", "formula", "adds .* and .*; units must agree"),
        ("M + 1", "formula", "units must agree"),
        ("exp(M)", "formula", "takes a number, not kg"),
        ("2**M", "formula", "the power in 2.*M is in kg"),
        ("M**(Fc/Fc*2 + M/M - 1)*N", "formula", "N; there are M, Fv, Fc"),
        ("__import__('os').system('true')", "formula", ""),
        ("M.real", "formula", ""),
        ("M^2", "formula", ""),
        ("[M for M in Fv]", "formula", ""),
        ("", "formula", ""),
        ("M**21", "formula", "20"),
        ("M*sin(exp(exp(15)))", "formula", ""),
        ("M**sqrt(-1)", "formula", ""),
        ("sin(" * 80 + "M/M" + ")" * 80, "formula", ""),
        ("M**1.001", "formula", "no fraction"),
        ("Fc**pi", "formula", "no fraction"),
        ("M**1.001 + M", "formula", "no fraction"),
        ("M" * 501, "formula", "501 characters"),
        ("\0", "formula", ""),
    ],
)
def test_what_cannot_be_read_is_explained(
    estimate: Estimate, function: str, code: str, says: str
) -> None:
    with refuses(code, says):
        estimate.derive(function)


def test_absolute_values_have_derivatives(estimate: Estimate) -> None:
    """SymPy's own leaves these unevaluated."""
    for inner in ("-M", "sqrt(Fc)", "-(M/Fv)**1.5"):
        plain, absolute = estimate.derive(inner), estimate.derive(f"abs({inner})")
        assert absolute.value == abs(plain.value)
        assert absolute.unit == plain.unit
        assert absolute.sd_hac == pytest.approx(plain.sd_hac, rel=1e-12)
    M, Fv = sympy.Symbol("M"), sympy.Symbol("Fv")
    assert estimate.derive(sympy.Abs(-M / Fv)) == estimate.derive("M/Fv")


def test_sympy_that_is_not_arithmetic_is_refused(estimate: Estimate) -> None:
    M, i = sympy.Symbol("M"), sympy.Symbol("i")
    for function in (sympy.Integral(M, (M, 0, 1)), sympy.Sum(i * M, (i, 1, 3)), sympy.Heaviside(M)):
        with refuses("formula"):
            estimate.derive(function)


def test_covariance_that_is_not_a_number_stays_so(estimate: Estimate) -> None:
    lost = estimate.with_inference(
        covariances={name: np.nan * c for name, c in estimate.covariances.items()}
    )
    value = lost.derive("3*M")
    assert np.isnan([value.sd, value.sd_robust, value.sd_hac, *value.interval]).all()


def test_function_without_a_value_is_refused(estimate: Estimate) -> None:
    for function in ("log(-M/M)", "1/(M - M)", "sqrt(-M/Fv)", "log(0*M/M)"):
        with pytest.raises((EstimationError, UsageError)):
            estimate.derive(function)


@pytest.mark.slow
@given(st.text(alphabet="MFvc+-*/()., 0129esqrtabpi_[]'\"", max_size=30))
def test_any_text_gives_a_value_or_a_sentence(text: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            fitted().derive(text)
        except (UsageError, EstimationError) as error:
            assert str(error).endswith((".", ")")) or "cannot be read" in str(error)


def test_function_that_bends_within_the_uncertainty_warns(estimate: Estimate) -> None:
    loose = estimate.with_inference(
        covariances={name: 1e6 * c for name, c in estimate.covariances.items()}
    )
    with pytest.warns(RuntimeWarning, match="second-order part"):
        loose.derive("1/Fv")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        loose.derive("3*Fv")
        estimate.derive("1/Fv")
