"""Lanes of a record's loops are single loops; their slopes by parameters, law and time."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.output_residuals import (
    ClosedLoopResiduals,
    MultipleShootingResiduals,
    OutputResiduals,
    jacobian_at,
)
from axisid.estimation.regression import Form, InverseForm, simulated_loops
from axisid.estimation.unknowns import ExtendedForm
from axisid.modeling.quantities import Parameter
from tests.axes.complex_loop import control_of, derivative_of
from tests.axes.lagging import THETA as LAGGING, lagging
from tests.estimation.output_residuals.formula import Formula
from tests.refusals import refuses

THETA = np.array([100.2, 236.9, 24.8])
SETS = np.array([THETA, 1.1 * THETA])


def _predictions(axis: GeneratedAxis, output: str, *records: Record) -> ClosedLoopResiduals:
    return ClosedLoopResiduals(InverseForm(axis), [axis] * len(records), records, output)


@pytest.mark.parametrize(("output", "every"), [("control", 1), ("position", 1), ("control", 2)])
def test_lanes_are_loops_also_of_a_law_with_another_clock(
    emps2015: GeneratedAxis, output: str, every: int
) -> None:
    twin = twin_record(emps2015, position_noise=0.0)
    columns = {name: values[::every] for name, values in twin.channels().items()}
    record = Record(**columns, sample_period=every * twin.period)
    found = _predictions(emps2015, output, record)(SETS)
    for lane, theta in enumerate(SETS):
        loops = simulated_loops(emps2015, record, theta)
        own = np.concatenate([getattr(loop, output) for loop in loops]) - getattr(record, output)
        np.testing.assert_allclose(found.errors[:, lane], own, rtol=0, atol=1e-9)


def test_a_lane_that_fails_is_named_and_the_others_go_on(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    found = _predictions(emps2015, "control", twin)(np.array([THETA, [-1.0, 200.0, 20.0]]))
    assert [*found.failures] == [1]
    assert np.all(np.isfinite(found.errors[:, 0]))
    assert np.all(np.isnan(found.errors[:, 1]))


def test_an_output_that_was_not_recorded_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    with refuses("missing-column", says="no force column"):
        _predictions(emps2015, "force", twin)


def test_slopes_by_the_law_are_those_of_another_law(twin: Record) -> None:
    declared = load_axis("emps2015")
    axis, law = build(declared), declared.control
    predictions = _predictions(axis, "position", twin)
    slopes = predictions.jacobian_by_law(THETA)
    assert {*slopes} == {"kp*kv", "kv"}
    here = predictions(THETA[None, :]).errors[:, 0]
    more = replace(law, gains={**law.gains, "kp": 1.0001 * law.gains["kp"]})
    other = _predictions(build(replace(declared, control=more)), "position", twin)
    slope = (other(THETA[None, :]).errors[:, 0] - here) / 1e-4
    assert np.linalg.norm(slopes["kp*kv"] - slope) < 1e-3 * np.linalg.norm(slope)


@pytest.mark.slow
@pytest.mark.parametrize("logged", ["command", "applied"])
def test_the_steps_of_a_drive_are_not_simulated(logged: str) -> None:
    """They are a staircase of the parameters, on which no search moves."""
    rounding = build(lagging(quantisation=0.05, logged=logged), native=False)
    plain = build(lagging(), native=False)
    record = twin_record(rounding).windowed((None, 0.3))
    found, smooth = (
        _predictions(axis, "control", record)(LAGGING[None, :]).errors for axis in (rounding, plain)
    )
    assert np.array_equal(found, smooth)
    assert np.any(found)


INFINITE = np.full(3, np.inf)


def test_slopes_are_those_of_an_independent_derivative_through_reversals_and_rests(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    predictions = ClosedLoopResiduals(InverseForm(emps2015), [emps2015], [twin], "control")
    start = predictions.stretches[0].inputs.start
    assert start.velocity == 0.0
    reference = np.asarray(twin.reference)
    exact = control_of(THETA, reference, start.position).real
    predictions.settle(THETA)
    errors, found = jacobian_at(predictions, THETA, THETA, np.zeros(3), INFINITE)
    np.testing.assert_allclose(errors + twin.control, exact, atol=1e-6)
    slopes = derivative_of(THETA, reference, start.position)
    off = np.linalg.norm(found - slopes, axis=0) / np.linalg.norm(slopes, axis=0)
    assert off.max() < 1e-5, off


def _parabola(limit: float = np.inf) -> Formula:
    return Formula(lambda physical: (physical**2 + physical).T.copy(), 2, limit)


@pytest.mark.parametrize("at", [0.0, 1e-5, 0.5, 1.0])
def test_at_a_bound_the_differences_stay_inside_and_are_of_second_order(at: float) -> None:
    parabola, here = _parabola(), np.array([at, 0.5])
    lower, upper = np.zeros(2), np.ones(2)
    _, found = jacobian_at(parabola, here, np.ones(2), lower, upper)
    np.testing.assert_allclose(found, np.diag(2 * here + 1), atol=1e-9)
    assert np.all((parabola.seen[0] >= lower) & (parabola.seen[0] <= upper))


def test_a_parameter_whose_lane_fails_is_stepped_less() -> None:
    parabola, here = _parabola(limit=1.0 + 2e-5), np.array([0.2, 1.0])
    _, found = jacobian_at(parabola, here, np.ones(2), np.zeros(2), INFINITE[:2])
    np.testing.assert_allclose(found, np.diag(2 * here + 1), atol=1e-8)
    assert {len(lanes) for lanes in parabola.seen[1:]} == {3}  # those of the parameter alone


LATER, STEP = 2e-5, 5e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lag", "delay"])
@pytest.mark.parametrize("output", ["control", "open-loop"])
def test_errors_are_a_straight_line_of_the_time(
    emps2015: GeneratedAxis, output: str, name: str
) -> None:
    record = twin_record(emps2015).windowed((None, 0.4))
    form, drive = InverseForm(emps2015), emps2015.declared.drive
    every_other = {name: values[::2] for name, values in record.channels().items()}
    slow = Record(**every_other, sample_period=2e-3)

    def of(more: float, form: Form = form) -> OutputResiduals:
        late = drive.with_time(name, 4e-4 + more)
        axis = build(replace(emps2015.declared, drive=late))
        if output == "open-loop":
            return MultipleShootingResiduals(form, [axis, axis], [record, slow], 0.1)
        return ClosedLoopResiduals(form, [axis], [record], output)

    time = (Parameter(name, "s", lower=0.0),)
    searched = ExtendedForm(emps2015, of_model=form, axes=(emps2015,), time=time)
    timed, other, here = of(0.0, searched), of(LATER), of(0.0)
    timed.follow_time(of(STEP, searched), np.append(THETA, 4e-4), 4e-4, STEP)
    for each in (other, here):
        each.settle(THETA)
    found = timed(np.append(THETA, 4e-4 + LATER)[None, :]).errors[:, 0]
    expected, before = (each(THETA[None, :]).errors[:, 0] for each in (other, here))
    assert np.linalg.norm(found - expected) < 0.05 * np.linalg.norm(expected - before)


def test_a_search_begins_with_the_steps_that_its_own_start_asks_for(
    emps2015: GeneratedAxis,
) -> None:
    record = twin_record(emps2015).windowed((None, 0.4))
    predictions = ClosedLoopResiduals(InverseForm(emps2015), [emps2015], [record], "control")
    stiff = THETA * [1e-4, 10.0, 1.0]
    predictions.settle(THETA)
    (stretch,) = predictions.stretches
    calm = stretch.substeps
    predictions.settle(stiff)
    assert calm is not None
    assert (stretch.substeps or 0) > calm
    predictions.begin(THETA)
    predictions.settle(THETA)
    assert stretch.substeps == calm
