"""Windows of an open loop: each starts where the record is, and no law is asked for."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import Coordinate, Parameter, Record, build, fit, load_axis, newton, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import coulomb, viscous
from axisid.estimation.output_error.fit_findings import OpenLoopWindows
from axisid.estimation.output_residuals import MultipleShootingResiduals
from axisid.estimation.regression import InverseForm
from axisid.support.arrays import Array
from tests.estimation.output_error.fits import off
from tests.verdicts import checks_of, finding_of

SLOW_SCREW = Path(__file__).parents[3] / "benchmarks" / "slow_screw.toml"
THETA = np.array([100.2, 236.9, 24.8])


def _predictions(
    axis: GeneratedAxis, record: Record, horizon: float = 0.5
) -> MultipleShootingResiduals:
    return MultipleShootingResiduals(InverseForm(axis), [axis], [record], horizon)


def _errors(axis: GeneratedAxis, record: Record, *sets: Array, horizon: float = 0.5) -> Array:
    predictions = _predictions(axis, record, horizon)
    predictions.settle(THETA)
    return predictions(np.array(sets)).errors


def test_with_the_truth_nothing_is_left_wherever_a_window_starts(emps2015: GeneratedAxis) -> None:
    quiet = twin_record(emps2015, position_noise=0.0)
    right, wrong = np.abs(_errors(emps2015, quiet, THETA, 1.1 * THETA)).max(axis=0)
    assert right < 1e-7
    assert wrong > 1e-5


def test_what_a_first_position_or_velocity_makes_is_no_error(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """A record that is moved, and a clock of an encoder that creeps, leave the same errors."""
    there = replace(twin, position=twin.position + 0.3)
    errors, others = (_errors(emps2015, record, THETA) for record in (twin, there))
    np.testing.assert_allclose(errors, others, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("horizon", [0.25, 1.0, 100.0])
def test_the_fit_has_the_truth_without_a_law_or_a_reference(twin: Record, horizon: float) -> None:
    axis = replace(load_axis("emps2015"), control=None)
    result = fit(axis, replace(twin, reference=None), "open-loop", horizon=horizon)
    np.testing.assert_allclose(result.physical, THETA, rtol=1e-3)
    assert result.believed == (horizon == 0.25)  # the others are fewer than 20 windows
    assert result.horizon == horizon
    assert np.abs(off(result)).max() < 4
    assert f"windows of {horizon:g} s" in result.summary()
    assert result.plot() is not None
    assert checks_of(result)["control law"].status == "not evaluated"


def test_a_force_column_serves_without_a_control(emps2015: GeneratedAxis, twin: Record) -> None:
    drive = emps2015.axis.drive
    force = replace(twin, control=None, force=float(drive.gain) * np.asarray(twin.control))
    found, expected = (_errors(emps2015, record, THETA) for record in (force, twin))
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.slow
def test_parameters_may_have_the_names_of_gains(emps2015: GeneratedAxis, twin: Record) -> None:
    """No law is asked for, so that none brings names along."""
    q = Coordinate("q")
    mass, viscosity, friction = (
        Parameter("kp", "kg", nominal=100.0),
        Parameter("kV", "N/(m/s)", nominal=200.0),
        Parameter("kS", "N", nominal=20.0),
    )
    named = newton(
        "named",
        coordinate=q,
        parameters=(mass, viscosity, friction),
        inertia=mass,
        resistance=(viscous(viscosity, q), coulomb(friction, q)),
        drive=emps2015.axis.drive,
    )
    record = replace(twin, reference=None)
    found, expected = (_errors(axis, record, THETA) for axis in (build(named), emps2015))
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.slow
def test_a_window_has_twenty_samples_at_least(emps2015: GeneratedAxis, twin: Record) -> None:
    found = fit(emps2015, twin, "open-loop", horizon=1e-9, start="nominal", bootstrap=0)
    assert found.horizon == 20 * twin.period


def test_windows_that_begin_at_rest_stay_there(emps2015: GeneratedAxis, twin: Record) -> None:
    """A first velocity that friction stops at once is asked of by noise, and may not run away."""
    still = Record(
        time=np.asarray(twin.period * np.arange(100), dtype=float),
        position=twin.position[0] + np.random.default_rng(1).normal(scale=1e-6, size=100),
        control=0.02 + 0.01 * np.sin(0.1 * np.arange(100)),
        provenance=twin.provenance,
    )
    assert np.abs(_errors(emps2015, still, THETA, horizon=0.1)).max() < 5e-6


@pytest.mark.slow
def test_windows_are_shorter_where_friction_drives_the_motion_away() -> None:
    """Falling friction lets errors grow a hundredfold in a quarter of a second."""
    axis = build(load_axis(SLOW_SCREW))
    record = twin_record(axis, seed=3)
    given = axis.declared.experiment.truth
    truth = np.array([*given.values()])
    smooth = np.array([*{**given, "fs": 0.0}.values()])
    for horizon, steady in ((0.05, 0.05), (1.0, 0.0625), (4.0, 0.0625)):
        predictions = _predictions(axis, record, horizon)
        assert predictions.steady_horizon(truth) == steady
        assert predictions.steady_horizon(smooth) == horizon


@pytest.mark.slow
def test_an_open_loop_of_falling_friction_is_as_sure_as_it_says_or_asks_for_windows() -> None:
    """Without the friction that falls with the velocity, windows of a second look short enough."""
    axis = build(load_axis(SLOW_SCREW))
    truth, record = axis.declared.experiment.truth, twin_record(axis, seed=3)
    found = fit(axis, record, "open-loop", start=truth)
    assert found.believed
    assert found.horizon == 0.0625
    assert np.sqrt(np.mean(off(found, truth) ** 2)) < 1.8
    for asked in ({"start": {**truth, "fs": 0.0}}, {"start": truth, "horizon": 1.0}):
        long = fit(axis, record, "open-loop", **asked)
        windows = checks_of(long)["windows"]
        assert windows.status == "fail"
        finding = finding_of(windows, OpenLoopWindows)
        assert (finding.state, finding.steady_horizon) == ("growing", 0.0625)
