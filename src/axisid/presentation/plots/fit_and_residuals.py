"""Figures of one estimate or fit: force, residuals, convergence, friction, repeats, outputs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.misspecification import LackOfFit
from axisid.estimation.model_validation import friction_curve
from axisid.estimation.output_error import OutputFit
from axisid.estimation.output_residuals import measured_output
from axisid.estimation.regression import power_density
from axisid.estimation.thresholds import CONVERGED
from axisid.presentation.result_files import SavedEstimate
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .plot import TITLES, Panel, Plot, PlotSeries, broken, labelled, line, paired

_GAP = 1.5  # periods of the rows; a larger step in time is a gap
_WIDE = 2.0  # half width of a band, in standard errors of the mean


def force_plot(estimate: Estimate, beside: Sequence[Estimate] = ()) -> Plot:
    """Return the figure of measured and reconstructed force (or acceleration) and the residual.

    The figure corresponds to figures 3 and 4 of the paper.

    Parameters
    ----------
    estimate : Estimate
    beside : sequence of Estimate
        Other estimates of the same quantity on the same rows, which a page shows on request.
    """
    left, unit, time = estimate.form.left, left_unit(estimate), row_times(estimate)
    name, light = estimate.method.upper(), estimate.light_rows
    residual = line(f"residual, {name}", time, estimate.residuals, "error")
    # By output error (DIDIM), the reconstructed force is that of the simulated loop.
    kind = "simulation" if estimate.by_output_error else "equation"
    loop: tuple[PlotSeries, ...] = ()
    if not (estimate.by_output_error or isinstance(estimate.simulated, Missing)):
        loop = (line("simulated loop", time, estimate.simulated, "warm"),)
    low_weight = replace(
        line("rows with low weight", time[light], estimate.residuals[light], "warm"),
        kind="points",
    )
    others = [
        line(f"reconstructed, {each.method.upper()}", time, each.y - each.residuals, "other")
        for each in beside
    ]
    other_residuals = [
        line(f"residual, {each.method.upper()}", time, each.residuals, "other") for each in beside
    ]
    gaps = time[:-1][np.diff(time) > _GAP * estimate.row_period]
    plot = Plot(
        name=left,
        title=f"Measured and reconstructed {left}",
        caption=f"{name} on the fitted rows. The {kind} error is "
        f"{estimate.equation_error_percent:.3g} % of the {left} (rms). The upper panel shows the "
        f"residual on the scale of the {left}, the lower panel on its own scale.",
        x_label="time [s]",
        panels=(
            Panel(
                label=labelled(left, unit),
                series=(
                    line("measured", time, estimate.y, "measured"),
                    replace(
                        line(f"reconstructed, {name}", time, estimate.y - estimate.residuals),
                        broad=True,
                    ),
                    residual,
                    *(replace(each, aside=True) for each in (*others, *loop)),
                ),
                weight=2.0,
            ),
            Panel(
                label=labelled("residual", unit),
                series=(
                    residual,
                    *(replace(each, aside=True) for each in other_residuals),
                    *((low_weight,) if light.any() else ()),
                ),
            ),
        ),
    )
    return broken(plot, list(gaps + estimate.row_period / 2))


def autocorrelation_plot(estimate: Estimate | SavedEstimate) -> Plot:
    """Return the figure of the autocorrelation of the residuals over the lag, s."""
    tests = estimate.residual_tests
    bound, values = tests.autocorrelation.bound_95, tests.autocorrelation.values[1:]
    lags = estimate.row_period * np.arange(1, len(values) + 1, dtype=np.float64)
    return Plot(
        name="autocorrelation",
        title="Autocorrelation of the residuals",
        caption=f"{estimate.method.upper()}. 95 % of the values of independent residuals lie "
        f"within the dashed lines. The Durbin-Watson statistic is {tests.durbin_watson:.2f}; it "
        f"is 2 for independent residuals.{_missing_rows(estimate)}",
        x_label="lag [s]",
        panels=(
            Panel(
                label="autocorrelation",
                series=(PlotSeries(label="", x=lags, y=values, kind="stems"),),
                levels=(-bound, bound),
            ),
        ),
    )


def spectrum_plot(estimate: Estimate) -> Plot | Missing:
    """Return the figure of the power densities of force (or acceleration) and residuals.

    Welch's method is used; Missing if there are too few rows for it.
    """
    left, unit = estimate.form.left, left_unit(estimate)
    found = power_density(
        np.column_stack([estimate.y, estimate.residuals]),
        1 / estimate.row_period,
        estimate.neighbours,
    )
    if isinstance(found, Missing):
        return found
    frequency, power = found
    squared = f"({unit})^2" if set(unit) & set(" /^*") else f"{unit}^2"
    positive = np.where(power > 0, power, np.nan)  # zero has no logarithm
    return Plot(
        name="spectrum",
        title=TITLES["spectrum"],
        caption=f"{estimate.method.upper()}. Welch's estimate of the power density. At frequencies "
        f"where the residuals are as large as the {left}, the model explains nothing. A narrow "
        "peak is a vibration or a ripple that the model does not contain."
        f"{_missing_rows(estimate)}",
        x_label="frequency [Hz]",
        panels=(
            Panel(
                label=labelled("power density", f"{squared}/Hz"),
                series=(
                    PlotSeries(
                        label=left, x=frequency, y=positive[:, 0], tone="measured", broad=True
                    ),
                    line("residuals", frequency, positive[:, 1], "error"),
                ),
                log=True,
            ),
        ),
    )


def convergence_plot(estimate: Estimate | SavedEstimate) -> Plot | Missing:
    """Return the figure of the IV or DIDIM iteration.

    It shows the distance of each parameter from its final value, and the simulation error, by
    iteration. Missing for a method that does not iterate.
    """
    if not estimate.iterates:
        return Missing(f"{estimate.method.upper()} is not iterative: it uses no instruments")
    starts = {"least-squares": "least squares", "nominal": "the nominal values"}
    steps = np.arange(len(estimate.iterates), dtype=float)
    values = np.array([i.physical for i in estimate.iterates])
    deviations = np.sqrt(np.diag(estimate.covariances["iid"]))
    distances = np.abs(values - values[-1]) / np.where(deviations > 0, deviations, np.nan)
    distances[distances == 0] = np.nan  # the final value has distance zero, which has no logarithm
    errors = [i.simulation_error_percent for i in estimate.iterates]
    return Plot(
        name="convergence",
        title="Convergence of DIDIM" if estimate.by_output_error else TITLES["convergence"],
        caption=f"{estimate.method.upper()} starts from "
        f"{starts.get(estimate.started, 'its start')} (iteration 0) and converges in "
        f"{len(steps) - 1} iterations. The upper panel shows the distance of each parameter from "
        "its final value in i.i.d. standard errors (sd). The iteration ends when no parameter "
        f"changes by more than {CONVERGED.value:g} sd (dashed).",
        x_label="iteration",
        panels=(
            Panel(
                label="distance from final value [sd]",
                series=tuple(
                    line(name, steps, column, tone)
                    for (name, tone), column in zip(
                        paired([q.name for q in estimate.quantities]),
                        distances.T,
                        strict=True,
                    )
                ),
                levels=(CONVERGED.value,),
                log=True,
                weight=1.5,
            ),
            Panel(label="simulation error [%]", series=(line("", steps, errors, "error"),)),
        ),
        whole=True,
    )


def _missing_rows(estimate: Estimate | SavedEstimate) -> str:
    """Return a sentence for a caption on places where rows are missing; empty for none.

    Files do not contain these places, so the sentence is empty for a saved estimate.
    """
    breaks = len(estimate.neighbours.breaks) if isinstance(estimate, Estimate) else 0
    if not breaks:
        return ""
    places = "1 place" if breaks == 1 else f"{breaks} places"
    return f" Rows are missing in {places}; rows on both sides of a gap are not paired."


def row_times(estimate: Estimate) -> Array:
    """Return the time of each row since the first sample of the record, (n,), s."""
    return estimate.rows * estimate.period if estimate.times is None else estimate.times


def left_unit(estimate: Estimate) -> str:
    """Return the unit of the force or acceleration that is regressed."""
    q = estimate.form.axis.axis.coordinate
    return str(q.force_unit if estimate.form.left == "force" else q.acceleration_unit)


def friction_plot(result: Identification, estimate: Estimate) -> Plot | Missing:
    """Return the figure of measured friction over velocity, with the fitted friction law.

    Missing, with the reason, if the friction cannot be computed.
    """
    found = friction_curve(result, estimate)
    if isinstance(found, Missing):
        return found
    q = result.axis.axis.coordinate
    v, mean, spread = found.binned.T
    skipped = ""
    if found.skipped:
        skipped = (
            f" {found.skipped} rows near reversals, standstill and ends, which the fit excludes, "
            "are not shown."
        )
    return Plot(
        name="friction",
        title=TITLES["friction"],
        caption="Friction is the recorded force minus those terms of the model that do not depend "
        f"on the velocity ({estimate.method.upper()} estimate). Points: friction in each row. "
        "Points with bars: mean and standard deviation in bins of velocity. Line: fitted friction "
        "law. If neighbouring bins deviate from the line in the same direction, the law lacks a "
        f"friction term.{skipped}",
        x_label=labelled("velocity", f"{q.unit}/s"),
        panels=(
            Panel(
                label=labelled("friction", str(q.force_unit)),
                series=(
                    PlotSeries(
                        label="rows",
                        x=found.velocity,
                        y=found.force,
                        kind="points",
                        tone="measured",
                        broad=True,
                    ),
                    line("fitted law", *found.law.T),
                    PlotSeries(
                        label="mean and standard deviation by bin",
                        x=v,
                        y=mean,
                        low=mean - spread,
                        high=mean + spread,
                        kind="points",
                        tone="error",
                    ),
                ),
            ),
        ),
    )


def repeats_plot(estimate: Estimate | SavedEstimate, found: LackOfFit | None) -> Plot | Missing:
    """Return the figure of the mean residual over one period of the reference.

    If the residual were only noise, 95 % of the means would lie within the band.

    Parameters
    ----------
    estimate : Estimate or SavedEstimate
        For a saved estimate, the figure has no unit, because files do not contain it.
    found : LackOfFit or None
        The repeating residual; None if the reference does not repeat. The figure is then Missing.
    """
    left = "acceleration" if estimate.is_direct else "force"
    unit = left_unit(estimate) if isinstance(estimate, Estimate) else ""
    if found is None:
        return Missing("the reference of the record does not repeat, or is not recorded")
    half_width = _WIDE * found.noise / np.sqrt(found.count)
    noise = f"{found.noise:.2g} {unit}".rstrip()
    period = "a period" if found.period is None else f"the period of {found.period:.4g} s"
    plot = Plot(
        name="repeats",
        title=TITLES["repeats"],
        caption=f"{estimate.method.upper()}: mean residual over up to {found.times} repeats, "
        f"minus the residual that the filter alone causes, at each phase of {period}. If the "
        f"residual were only noise of {noise} (rms), 95 % of the means would lie within the band. "
        "The part outside the band is model error: "
        f"{100 * max(found.share, 0.0):.0f} % of the power of the residual.",
        x_label="time [s]",
        panels=(
            Panel(
                label=labelled(f"mean residual of the {left}", unit),
                series=(
                    PlotSeries(label="mean residual", x=found.time, y=found.mean, tone="error"),
                    PlotSeries(
                        label="noise alone",
                        x=found.time,
                        y=np.zeros(len(found.time)),
                        low=-half_width,
                        high=half_width,
                        tone="other",
                    ),
                ),
            ),
        ),
    )
    is_gap = np.diff(found.time) > _GAP * estimate.row_period
    return broken(plot, list(found.time[:-1][is_gap] + estimate.row_period / 2))


def output_plot(fit: OutputFit, record: int = 0) -> Plot:
    """Return the figure of recorded and simulated outputs of one record, and their difference.

    `record` is the index of the record, from 0.
    """
    count = len(fit.outputs)
    of_record = fit.of_records[record * count : (record + 1) * count]
    errors = [
        f"{e.error:.3g} {e.unit} (rms), {e.percent:.3g} % of the {e.output or fit.output}"
        for e in of_record
    ]
    return Plot(
        name="output",
        title="Output, recorded and simulated",
        caption=f"Simulation with the fitted parameters. Residual: {' and '.join(errors)}.",
        x_label="time [s]",
        panels=tuple(
            panel for place in range(count) for panel in _output_panels(fit, record, place)
        ),
    )


def _output_panels(fit: OutputFit, record: int, place: int) -> tuple[Panel, Panel]:
    """Return the panels of one output: recorded and simulated, and their difference.

    `record` and `place` are the indices of the record and of the output.
    """
    own, rows = fit.records[record], fit.predictions.samples[record]
    output, unit = fit.outputs[place], fit.predictions.units[place]
    recorded = measured_output(output, fit.axis, own)[-1][rows]
    time, errors = own.time[rows], fit.errors[record].reshape(len(rows), -1)[:, place]
    return (
        Panel(
            label=labelled(output, unit),
            series=(
                line("recorded", time, recorded, "measured"),
                PlotSeries(label="simulated", x=time, y=recorded + errors, broad=True),
            ),
        ),
        Panel(label=labelled("difference", unit), series=(line("", time, errors, "error"),)),
    )
