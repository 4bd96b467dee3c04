"""Parameters that enter nonlinearly: the linearised regressor, the search, and instruments."""

import re
from dataclasses import replace

import numpy as np
import pytest
import sympy
from scipy.optimize import least_squares as scipy_least_squares

from axisid import (
    Axis,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    compare,
    sweep,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import Drive
from axisid.estimation.methods import filtered_record
from axisid.estimation.regression.inverse_and_direct import InverseForm
from axisid.estimation.regression.simulated_instruments import simulated_loops, simulated_rows
from axisid.modeling import Experiment, back_and_forth
from tests.axes.bodies import b, c, m, stage, x
from tests.refusals import refuses
from tests.unjudged import identify

s = Parameter("s", "N")
v = Parameter("v", "m/s", nominal=0.05, lower=1e-4)
d = Parameter("d", "1", nominal=1.0, lower=0.2, upper=4.0)
TRUTH = {"m": 6.2, "b": 14.0, "c": 7.5, "s": 4.0, "v": 0.1}
FILTER = Prefilter(cutoff=100.0)


def stribeck_axis(*further: Parameter, exponent: sympy.Expr | int = 2) -> Axis:
    dq = x.velocity
    return stage(
        s * sympy.exp(-((sympy.Abs(dq) / v) ** exponent)) * sympy.sign(dq),
        parameters=(s, v, *further),
        drive=Drive(gain=18.0, unit="A", relative_sd=0.01),
        experiment=Experiment(
            moves=back_and_forth(
                speeds=(0.05, 0.1, 0.2, 0.4), acceleration=3.0, seconds=0.5, repeat=2
            ),
            truth=TRUTH,
            position_noise=1e-6,
        ),
    )


@pytest.fixture(scope="module")
def axis() -> GeneratedAxis:
    return build(stribeck_axis())


@pytest.fixture(scope="module")
def record(axis: GeneratedAxis) -> Record:
    return twin_record(axis)


@pytest.fixture(scope="module")
def result(axis: GeneratedAxis, record: Record) -> Identification:
    return identify(axis, record, FILTER)


def test_columns_are_the_slopes_of_the_inverse_dynamics(rng: np.random.Generator) -> None:
    axis = build(stribeck_axis(d, exponent=d.symbol))
    motion = (*rng.normal(size=(3, 40)), np.sign(rng.normal(size=40)))
    motion = (motion[0], np.abs(motion[1]) * motion[3], motion[2], motion[3])
    theta = np.array([6.2, 14.0, 7.5, 4.0, 0.6, 1.5])
    row, known = axis.evaluate("idm_regressor", *motion, theta)
    (force,) = axis.evaluate("inverse_dynamics", *motion, theta)
    assert row @ theta + known[:, 0] == pytest.approx(force[:, 0])
    for j in range(6):
        step = 1e-6 * theta[j] * (np.arange(6) == j)
        ahead, behind = (
            axis.evaluate("inverse_dynamics", *motion, theta + way)[0][:, 0]
            for way in (step, -step)
        )
        assert row[:, j] == pytest.approx((ahead - behind) / (2 * step[j]), abs=1e-6)
    # x**p log(x) is 0 at 0; as floating-point numbers it would be 0 times minus infinity.
    row, known = axis.evaluate("idm_regressor", [0.0], [0.0], [1.0], [0.5], theta)
    assert np.isfinite([*row[0], *known[0]]).all()
    assert row[0, 4:] == pytest.approx([0.0, 0.0])


@pytest.mark.slow
def test_search_finds_what_a_full_search_over_all_parameters_finds(
    axis: GeneratedAxis, record: Record, result: Identification
) -> None:
    """SciPy's, from the truth, on the inverse dynamics and not on the regressor."""
    estimate = result["idm-ls"]
    data = filtered_record(axis, record, FILTER)
    s_, y = data.signals, data.reduce(data.signals.force)

    def residuals(theta: np.ndarray) -> np.ndarray:
        (force,) = axis.evaluate(
            "inverse_dynamics", s_.position, s_.velocity, s_.acceleration, s_.direction, theta
        )
        return y - data.reduce(force[:, 0])

    start = np.array(list(TRUTH.values()))
    found = scipy_least_squares(residuals, start, x_scale=start, xtol=1e-14, ftol=1e-14)
    assert estimate.physical == pytest.approx(found.x, rel=1e-5)
    assert estimate.residuals == pytest.approx(residuals(estimate.physical), abs=1e-6)
    variance = float(found.fun @ found.fun) / (len(y) - 1)
    covariance = variance * np.linalg.inv(found.jac.T @ found.jac)
    assert np.diag(estimate.covariances["iid"]) == pytest.approx(np.diag(covariance), rel=1e-3)


@pytest.mark.slow
def test_instruments_solve_their_nonlinear_equations(
    axis: GeneratedAxis, record: Record, result: Identification
) -> None:
    iv = result["idm-iv"]
    data = filtered_record(axis, record, FILTER)
    reduced = InverseForm(axis).at(iv.physical).equations(data.signals).reduced(data)
    residuals = reduced.left - reduced.intercept - reduced.regressor @ iv.physical
    seen = iv.Z.T @ residuals / np.linalg.norm(iv.Z, axis=0) / np.linalg.norm(residuals)
    assert np.abs(seen).max() < 1e-2


@pytest.mark.slow
def test_direct_model_is_refused_with_the_reason(result: Identification) -> None:
    for method in ("ddm-ls", "ddm-iv"):
        assert "not linear in v." in result.skipped[method]


@pytest.mark.slow
def test_gain_scales_forces_and_not_velocities(result: Identification) -> None:
    parameters = result["idm-ls"].parameters
    assert parameters["s"].sd_gain == pytest.approx(0.01 * parameters["s"].value, rel=1e-6)
    assert parameters["v"].sd_gain == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_everything_else_takes_such_an_axis(
    axis: GeneratedAxis, record: Record, result: Identification
) -> None:
    ls, iv, *_ = validate(result, twin_record(axis, seed=5))
    assert iv.equation_error_percent == pytest.approx(ls.equation_error_percent, rel=0.1)
    assert "v" in result.summary()
    assert result.to_dict()["excitation"]["v"]["share"] > 0
    assert len(sweep(axis, record, (60.0, 100.0), methods=["idm-ls"]).results) == 2


def test_search_needs_a_start(record: Record) -> None:
    blind = replace(stribeck_axis(), parameters=(m, b, c, s, Parameter("v", "m/s")))
    with refuses("no-convergence", says="not linear in v, so the search needs a start"):
        identify(blind, record, FILTER, "idm-ls")


def bounded(lower: float, upper: float, nominal: float) -> GeneratedAxis:
    v_bounded = Parameter("v", "m/s", nominal=nominal, lower=lower, upper=upper)
    return build(replace(stribeck_axis(), parameters=(m, b, c, s, v_bounded)))


@pytest.mark.slow
def test_instruments_that_lead_beyond_a_bound_are_refused_with_its_name(record: Record) -> None:
    """Least squares ends at the bound; that is not where the instruments' equations hold."""
    axis = bounded(1e-4, 0.09, nominal=0.05)
    result = identify(axis, record, FILTER)
    assert result["idm-ls"].parameters["v"].value == pytest.approx(0.09)
    found = re.search(r"v = (\S+) m/s.*bound 0.09", result.failed["idm-iv"])
    assert found
    assert float(found[1]) == pytest.approx(0.0995, abs=1e-4)
    with refuses("bounds"):
        identify(axis, record, FILTER, "idm-iv")


@pytest.mark.slow
def test_damped_iterates_show_the_error_of_their_own_loop(
    axis: GeneratedAxis, record: Record
) -> None:
    """The first whole step is beyond the lower bound, the solution is not."""
    kept = replace(FILTER, reversals="keep")
    narrow = bounded(0.099, np.inf, nominal=0.1)
    damped = identify(narrow, record, kept, "idm-iv")["idm-iv"]
    free = identify(axis, record, kept, "idm-iv")["idm-iv"]
    assert damped.iterates[1].physical[4] > free.iterates[1].physical[4] + 1e-3
    assert damped.physical == pytest.approx(free.physical, rel=1e-4)
    data = filtered_record(axis, record, kept)
    for iterate in damped.iterates:
        loops = simulated_loops(axis, record, iterate.physical)
        rows = simulated_rows(InverseForm(axis), loops, iterate.physical, data)
        left = damped.y - rows.intercept - rows.regressor @ iterate.physical
        own = 100 * np.linalg.norm(left) / np.linalg.norm(damped.y)
        assert iterate.theta == pytest.approx(iterate.physical, rel=1e-12)
        assert iterate.simulation_error_percent == pytest.approx(own, rel=1e-9)


@pytest.mark.slow
def test_no_p_value_where_only_the_larger_model_has_a_velocity(
    axis: GeneratedAxis, record: Record
) -> None:
    """Without an excess its velocity means nothing, so that no statistic is F distributed."""
    plain = stage(name="plain", drive=axis.axis.drive)
    compared = compare({"plain": build(plain), "Stribeck": axis}, record, FILTER)
    (test,) = compared.tests
    assert (test.smaller, test.larger, test.restrictions) == ("plain", "Stribeck", 2)
    assert test.wald_p is None
    text = " ".join(compared.summary().split())
    assert "plain in Stribeck is not tested: " in text
    assert compared.recommended == "Stribeck"
