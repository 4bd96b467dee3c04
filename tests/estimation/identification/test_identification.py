"""What the estimators do with known terms, force columns, alignment, odd records and signals."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy

import axisid
from axisid import (
    Constant,
    EstimationError,
    Parameter,
    Prefilter,
    Record,
    build,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd
from axisid.estimation.diagnostics.control_law import ScaledColumn
from axisid.estimation.simulation.twin import trajectory
from axisid.support.arrays import relative_error_percent
from tests.axes.recorded import MOVES, PERIOD_S, TRUTH, recorded_axis, recorded_values
from tests.law_findings import repair_of_law
from tests.refusals import refuses
from tests.unjudged import identify

#: The position by a metre.
X = load_axis("emps2015").coordinate.symbol / Constant(1.0, "m").symbol


def test_simulated_left_side_is_that_of_the_simulated_loop(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    every_row = Prefilter(decimate=1, drop=(0, 0), hold="raw", reversals="keep")
    estimate = identify(emps2015, twin, every_row, ["idm-iv"])["idm-iv"]
    loop = simulate(emps2015, estimate.physical, twin.reference, 1e-3, start=twin.position[0])
    assert estimate.simulated == pytest.approx(loop.force, rel=1e-3, abs=0.05)
    assert estimate.simulation_error_percent == pytest.approx(
        relative_error_percent(estimate.y - loop.force, estimate.y), rel=1e-2
    )


@pytest.mark.slow
def test_force_column_is_taken_instead_of_the_control(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    doubled = replace(twin, force=2 * 35.15 * twin.control)
    raw = Prefilter(hold="raw", reversals="keep")
    whole = identify(emps2015, twin, raw, methods="idm-ls")["idm-ls"]
    twice = identify(emps2015, doubled, raw, methods="idm-ls")["idm-ls"]
    assert twice.physical == pytest.approx(2 * whole.physical)
    assert "force column" in identify(emps2015, doubled, methods="idm-ls").summary(every=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "is_measured", "prefilter", "hold"),
    [
        ({}, False, None, "zoh"),
        ({}, True, None, "raw"),
        ({}, True, Prefilter(cutoff=100.0, decimate=5, hold="zoh", drop=(50, 50)), "zoh"),
        ({"control": None}, False, None, "zoh"),
        (
            {"control": cascade_pd(kp=160.18, kv=243.45, period=1e-3, continuous=True)},
            False,
            None,
            "raw",
        ),
    ],
)
def test_hold_follows_from_what_the_force_is(
    twin: Record, law: dict[str, Any], is_measured: bool, prefilter: Prefilter | None, hold: str
) -> None:
    """A drive holds its control over the period; a measured force and a continuous law do not."""
    record = replace(twin, force=35.15 * twin.control) if is_measured else twin
    result = identify(replace(load_axis("emps2015"), **law), record, prefilter, "idm-ls")
    assert result.prefilter.hold == hold


def test_instruments_are_aligned_like_the_measured_rows(emps2015: GeneratedAxis) -> None:
    """Where nothing is filtered away, aligned instruments give the truth to half a percent."""
    record = twin_record(emps2015, position_noise=0.0)
    fine = Prefilter(cutoff=180.0, decimate=3, hold="zoh", drop=(50, 50))
    raw = replace(fine, hold="raw", reversals="keep")
    aligned, apart = (
        identify(emps2015, record, each, ["idm-iv"]).preferred for each in (fine, raw)
    )
    truth = np.array([100.2, 236.9, 24.8])
    assert aligned.physical == pytest.approx(truth, rel=5e-3)
    assert np.abs(apart.physical / truth - 1).max() > 1e-2


def test_record_at_another_period_than_the_law_serves_least_squares_only() -> None:
    axis = load_axis("emps2015")
    record = replace(twin_record(axis), sample_period=None)  # nobody confirms its period
    other = replace(axis, control=replace(axis.control, period=2e-3))
    result = identify(other, record)
    assert set(result.estimates) == {"idm-ls", "ddm-ls"}
    assert "every 0.001 s" in result.skipped["idm-iv"]
    with refuses("loop-period"):
        identify(other, record, methods=["ddm-iv"])


@pytest.mark.slow
def test_failed_instruments_do_not_lose_least_squares() -> None:
    axis = load_axis("emps2015")
    massless = replace(axis, parameters=(Parameter("M", "kg"), *axis.parameters[1:]))
    # With the other sign least squares has a negative mass, which is no start either.
    twin = twin_record(axis)
    flipped = replace(twin, control=-twin.control)
    result = identify(massless, flipped, start="nominal")
    assert (set(result.estimates), set(result.failed)) == (
        {"idm-ls", "ddm-ls"},
        {"idm-iv", "ddm-iv"},
    )
    assert "positive nominal value" in result.failed["idm-iv"]
    named = identify(massless, flipped, methods=["idm-iv", "idm-ls"], start="nominal")
    assert (set(named.estimates), set(named.failed)) == ({"idm-ls"}, {"idm-iv"})
    with pytest.raises(EstimationError, match="positive nominal value"):
        identify(massless, flipped, methods=["idm-iv", "ddm-iv"], start="nominal")


@pytest.mark.parametrize(
    ("prefilter", "remark"),
    [
        (Prefilter(cutoff=60.0, decimate=2), "the force only at 200 Hz"),
        (Prefilter(cutoff=60.0, decimate=1), "the force only at 500 Hz"),
    ],
)
def test_settings_that_mislead_are_remarked(
    emps2015: GeneratedAxis, prefilter: Prefilter, remark: str
) -> None:
    estimate = identify(emps2015, twin_record(emps2015), prefilter, ["idm-ls"])["idm-ls"]
    assert any(remark in r for r in estimate.remarks)


@pytest.mark.parametrize("term", [sympy.log(X - 5), sympy.sqrt(-1 - X**2)])
def test_known_terms_that_are_not_finite_are_refused(term: sympy.Expr, twin: Record) -> None:
    axis = load_axis("emps2015")
    with refuses("not-finite"):
        identify(
            replace(axis, force=axis.force + Constant(1.0, "N").symbol * term),
            twin,
            methods="idm-ls",
        )


def test_methods_and_parameters_are_found_as_they_are_printed(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = identify(emps2015, twin, methods=["idm-ls"])
    assert result["IDM-LS"] is result["idm-ls"]
    assert ("IDM-LS" in result, "idm-iv" in result, list(result)) == (True, False, ["idm-ls"])
    with refuses("result", says="'ddm'. Choose from idm-ls"):
        result["ddm"]
    with refuses("result", says="'mass'. Choose from M, Fv, Fc"):
        result["idm-ls"].parameters["mass"]


@pytest.mark.parametrize(
    ("given", "choices"),
    [
        ({"covariance": "bootstrap"}, "hac, robust, iid"),
        *(({"start": start}, "least-squares, nominal") for start in ("best", 3, None)),
        ({"loss": "cauchy"}, "squares, huber, bisquare"),
        *(({"methods": given}, "idm-ls, ddm-ls, idm-iv") for given in (["ols"], [])),
    ],
)
def test_another_choice_is_refused_with_those_that_there_are(
    emps2015: GeneratedAxis, twin: Record, given: dict[str, Any], choices: str
) -> None:
    with refuses("method", says=f"Choose from {choices}"):
        identify(emps2015, twin, **given)


#: Of which no noise moves the estimates.
METHODS = ("ddm-ls", "idm-iv", "ddm-iv")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "between"),
    [("pressure", "linear"), ("pressure", "held"), ("supply", "linear"), ("feed", "held")],
)
def test_intervals_of_twelve_twins_hold_the_truth(kind: str, between: str) -> None:
    """95 % intervals: 8 of 12 or fewer come by chance in 0.2 %; no check fails."""
    axis, held, failed = build(recorded_axis(kind, between)), Counter[str](), list[str]()
    for seed in range(100, 112):
        record = twin_record(axis, signals=recorded_values(kind, seed), seed=seed)
        result = identify(axis, record)
        assert set(result.estimates) == {*METHODS, "idm-ls", "didim"}
        for method in METHODS:
            values = result[method].parameters.items()
            held.update(
                f"{method} {n}" for n, v in values if v.interval[0] <= TRUTH[n] <= v.interval[1]
            )
        failed += [check.name for check in result.verdict if check.status == "fail"]
    assert all(held[f"{method} {name}"] > 8 for method in METHODS for name in axis.names)
    assert not failed


@pytest.mark.slow
def test_a_feed_forward_of_the_wrong_sign_is_named() -> None:
    axis = build(recorded_axis("feed"))
    record = twin_record(axis, signals=recorded_values("feed", 2), seed=2)
    result = identify(axis, replace(record, signals={"feed": -record.signals["feed"]}))
    repair = repair_of_law(result.diagnosis.law, ScaledColumn)
    assert (repair.role, repair.times) == ("feed", pytest.approx(-1.0, abs=1e-3))


@pytest.mark.slow
@pytest.mark.parametrize("every", [4, 5])
def test_a_loop_at_a_clock_of_its_own_reads_the_signals_between_samples(every: int) -> None:
    """A loop at several times the log's rate, its pressure straight between the log's samples."""
    fast = PERIOD_S / every
    declared = recorded_axis("pressure")
    law = replace(declared.control, period=fast, reference_between="linear")
    axis = build(replace(declared, control=law))
    log = trajectory(MOVES, PERIOD_S)
    ticks, samples = np.arange(every * (len(log) - 1) + 1) / every, np.arange(len(log))
    (pressure,) = recorded_values("pressure", 5).values()
    loop = simulate(
        axis,
        [TRUTH[name] for name in axis.names],
        np.interp(ticks, samples, log),
        fast,
        signals={"pressure": np.interp(ticks, samples, pressure)},
    )
    record = Record(
        time=PERIOD_S * samples,
        position=loop.position[::every],
        reference=log,
        control=loop.control[::every],
        signals={"pressure": pressure},
        sample_period=PERIOD_S,
    )
    estimate = identify(axis, record, methods=["idm-iv"]).estimates["idm-iv"]
    for name, value in estimate.parameters.items():
        assert sum(value.interval) / 2 == pytest.approx(TRUTH[name], rel=5e-3)
    assert estimate.simulation_error_percent is not None


def test_identify_returns_a_judged_result_unless_asked_not_to(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    judged = axisid.identify(emps2015, twin, methods="idm-ls", bootstrap=0)
    unjudged = axisid.identify(emps2015, twin, methods="idm-ls", bootstrap=0, judge=False)
    assert "diagnosis" in vars(judged)
    assert "diagnosis" not in vars(unjudged)
    assert [check.status for check in unjudged.checks] == [check.status for check in judged.checks]
