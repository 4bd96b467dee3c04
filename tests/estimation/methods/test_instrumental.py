"""The instruments' iteration: where it starts, and that it ends at its fixed point."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Record, build, identify, load_axis, simulate, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.misfit_checks import following
from axisid.estimation.estimates import NotSimulated
from axisid.estimation.estimates.estimate import Estimate
from axisid.estimation.methods.instrumental import NEARLY_CONVERGED
from axisid.estimation.thresholds import CONVERGED
from tests.refusals import refuses

SAMPLES = 5000


def white(name: str, amplitude: float, seed: int, *, noisy: bool) -> tuple[GeneratedAxis, Record]:
    """An axis of the library under a white reference, in parts of its own travel."""
    axis = build(load_axis(name))
    experiment, law = axis.axis.experiment, axis.axis.control
    truth = [experiment.truth.get(p.name, p.nominal) for p in axis.axis.parameters]
    travel = float(np.ptp(twin_record(axis, position_noise=0.0).position))
    rng = np.random.default_rng(seed)
    reference = rng.normal(0.0, amplitude * travel, SAMPLES)
    noise = rng.normal(0.0, experiment.position_noise, SAMPLES) if noisy else None
    loop = simulate(axis, truth, reference, law.period, position_noise=noise)
    record = Record(
        time=loop.time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
    )
    return axis, record


@pytest.mark.parametrize(
    ("name", "amplitude", "seed", "noisy"),
    [
        ("emps2015", 1e-3, 1, False),
        ("rotary_table", 1e-2, 1, False),
        ("linear_motor", 1e-3, 1, True),
        ("belt_axis", 1e-3, 0, True),
        ("crank", 1e-2, 0, False),
    ],
)
def test_a_white_reference_lets_the_instruments_end(
    name: str, amplitude: float, seed: int, noisy: bool
) -> None:
    axis, record = white(name, amplitude, seed, noisy=noisy)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    last, before = (estimate.iterates[k].physical for k in (-1, -2))
    moved = np.abs(last - before) / np.sqrt(np.diag(estimate.covariances["iid"]))
    assert moved.max() <= 2 * CONVERGED.value
    assert not any("jumps with the parameters" in remark for remark in estimate.remarks)


def test_a_loop_that_jumps_ends_near_and_says_so() -> None:
    axis, record = white("rotary_table", 1e-2, 1, noisy=True)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    (told,) = (r for r in estimate.remarks if "jumps with the parameters" in r)
    assert float(told.split("ends ")[1].split()[0]) <= NEARLY_CONVERGED


@pytest.fixture(scope="module")
def fitted() -> Estimate:
    axis = load_axis("emps2015")
    return identify(axis, twin_record(axis), methods="idm-ls")["idm-ls"]


@pytest.mark.slow
def test_estimates_without_inertia_fail_the_simulation() -> None:
    """Least squares needs no simulation, and yet says that there can be none."""
    axis = load_axis("emps2015")
    record = twin_record(axis)
    turned = replace(record, control=-record.control)
    result = identify(axis, turned, methods="idm-ls")
    (check,) = (c for c in result.verdict if c.name == "simulation")
    assert check.status == "fail"
    assert "no positive inertia" in check.meaning
    with refuses("simulation", says="no positive inertia"):
        identify(axis, turned, methods="idm-iv")


_STIFF = NotSimulated("it is too stiff.", by_estimate=True)


@pytest.mark.parametrize(
    ("changed", "rest", "said"),
    [
        ({"simulation_error_percent": 2.0}, 0.0, "the simulated loop follows the record$"),
        ({"simulation_error_percent": 46.0}, 0.0, "follows the record but for 46 %$"),
        (
            {"simulation_error_percent": 60.0},
            0.0,
            "leaves 60 % of the force unexplained; check the law, signs and units",
        ),
        ({"simulation_error_percent": 300.0}, 0.6, "rests in 60 % of the.*reversals=.leave-out"),
        ({"simulated": _STIFF, "simulation_error_percent": None}, 0.0, "it is too stiff$"),
    ],
)
def test_how_closely_the_loop_follows_is_said_and_what_keeps_it_from_it(
    fitted: Estimate, changed: dict[str, Any], rest: float, said: str
) -> None:
    check = following(replace(fitted, **changed), rest)
    assert re.search(said, check.meaning)
    assert (check.status == "fail") == (
        changed.get("simulated") is _STIFF or rest > 0 or "60" in said
    )


def test_a_loop_that_no_law_makes_is_no_objection(fitted: Estimate) -> None:
    untried = replace(
        fitted, simulated=NotSimulated("it has no law"), simulation_error_percent=None
    )
    untried = untried.with_inference(noise_free=None)
    assert following(untried, 0.0) == untried.simulated


IV = ["idm-iv", "ddm-iv"]
STARTS = ("least-squares", "nominal")


@pytest.mark.slow
def test_instruments_start_at_least_squares_and_end_where_the_published_start_does(
    library_axis: GeneratedAxis,
) -> None:
    record = twin_record(library_axis)
    found = {start: identify(library_axis, record, start=start) for start in STARTS}
    for method in (method for method in IV if method in found["nominal"]):
        here, there = (found[start][method] for start in STARTS)
        deviations = np.sqrt(np.diag(here.covariance))
        assert np.abs(here.physical - there.physical).max() <= 1e-4 * deviations.max()
        assert here.started == "least-squares"
        assert here.iterates[0].physical == pytest.approx(found["nominal"]["idm-ls"].physical)
        assert len(here.iterates) <= len(there.iterates)
        if library_axis.is_linear:
            assert there.started == "nominal"
            assert there.iterates[0].physical.tolist() == library_axis.nominal.tolist()


def test_least_squares_whose_loop_does_not_follow_is_no_start_and_it_is_said(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Noise of 0.2 mm leaves least squares a tenth of the mass."""
    rng = np.random.default_rng(3)
    noisy = replace(twin, position=twin.position + rng.normal(0.0, 2e-4, len(twin)))
    result = identify(emps2015, noisy)
    for method in IV:
        estimate = result[method]
        assert estimate.started == "nominal"
        assert estimate.iterates[0].physical.tolist() == emps2015.nominal.tolist()
        (said,) = [str(r) for r in estimate.remarks if "starts from the nominal values" in str(r)]
        assert "least squares" in said
    assert result["ddm-iv"].physical == pytest.approx(result["idm-iv"].physical, rel=1e-6)


@pytest.mark.parametrize("start", ["best", 3, None])
def test_another_start_is_refused(emps2015: GeneratedAxis, twin: Record, start: object) -> None:
    with refuses("method", says=r"choose from least-squares, nominal"):
        identify(emps2015, twin, start=start)  # type: ignore[arg-type]


def test_the_nominal_values_serve_where_least_squares_leads_to_no_end() -> None:
    """A white reference: from least squares the first iterate's loop diverges."""
    axis, record = white("belt_axis", 1e-3, 0, noisy=True)
    found, usual = (
        identify(axis, record, methods=["idm-iv"], start=start)["idm-iv"] for start in STARTS
    )
    assert found.started == "nominal"
    assert "comes to no end" in str(found.remarks[0])
    assert found.physical.tolist() == usual.physical.tolist()
