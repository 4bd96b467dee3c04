"""Figures as data say what is true of the result, and matplotlib draws every one of them."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

from axisid import (
    Constant,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    sweep,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import coulomb, viscous
from axisid.estimation import Sweep
from axisid.estimation.model_validation.friction_curve import friction_curve
from axisid.presentation.matplotlib import draw, rendered
from axisid.presentation.plots.fit_and_residuals import (
    autocorrelation_plot,
    convergence_plot,
    force_plot,
    friction_plot,
    spectrum_plot,
)
from axisid.presentation.plots.plot import Plot, PlotSeries
from axisid.presentation.plots.result import record_plot, result_plots, sweep_plot, tracking_plot
from axisid.support.missing import Missing
from tests.axes.bodies import b, body, c, k, m, x
from tests.refusals import refuses
from tests.unjudged import identify


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, Prefilter(reversals="keep"))


@pytest.fixture(scope="module")
def swept(emps2015: GeneratedAxis, twin: Record) -> Sweep:
    return sweep(emps2015, twin, (30.0, 90.0), methods=["idm-ls", "idm-iv"])


def there(plot: Plot | Missing) -> Plot:
    assert isinstance(plot, Plot)
    return plot


def series(plot: Plot | Missing, panel: int, label: str) -> PlotSeries:
    return next(s for s in there(plot).panels[panel].series if s.label.startswith(label))


def moved() -> Record:
    """Some motion with some force."""
    time = np.arange(4000) * 1e-3
    position = 0.3 * np.sin(5 * time) + 0.1 * np.sin(11 * time)
    return Record(time=time, position=position, force=np.sin(7 * time) + position)


def declared(*resistance: sympy.Expr, parameters: tuple[Parameter, ...]) -> GeneratedAxis:
    made = body(*resistance, coordinate=x, inertia=m, parameters=parameters, name="stage")
    return build(made, native=False)


@pytest.mark.parametrize("method", ["idm-ls", "idm-iv", "ddm-iv"])
def test_reconstruction_and_error_add_up_to_the_measurement(
    result: Identification, method: str
) -> None:
    plot = force_plot(result[method])
    whole = series(plot, 0, "reconstructed").y + series(plot, 1, "residual").y
    assert whole == pytest.approx(series(plot, 0, "measured").y, rel=1e-12)
    left = "force [N]" if method.startswith("idm") else "acceleration [m/s²]"
    assert plot.panels[0].label == left


def test_spectrum_holds_the_residuals_power(result: Identification) -> None:
    """Parseval: the density's integral is the variance, up to the window and the mean."""
    estimate = result["idm-iv"]
    found = series(spectrum_plot(estimate), 0, "residuals")
    power = float(np.sum(found.y) * (found.x[1] - found.x[0]))
    assert power == pytest.approx(float(np.var(estimate.residuals)), rel=0.1)
    assert found.x[-1] == pytest.approx(0.5 / (10 * estimate.period))


def test_convergence_shows_the_steps_that_end_it_and_least_squares_has_none(
    result: Identification,
) -> None:
    estimate = result["idm-iv"]
    panel = there(convergence_plot(estimate)).panels[0]
    assert [s.label for s in panel.series] == ["M", "Fv", "Fc"]
    assert (panel.levels, panel.log) == ((0.01,), True)
    last, before = estimate.iterates[-1].physical, estimate.iterates[-2].physical
    for j, s in enumerate(panel.series):
        deviation = estimate.parameters[s.label].sd
        assert s.y[-2] == pytest.approx(abs(before[j] - last[j]) / deviation)
        assert s.y[-2] < 0.01 < s.y[0]
        assert np.isnan(s.y[-1])  # the last from itself
    with refuses("figure", says="convergence cannot be drawn: IDM-LS is not iterative"):
        result["idm-ls"].plot("convergence")


def test_friction_law_is_the_closed_form_and_lies_on_rows_of_whole_weight(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    found = identify(emps2015, twin, methods=["idm-ls"])
    estimate = found["idm-ls"]
    shown = friction_curve(found, estimate)
    _, viscosity, coulombs = estimate.physical
    v, force = shown.law.T
    sliding = np.isfinite(force)
    assert force[sliding] == pytest.approx(viscosity * v[sliding] + coulombs * np.sign(v[sliding]))
    assert np.count_nonzero(~sliding) == 1  # rest is set-valued: the curve breaks there
    assert len(shown.velocity) == len(estimate.y) - shown.skipped < len(estimate.y)
    at, mean, _ = shown.binned.T
    law = viscosity * at + coulombs * np.sign(at)
    assert mean == pytest.approx(law, abs=0.1 * np.abs(law).max())
    assert not np.any(np.abs(at) < 1e-3)  # no bin mixes both directions
    plot = there(friction_plot(found, estimate))
    assert f"{shown.skipped} rows" in plot.caption


def test_gravity_and_springs_are_taken_off_the_friction() -> None:
    axis = declared(viscous(b, x), coulomb(c, x), k * x, parameters=(b, c, k))
    time = np.arange(6000) * 1e-3
    q, w = 0.3 * np.sin(5 * time), 5.0
    dq, ddq = 0.3 * w * np.cos(w * time), -0.3 * w**2 * np.sin(w * time)
    force = 2.0 * ddq + 3.0 * dq + 1.5 * np.sign(dq) + 40.0 * q
    record = Record(time=time, position=q, force=force)
    result = identify(
        axis, record, Prefilter(cutoff=100.0, decimate=5, hold="raw", reversals="keep"), ["idm-ls"]
    )
    found = friction_curve(result, result["idm-ls"])
    fast = np.abs(found.velocity) > 0.3
    law = 3.0 * found.velocity + 1.5 * np.sign(found.velocity)
    assert found.force[fast] == pytest.approx(law[fast], abs=0.15)


@pytest.mark.parametrize(
    ("resistance", "parameters", "reason"),
    [
        (b * sympy.sin(x / Constant(1.0, "m")) ** 2 * x.velocity, (b,), "depends on the position"),
        (k * x.symbol, (k,), "no term of the equation of motion depends on the velocity"),
    ],
)
def test_friction_that_is_no_curve_over_the_velocity_is_refused(
    resistance: sympy.Expr, parameters: tuple[Parameter, ...], reason: str
) -> None:
    axis = declared(resistance, parameters=parameters)
    result = identify(
        axis, moved(), Prefilter(cutoff=50.0, decimate=5, hold="raw", reversals="keep"), ["idm-ls"]
    )
    plot = friction_plot(result, result["idm-ls"])
    assert isinstance(plot, Missing)
    assert reason in plot.reason
    with refuses("figure", says=reason):
        result.plot("friction")


@pytest.mark.slow
def test_tracking_agrees_with_the_validation_of_the_same_record(
    result: Identification, twin: Record
) -> None:
    plot = there(tracking_plot(result, result["idm-iv"]))
    difference = plot.panels[2].series[0].y
    start, end = result.data.sampling.filter.dropped
    rms = float(np.sqrt(np.mean(difference[start : len(twin) - end] ** 2)))
    found = {v.method: v.position_error_rms for v in validate(result, twin)}
    assert rms == pytest.approx(found["idm-iv"], rel=1e-9)
    assert f"{rms:.3g} m (rms)" in plot.caption


@pytest.mark.slow
def test_sweep_marks_what_is_used_and_what_is_recommended(swept: Sweep) -> None:
    plot = sweep_plot(swept, 60.0)
    assert plot.marks == ((swept.recommended, "recommended"), (60.0, "used"))
    for panel, quantity in zip(plot.panels, ("M", "Fv", "Fc"), strict=True):
        assert panel.label.startswith(f"{quantity} [")
        assert [s.label for s in panel.series] == ["IDM-LS", "IDM-IV"]
        for s in panel.series:
            assert np.all((s.low < s.y) & (s.y < s.high))


def test_every_axis_of_every_figure_has_a_unit_or_counts(
    result: Identification, swept: Sweep
) -> None:
    unitless = {"iteration", "autocorrelation"}
    for plot in result_plots(result, swept).values():
        for label in (there(plot).x_label, *(p.label for p in there(plot).panels)):
            assert label in unitless or (label.endswith("]") and " [" in label), label


@pytest.mark.slow
def test_matplotlib_draws_the_same_bytes_twice(result: Identification) -> None:
    plot = autocorrelation_plot(result.preferred)
    for form, magic in (("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")):
        first, second = (rendered(draw(plot), form) for _ in range(2))
        assert first == second
        assert first.startswith(magic)


def test_gaps_are_marked_and_what_is_masked_is_shaded(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    time = np.array(twin.time)
    time[3000:] += 0.5
    time[3050:] += 0.25
    spans = ((0, 3000), (3000, 3050), (3050, 7801))
    cut = replace(twin, time=time, segments=spans, masked=((5000, 5100),))
    found = identify(emps2015, cut, Prefilter(reversals="keep"), ["idm-ls"])
    plot = record_plot(found)
    assert [place for place, _ in plot.marks] == pytest.approx([3.2495, 3.6745])
    kept = found.data.sampling.kept
    for first, last in plot.shaded:
        inside = (time > first + 1e-9) & (time < last - 1e-9)
        assert not kept[inside].any()
    drawn_position = plot.panels[0].series[0]
    assert drawn_position.x[-1] == pytest.approx(7.8 + 0.75)
    assert np.isnan(drawn_position.y).sum() == 2
    force = force_plot(found["idm-ls"])
    assert force.panels[0].series[0].x[-1] > 8.4
    assert np.isnan(force.panels[0].series[0].y).sum() >= 2
    # Both ends, the segment that is too short with its neighbours' ends, and what is masked.
    assert len(plot.shaded) == 4
    assert there(tracking_plot(found, found["idm-ls"])).marks == plot.marks
