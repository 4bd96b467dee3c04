"""Curvature of the parameter map and draws through it, against closed forms."""

import numpy as np
import pytest

from axisid import Identification, Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.estimates.estimate import Estimate
from tests.refusals import refuses


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


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
    with pytest.warns(RuntimeWarning, match=r"draw instead: propagate\(\)"):
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
