"""Physical parameters by minimum distance: closed forms, another optimiser, coverage, words."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.optimize import least_squares

from axisid import (
    Axis,
    Constant,
    Parameter,
    Prefilter,
    Record,
    build,
    fix,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import MEASURED_POSITION, PERIOD, REFERENCE, ControlLaw, Memory, gain
from axisid.elements import Drive
from axisid.estimation.diagnostics import fixed_check
from axisid.estimation.diagnostics.parameter_findings import FixedValues
from axisid.estimation.estimates.estimate import Estimate
from axisid.estimation.estimates.physical_parameters import (
    Distance,
    Physical,
    mapped,
    physical_parameters,
)
from axisid.modeling import Experiment, back_and_forth
from axisid.modeling.derivation.base_model import base_model
from axisid.support.missing import Missing
from tests.axes import bodies
from tests.axes.bodies import ROD, b, body, rod, turn, x
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import finding_of

m, l, J = ROD  # noqa: E741
fv = Parameter("fv", "N m/(rad/s)")
TRUTH = {"m": 1.2, "l": 0.45, "J": 0.03, "fv": 0.4}
FILTER = Prefilter(cutoff=60.0, decimate=10)

last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)
PENDULUM = rod(
    (fv,),
    name="pendulum",
    dissipation=fv * turn.velocity**2 / 2,
    drive=Drive(gain=0.5, unit="A"),
    control=ControlLaw(
        name="PD on encoder differences",
        period=1e-3,
        gains={"p": 40.0, "d": 4.0},
        output=gain("p") * (REFERENCE - MEASURED_POSITION)
        - gain("d") * (MEASURED_POSITION - last.symbol) / PERIOD,
        memory=(last,),
    ),
    experiment=Experiment(
        moves=back_and_forth(speeds=(1.0, 3.0), acceleration=40.0, seconds=0.5),
        truth=TRUTH,
        position_noise=2e-5,
    ),
)


@pytest.fixture(scope="module")
def pendulum() -> GeneratedAxis:
    return build(PENDULUM)


@pytest.fixture(scope="module")
def record(pendulum: GeneratedAxis) -> Record:
    return twin_record(pendulum)


def knowing(axis: GeneratedAxis, declared: Axis) -> GeneratedAxis:
    """The same generated code with other known values."""
    base = base_model(declared)
    assert base.axis.force == axis.axis.force
    return replace(axis, base=base)


def physical(axis: GeneratedAxis, record: Record, **fixed: Any) -> tuple[Physical, Estimate]:
    known = knowing(axis, fix(axis.declared, **fixed))
    estimate = identify(known, record, FILTER, "idm-ls", bootstrap=0)["idm-ls"]
    return _physical(estimate), estimate


@pytest.mark.parametrize("theta", [[1.2, 0.45, 0.03, 0.4], [-1.0, 0.0, 2.0, 0.0]])
def test_map_and_jacobian_are_those_of_sympy(theta: list[float]) -> None:
    base = base_model(PENDULUM)
    symbols = [p.symbol for p in PENDULUM.parameters]
    point = dict(zip(symbols, theta, strict=True))
    beta, jacobian = mapped(base, np.array(theta))
    expected = sympy.Matrix(base.expressions)
    assert beta == pytest.approx([float(v.subs(point)) for v in expected])
    assert beta == pytest.approx(base.at(theta))
    slopes = expected.jacobian(symbols).subs(point)
    assert jacobian == pytest.approx(np.array(slopes.tolist(), dtype=float))


@pytest.mark.slow
def test_known_mass_gives_the_others_in_closed_form(
    pendulum: GeneratedAxis, record: Record
) -> None:
    """``l = b1/m`` and ``J = b2 - b1^2/m`` by the delta method, the mass's deviation in it."""
    mass, spread = 1.2, 0.01
    found, estimate = physical(pendulum, record, m=(mass, spread))
    b1, b2, drag = estimate.corrected
    values = found.parameters
    assert values["m"].value == pytest.approx(mass, rel=1e-12)
    assert values["l"].value == pytest.approx(b1 / mass, rel=1e-10)
    assert values["J"].value == pytest.approx(b2 - b1**2 / mass, rel=1e-9)
    assert values["fv"].value == pytest.approx(drag, rel=1e-10)
    slopes = np.array(
        [
            [0, 0, 0, 1],
            [1 / mass, 0, 0, -b1 / mass**2],
            [-2 * b1 / mass, 1, 0, b1**2 / mass**2],
            [0, 0, 1, 0],
        ]
    )
    for name in ("iid", "robust", "hac"):
        whole = np.zeros((4, 4))
        whole[:3, :3] = estimate.covariances[name]
        whole[3, 3] = spread**2
        assert found.covariances[name] == pytest.approx(slopes @ whole @ slopes.T, rel=1e-8)
    assert values["J"].sd_hac == pytest.approx(np.sqrt(found.covariances["hac"][2, 2]))
    assert (found.dof, found.p_value, found.undetermined) == (0, None, ())


def swinging(rng: np.random.Generator) -> Record:
    """An exact motion of the pendulum under a measured torque with noise."""
    t = np.arange(3000) * 1e-3
    position = 0.8 * np.sin(9 * t) + 0.3 * np.sin(23 * t)
    velocity = 7.2 * np.cos(9 * t) + 6.9 * np.cos(23 * t)
    acceleration = -64.8 * np.sin(9 * t) - 158.7 * np.sin(23 * t)
    torque = (
        (TRUTH["m"] * TRUTH["l"] ** 2 + TRUTH["J"]) * acceleration
        + TRUTH["fv"] * velocity
        + 9.81 * TRUTH["m"] * TRUTH["l"] * np.sin(position)
    )
    return Record(time=t, position=position, force=torque + rng.normal(0, 0.5, len(t)))


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(pendulum: GeneratedAxis) -> None:
    """Noise in the torque and in the weighing, of about the same weight in the length."""
    spread, runs, pulls = 0.006, 80, []
    rng = np.random.default_rng(1)
    for _ in range(runs):
        noisy = swinging(rng)
        found, estimate = physical(pendulum, noisy, m=(TRUTH["m"] + spread * rng.normal(), spread))
        pulls.append(
            [
                (found.parameters[name].value - TRUTH[name])
                / (found.parameters[name].interval[1] - found.parameters[name].value)
                for name in ("l", "J")
            ]
        )
    share = estimate.parameters["m_l"].relative_deviation_percent / (100 * spread / TRUTH["m"])
    assert 0.5 < share < 2
    held = np.mean(np.abs(pulls) <= 1, axis=0)
    assert np.all((held >= 0.90) & (held <= 0.985)), held


@pytest.mark.slow
def test_without_a_known_value_only_what_is_told_apart_is_given(
    pendulum: GeneratedAxis, record: Record
) -> None:
    found = _physical(identify(pendulum, record, FILTER, "idm-ls")["idm-ls"])
    assert list(found.parameters) == ["fv"]
    assert found.covariances["hac"].shape == (1, 1)
    assert found.undetermined[0].endswith("the rest follows if one of m, l, J is known")
    assert not found.shows_more


@pytest.mark.slow
def test_two_known_values_are_held_against_the_record(
    pendulum: GeneratedAxis, record: Record
) -> None:
    right, estimate = physical(pendulum, record, m=(1.2, 0.01), l=(0.45, 0.01))
    assert right.dof == 1
    check = fixed_check(estimate)
    assert (check.name, check.status, check.p_value) == ("fixed values", "pass", right.p_value)
    _, contradicted = physical(pendulum, record, m=(1.2, 0.01), l=(0.5, 0.01))
    check = fixed_check(contradicted)
    assert check.status == "fail"
    values = finding_of(check, FixedValues).values
    assert [(v.name, v.value, v.standard_error, v.unit) for v in values] == [
        ("m", 1.2, 0.01, "kg"),
        ("l", 0.5, 0.01, "m"),
    ]
    missing = fixed_check(physical(pendulum, record, m=1.2)[1])
    assert isinstance(missing, Missing)


def test_minimum_is_that_of_scipy(rng: np.random.Generator) -> None:
    """Over-determined, with correlated base parameters and two uncertain fixed values."""
    base = base_model(fix(PENDULUM, m=(1.2, 0.05), l=(0.44, 0.02)))
    spread = rng.normal(size=(3, 3)) * np.array([[0.02], [0.01], [0.05]])
    covariance = spread @ spread.T
    beta = np.array([0.54, 0.273, 0.4])
    distance = Distance(base, beta, covariance)
    whole = np.zeros((5, 5))
    whole[:3, :3], whole[3, 3], whole[4, 4] = covariance, 0.05**2, 0.02**2
    lower = np.linalg.cholesky(whole)

    def residuals(theta: np.ndarray) -> np.ndarray:
        mass, length, rod, drag = theta
        mapped = [mass * length, rod + mass * length**2, drag, mass, length]
        return np.linalg.solve(lower, np.array([*beta, 1.2, 0.44]) - mapped)

    other = least_squares(residuals, [1.0, 0.5, 0.05, 0.1], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    theta, cost = distance.minimum()
    assert theta == pytest.approx(other.x, rel=1e-6)
    assert cost == pytest.approx(2 * other.cost, rel=1e-9)
    influence = distance.influence(theta, 4)
    expected = np.linalg.inv(other.jac.T @ other.jac)
    assert influence @ whole @ influence.T == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("sharp", [1e-6, 1e-9])
def test_a_product_that_is_known_sharply_leaves_its_factor_where_it_is_known(sharp: float) -> None:
    """Its valley is as narrow as the product is sharp, and curved."""
    base = base_model(fix(PENDULUM, m=(1.2, 0.05)))
    beta = np.array(base.at(np.array([1.2, 0.45, 0.03, 0.4])))
    covariance = np.diag((sharp * beta) ** 2)
    theta, cost = Distance(base, beta, covariance).minimum()
    assert theta == pytest.approx([1.2, 0.45, 0.03, 0.4], rel=1e-5)
    assert cost < 1e-6


def test_linear_axis_with_an_exactly_known_parameter_is_restricted_least_squares(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    known = replace(emps2015, base=base_model(fix(emps2015.axis, M=100.0)))
    estimate = identify(known, twin, methods="idm-ls")["idm-ls"]
    distance = Distance(known.base, estimate.physical, estimate.covariances["iid"])
    y, regressor = estimate.y - 100.0 * estimate.X[:, 0], estimate.X[:, 1:]
    expected = np.linalg.lstsq(regressor, y, rcond=None)[0]
    theta, cost = distance.minimum()
    assert theta == pytest.approx([100.0, *expected], rel=1e-9)
    variance = estimate.residuals @ estimate.residuals / (len(y) - 1)
    influence = distance.influence(theta, 2)
    assert (influence @ estimate.covariances["iid"] @ influence.T)[1:, 1:] == pytest.approx(
        variance * np.linalg.inv(regressor.T @ regressor), rel=1e-7
    )
    restricted = y - regressor @ expected
    more = restricted @ restricted - estimate.residuals @ estimate.residuals
    assert cost == pytest.approx(more / variance, rel=1e-6)


def test_known_mass_with_a_deviation_is_weighed_with_the_record(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """As a Kalman filter takes up a measurement: the others change by their correlation."""
    value, spread = 100.25, 0.05
    known = replace(emps2015, base=base_model(fix(emps2015.axis, M=(value, spread))))
    estimate = identify(known, twin, methods="idm-ls")["idm-ls"]
    found = _physical(estimate)
    covariance = estimate.covariances["hac"]
    gains = covariance[:, 0] / (covariance[0, 0] + spread**2)
    expected = estimate.corrected + gains * (value - estimate.corrected[0])
    assert [v.value for v in found.parameters.values()] == pytest.approx(expected, rel=1e-9)
    assert found.covariances["hac"] == pytest.approx(
        covariance - np.outer(gains, covariance[0]), rel=1e-6
    )
    assert found.parameters["M"].sd_hac < min(spread, estimate.parameters["M"].sd_hac)


def geared(**fixed: Any) -> Axis:
    axis = bodies.geared(b * x.velocity, drive=Drive(gain=18.0, unit="A", relative_sd=0.01))
    return fix(axis, **fixed)


def sine_record() -> Record:
    t = np.arange(4000) * 1e-3
    position = 0.1 * np.sin(9 * t) + 0.03 * np.sin(23 * t)
    velocity = 0.9 * np.cos(9 * t) + 0.69 * np.cos(23 * t)
    acceleration = -8.1 * np.sin(9 * t) - 15.87 * np.sin(23 * t)
    noise = np.random.default_rng(3).normal(0, 0.3, len(t))
    control = ((5.0 + 1.44) * acceleration + 14.0 * velocity + noise) / 18.0
    return Record(time=t, position=position, control=control)


@pytest.mark.slow
def test_another_name_than_a_methods_is_told_with_those_that_there_are() -> None:
    result = identify(geared(Jm=(1e-4, 5e-6)), sine_record(), Prefilter(hold="raw"), "idm-ls")
    assert result.physical["IDM-LS"] is result.physical["idm-ls"]
    with refuses("result", says="'m'. Choose from idm-ls"):
        result.physical["m"]
    plain = identify(build(load_axis("emps2015")), sine_record(), Prefilter(hold="raw"), "idm-ls")
    with refuses("result"):
        plain.physical["idm-ls"]


@pytest.mark.slow
def test_start_of_zero_and_wild_nominal_values_find_the_same(
    pendulum: GeneratedAxis, record: Record
) -> None:
    right, _ = physical(pendulum, record, m=1.2)
    for nominal in (0.0, 40.0, 1e-3):
        parameters = tuple(
            replace(p, nominal=nominal if p.name in "lJ" else p.nominal)
            for p in PENDULUM.parameters
        )
        axis = replace(PENDULUM, parameters=parameters)
        found, _ = physical(knowing(pendulum, axis), record, m=1.2)
        for name, value in found.parameters.items():
            assert value.value == pytest.approx(right.parameters[name].value, rel=1e-7)


def squared(lower: float, size: float = 1.0) -> GeneratedAxis:
    root = Parameter("r", "m", size, lower)
    unit = Constant(size**-2, "kg/(m^2 s)")
    drag = unit * root.symbol**2 * x.velocity
    axis = body(drag, coordinate=x, inertia=bodies.m, parameters=(root,), drive=Drive(gain=18.0))
    return build(axis)


@pytest.mark.parametrize("size", [1.0, 1e-9])
def test_the_other_sign_of_a_square_is_told_unless_bounds_exclude_it(size: float) -> None:
    open_, bounded = (
        identify(squared(lower, size), sine_record(), Prefilter(hold="raw"), "idm-ls")
        for lower in (-np.inf, 0.0)
    )
    root = open_.physical["idm-ls"].parameters["r"].value
    assert root == pytest.approx(size * np.sqrt(14.0), rel=0.01)
    assert f"r = {-root:.4g} would fit as well" in open_.physical["idm-ls"].remarks[0]
    assert bounded.physical["idm-ls"].remarks == ()
    assert bounded.physical["idm-ls"].parameters["r"].value == pytest.approx(root, rel=1e-6, abs=0)


def test_the_root_of_a_negative_estimate_is_not_given() -> None:
    estimate = identify(squared(0.0), sine_record(), Prefilter(hold="raw"), "idm-ls")["idm-ls"]
    turned = replace(estimate, physical=estimate.physical * np.array([1.0, -1.0]))
    found = _physical(turned)
    assert found.parameters == {}
    assert "no values of the physical parameters give" in found.undetermined[-1]


@pytest.mark.slow
@pytest.mark.parametrize(("relative_sd", "status"), [(0.05, "pass"), (0.0, "fail")])
def test_gain_that_is_off_within_its_deviation_does_not_contradict_what_is_fixed(
    relative_sd: float, status: str
) -> None:
    axis = load_axis("emps")
    off = replace(axis.drive, gain=1.03 * axis.drive.gain, relative_sd=relative_sd)
    declared = fix(replace(axis, drive=off), M=(95.1089, 0.5))
    result = identify(declared, twin_record(axis), methods="idm-ls")
    assert {c.name: c.status for c in result.verdict}["fixed values"] == status
    if relative_sd:
        assert result.physical["idm-ls"].parameters["M"].value == pytest.approx(95.1089, abs=0.3)


def _physical(estimate: Estimate) -> Physical | None:
    return physical_parameters(estimate.method, estimate.form, estimate.distribution)
