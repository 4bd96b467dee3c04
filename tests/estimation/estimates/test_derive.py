"""Functions of the parameters: values, units, uncertainty, and what cannot be read."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

from axisid import (
    EstimationError,
    Identification,
    Parameter,
    Record,
    UsageError,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.estimates.estimate import Estimate
from tests.refusals import refuses
from tests.unjudged import identify

_M, _I = sympy.symbols("M i")


@pytest.fixture(scope="module")
def estimate(result: Identification) -> Estimate:
    return result["idm-ls"]


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
        ("atan2(M, 2*M) + tanh(M/M)", "1"),
        ("max(Fv, -Fv)", "N/(m/s)"),
    ],
)
def test_units_follow_the_arithmetic(estimate: Estimate, function: str, unit: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert estimate.derive(function).unit == unit


@pytest.mark.parametrize(
    ("function", "code", "says"),
    [
        ("M + Fv", "formula", "adds .* and .*unit"),
        ("M + 1", "formula", "adds kg and 1"),
        ("exp(M)", "formula", "takes a number, not kg"),
        ("2**M", "formula", "the power in 2.*M is in kg"),
        ("M**(Fc/Fc*2 + M/M - 1)*N", "formula", "N is not known.*M, Fv, Fc"),
        ("__import__('os').system('true')", "formula", ""),
        ("M.real", "formula", ""),
        ("M^2", "formula", ""),
        ("[M for M in Fv]", "formula", ""),
        ("", "formula", ""),
        ("M**21", "formula", "20"),
        ("M*sin(exp(exp(15)))", "formula", ""),
        ("M**sqrt(-1)", "formula", ""),
        ("sin(" * 80 + "M/M" + ")" * 80, "formula", ""),
        ("M**1.001", "formula", "denominator"),
        ("Fc**pi", "formula", "denominator"),
        ("M**1.001 + M", "formula", "denominator"),
        ("M" * 2001, "formula", "2001 characters"),
        ("\0", "formula", ""),
        (sympy.Integral(_M, (_M, 0, 1)), "formula", ""),
        (sympy.Sum(_I * _M, (_I, 1, 3)), "formula", ""),
        (sympy.Heaviside(_M), "formula", ""),
    ],
)
def test_what_cannot_be_read_is_explained(
    estimate: Estimate, function: str | sympy.Expr, code: str, says: str
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
@given(text=st.text(alphabet="MFvc+-*/()., 0129esqrtabpi_[]'\"", max_size=30))
def test_any_text_gives_a_value_or_a_sentence(estimate: Estimate, text: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            estimate.derive(text)
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


def widened(estimate: Estimate, factor: float) -> Estimate:
    """The same estimate with deviations that many times as large."""
    return estimate.with_inference(
        ddm_covariances={n: factor**2 * c for n, c in estimate.ddm_covariances.items()},
        covariances={n: factor**2 * c for n, c in estimate.covariances.items()},
    )


def test_curvature_of_the_inertia_is_the_closed_form(result: Identification) -> None:
    """M = 1/theta1: first M^2 s, second sqrt(1/2) 2 M^3 s^2, their ratio sqrt(2) s/theta1."""
    direct = result["ddm-iv"]
    for factor in (1.0, 30.0):
        estimate = widened(direct, factor)
        s = np.sqrt(estimate.ddm_covariances["hac"][0, 0])
        expected = np.sqrt(2) * s / estimate.theta_ddm[0]
        assert estimate.curvatures[0] == pytest.approx(expected, rel=2e-3)


def test_curvature_of_a_function_is_that_of_the_whole_chain(result: Identification) -> None:
    """Fv/M is theta2 itself: straight in the direct model's parameters, a quotient in ours."""
    wide = widened(result["ddm-iv"], 200.0)
    wide.derive("Fv/M")  # no warning, which the suite would turn into an error
    with pytest.warns(RuntimeWarning, match=r"propagate\(\)"):
        wide.derive("M")


@pytest.mark.slow
def test_draws_of_the_inertia_have_the_quantiles_of_a_reciprocal(result: Identification) -> None:
    wide = widened(result["ddm-iv"], 50.0)
    drawn = wide.propagate("M", draws=100_000)
    theta, s = wide.theta_ddm[0], np.sqrt(wide.ddm_covariances["hac"][0, 0])
    expected = 1 / (theta + 1.9623 * s * np.array([1, -1]))  # Student, 900 degrees of freedom
    assert drawn.interval == pytest.approx(expected.tolist(), rel=5e-3)
    assert drawn.value == pytest.approx(wide.physical[0])
    assert drawn.unit == "kg"
    assert drawn.lost == 0


def test_draws_need_no_control_law(emps2015: GeneratedAxis, twin: Record) -> None:
    found = identify(replace(emps2015.axis, control=None), twin, methods="ddm-ls")
    assert found["ddm-ls"].propagate("M", draws=50).lost == 0


@pytest.mark.slow
def test_draws_without_inertia_are_counted_and_left_out(result: Identification) -> None:
    hopeless = widened(result["ddm-iv"], 1600.0)
    drawn = hopeless.propagate("M", draws=4000)
    assert drawn.lost > 100
    assert drawn.draws + drawn.lost == 4000
    assert drawn.interval[0] > 0
    assert drawn == hopeless.propagate("M", draws=4000)
    assert drawn != hopeless.propagate("M", draws=4000, seed=1)
    assert widened(result["idm-iv"], 100.0).propagate("sqrt(Fv)", draws=2000).lost > 0
    lost = widened(hopeless, np.nan).propagate("M", draws=20)
    assert lost.lost == 20
    assert np.isnan(lost.median)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"draws": 0}, "result"),
        ({"draws": 1.5}, "result"),
        ({"covariance": "white"}, "result"),
        ({"function": "M + Fv"}, "formula"),
        ({"function": "mass"}, "formula"),
    ],
)
def test_misuse_is_explained(
    result: Identification, arguments: dict[str, object], code: str
) -> None:
    with refuses(code):
        result["ddm-ls"].propagate(**{"function": "M", **arguments})  # type: ignore[arg-type]
