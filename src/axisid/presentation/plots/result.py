"""Figures of a whole result: record, tracking, sweep, and all figures by record."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from axisid.estimation.choices import same_estimates
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.model_selection import Sweep
from axisid.estimation.records import Record, windows_text
from axisid.estimation.regression import loop_reference, simulated_loops, simulated_position
from axisid.support.arrays import Array, runs
from axisid.support.errors import DataError, EstimationError, ModelError
from axisid.support.missing import Missing

from .fit_and_residuals import (
    autocorrelation_plot,
    convergence_plot,
    force_plot,
    friction_plot,
    repeats_plot,
    spectrum_plot,
)
from .plot import TITLES, Panel, Plot, PlotSeries, Tone, broken, labelled, line, paired

_ROOM = 1.0  # free space above and below the IV estimates, relative to their range
_OF_ALL = ("convergence", "sweep")  # figures of all records together


def result_plots(result: Identification, sweep: "Sweep | None" = None) -> dict[str, Plot | Missing]:
    """Return every figure of a result by name, in report order.

    A figure that cannot be drawn is Missing, with the reason.

    Parameters
    ----------
    result : Identification
    sweep : Sweep, optional
        Sweep of the same record over the cut-off.
    """
    estimate = result.preferred
    beside = [
        other
        for other in result.estimates.values()
        if other is not estimate and other.form.left == estimate.form.left
    ]
    repeats = repeats_plot(estimate, result.diagnosis.lack_of_fit)
    return {
        estimate.form.left: force_plot(estimate, beside),
        "friction": friction_plot(result, estimate),
        "convergence": convergence_plot(estimate),
        "tracking": tracking_plot(result, estimate),
        "autocorrelation": autocorrelation_plot(estimate),
        "spectrum": spectrum_plot(estimate),
        **({} if isinstance(repeats, Missing) else {"repeats": repeats}),
        **_over_cutoff(result, sweep),
        "record": record_plot(result),
    }


def _over_cutoff(result: Identification, sweep: Sweep | None) -> dict[str, Plot]:
    """Return the figure of a sweep by name; empty without a sweep."""
    return {} if sweep is None else {"sweep": sweep_plot(sweep, result.prefilter.cutoff)}


def tracking_plot(result: Identification, estimate: Estimate) -> Plot | Missing:
    """Return the figure of recorded and simulated position, tracking error and difference.

    Missing if the closed loop cannot be simulated, or the position was not recorded.
    """
    record = result.record
    try:
        reference = loop_reference(result.axis, record)
        position = simulated_position(simulated_loops(result.axis, record, estimate.physical))
    except (ModelError, DataError, EstimationError) as error:
        return Missing(str(error))
    time, unit = _times(record), result.axis.axis.coordinate.unit
    if record.integrated:
        return Missing("the position was not recorded, so the simulated one cannot be compared")
    recorded, simulated = reference - record.position, reference - position
    off = float(np.sqrt(np.mean((recorded - simulated)[result.data.sampling.kept] ** 2)))
    by = "reference" if record.injected is None else "reference and test signal"
    plot = Plot(
        name="tracking",
        title=TITLES["tracking"],
        caption=f"Closed loop simulated with the {estimate.method.upper()} estimate; input: {by}. "
        "Tracking error: reference minus position. The simulated position differs from the "
        f"recorded one by {off:.3g} {unit} (rms).",
        x_label=_time_label(record),
        panels=(
            Panel(
                label=labelled("position", unit),
                series=(
                    replace(line("reference", time, reference, "other"), dashed=True, aside=True),
                    line("recorded", time, record.position, "measured"),
                    replace(line("simulated", time, position), broad=True),
                ),
            ),
            Panel(
                label=labelled("tracking error", unit),
                series=(
                    line("recorded", time, recorded, "measured"),
                    replace(line("simulated", time, simulated), broad=True),
                ),
                weight=1.5,
            ),
            Panel(
                label=labelled("difference", unit),
                series=(line("", time, simulated - recorded, "error"),),
            ),
        ),
        shaded=_dropped(result),
        marks=tuple((place, "gap") for place in _gaps(record)),
    )
    return broken(plot, _gaps(record))


def record_plot(result: Identification) -> Plot:
    """Return the figure of the unfiltered record, with the samples that are not used shaded."""
    record, drive = result.record, result.axis.axis.drive
    time, q = _times(record), result.axis.axis.coordinate

    def drawn(role: str, values: Array) -> tuple[Array, Array]:
        """Return times and values of a role; for windows of a log, those of the whole log."""
        whole = record.around.get(role)
        if whole is None or whole.clock is None:
            return time, values
        return whole.clock, whole.values

    recorded = "integral of the velocity" if record.integrated else "position"
    position = [line(recorded, *drawn("position", record.position), "measured")]
    if record.reference is not None:
        position.append(
            replace(line("reference", *drawn("reference", record.reference)), broad=True)
        )
    outside = _outside(record)
    lost = [place for place in _gaps(record) if not any(a <= place <= b for a, b in outside)]
    columns: tuple[tuple[str, str, Array | None, Tone], ...] = (
        ("velocity", str(q.velocity_unit), record.velocity, "measured"),
        ("acceleration", str(q.acceleration_unit), record.acceleration, "measured"),
        ("control", drive.unit, record.control, "warm"),
        ("force", str(q.force_unit), result.data.force, "model"),
        (
            f"injected, {record.injected_at}",
            q.unit if record.injected_at == "reference" else drive.unit,
            record.injected,
            "other",
        ),
        *(
            (signal.name, signal.unit, record.signals.get(signal.name), "violet")
            for signal in result.axis.axis.signals
        ),
    )
    plot = Plot(
        name="record",
        title="The record",
        caption=_record_caption(result),
        x_label=_time_label(record),
        panels=(
            Panel(label=labelled("position", q.unit), series=tuple(position), weight=1.5),
            *(
                Panel(
                    label=labelled(name, unit),
                    series=(line("", *drawn(name.partition(",")[0], values), tone),),
                )
                for name, unit, values, tone in columns
                if values is not None
            ),
        ),
        shaded=_joined(outside + _dropped(result)),
        marks=tuple((place, "gap") for place in lost),
    )
    return broken(plot, _gaps(record))


def _record_caption(result: Identification) -> str:
    """Return the caption of the record: number of samples, source of the force, shading."""
    record, drive = result.record, result.axis.axis.drive
    unused = len(record) - int(result.data.sampling.used.sum())
    source = "drive gain times control" if drive.is_gain else "drive model applied to the control"
    if record.force is not None:
        source = "recorded"
    sentences = (
        f"{len(record)} unfiltered samples of {1e3 * record.period:.6g} ms. Force: {source}.",
        f"Shaded: {unused} samples without weight in the fit. A row combines several samples; "
        "samples without weight do not count in it."
        if unused
        else "",
        f"The rest of the log is also shaded; only {windows_text(record.windows)} is used."
        if record.windows
        else "",
    )
    return " ".join(filter(None, sentences))


def sweep_plot(sweep: Sweep, used: float | None = None) -> Plot:
    """Return the figure of every parameter over the cut-off, by least squares and IV.

    Bands are 95 % intervals.

    Parameters
    ----------
    sweep : Sweep
    used : float, optional
        Cut-off of the identification, Hz, which is marked.
    """
    panels = tuple(
        Panel(label=labelled(quantity.name, quantity.unit), series=curves, span=_span(curves))
        for quantity in sweep.results[0].preferred.quantities
        for curves in [_curves(sweep, quantity.name)]
    )
    marks = [] if sweep.recommended is None else [(sweep.recommended, "recommended")]
    if used is not None and used != sweep.recommended:
        marks.append((used, "used"))
    return Plot(
        name="sweep",
        title="Estimates over the cut-off",
        caption=_swept(sweep, cut=any(panel.span for panel in panels)),
        x_label="cut-off [Hz]",
        panels=panels,
        log=True,
        marks=tuple(marks),
    )


def _curves(sweep: Sweep, name: str) -> tuple[PlotSeries, ...]:
    """Return one parameter over the cut-offs: least squares (dashed) first, then IV estimates."""
    # Estimates by method and cut-off, without cut-offs that have none.
    found: dict[str, dict[float, Estimate]] = {}
    for method in sweep.methods:
        swept = zip(sweep.cutoffs, sweep.estimates(method), strict=True)
        found[method] = {cutoff: estimate for cutoff, estimate in swept if estimate is not None}
    uses_loop = {
        method: next(iter(by_cutoff.values())).Z is not None for method, by_cutoff in found.items()
    }
    # IV estimates have the first tones, but are drawn last.
    tones = dict(paired(sorted(found, key=uses_loop.__getitem__, reverse=True)))
    curves = []
    for method in sorted(found, key=uses_loop.__getitem__):
        values = [estimate.parameters[name] for estimate in found[method].values()]
        curves.append(
            PlotSeries(
                label=method.upper(),
                x=np.array([*found[method]]),
                y=np.array([value.corrected for value in values]),
                low=np.array([value.interval[0] for value in values]),
                high=np.array([value.interval[1] for value in values]),
                tone=tones[method],
                dashed=not uses_loop[method],
            )
        )
    return tuple(curves)


def _span(curves: Sequence[PlotSeries]) -> tuple[float, float] | None:
    """Return the range of y that shows the IV estimates, with free space around them.

    None if the whole range can be shown, or if there are no IV estimates.
    """
    low, high = _bounds(curves)
    iv_curves = [curve for curve in curves if not curve.dashed]
    if not iv_curves:
        return None
    iv_low, iv_high = _bounds(iv_curves)
    room = _ROOM * (iv_high - iv_low)
    span = max(low, iv_low - room), min(high, iv_high + room)
    return None if span == (low, high) else span


def _bounds(curves: Sequence[PlotSeries]) -> tuple[float, float]:
    """Return the smallest and the largest value of the bands of curves."""
    ends = [end for curve in curves for end in (curve.low, curve.high) if end is not None]
    return float(np.nanmin(np.concatenate(ends))), float(np.nanmax(np.concatenate(ends)))


def _swept(sweep: Sweep, *, cut: bool) -> str:
    """Return the caption of a sweep; `cut` is True if a panel does not show all values."""
    same: dict[str, str] = {}  # methods that give the estimate of another method
    for result in sweep.results:
        same |= same_estimates([*result.estimates])
    sentences = (
        "Estimates minus the bias of filter and noise, with 95 % intervals.",
        "Least squares drifts when noise begins to bias it; IV estimates do not.",
        "The scale follows the IV estimates; least squares may lie outside a panel." if cut else "",
        *(
            f"{one.upper()} and {other.upper()} are the same estimate."
            for one, other in same.items()
        ),
        f"Recommended: {sweep.recommendation}.",
    )
    return " ".join(filter(None, sentences))


def _times(record: Record) -> Array:
    """Return the time of each sample since the first sample, (N,), s.

    For windows of a log it is the time of the log.
    """
    if record.windows:
        return record.time
    if record.segments:
        return np.asarray(record.time - record.time[0], dtype=float)
    return record.period * np.arange(len(record), dtype=float)


def _time_label(record: Record) -> str:
    """Return the label of the time axis."""
    return "time of the log [s]" if record.windows else "time [s]"


def _outside(record: Record) -> tuple[tuple[float, float], ...]:
    """Return the time ranges, s, of a log outside the windows that are used."""
    whole = record.around.get("position")
    if whole is None or whole.clock is None:
        return ()
    ends = [float(np.nanmin(whole.clock)), *chain(*record.windows), float(np.nanmax(whole.clock))]
    return tuple((a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b)


def _joined(stretches: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Return time ranges in order, with overlapping ones merged."""
    joined: list[tuple[float, float]] = []
    for start, stop in sorted(stretches):
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(stop, joined[-1][1])
        else:
            joined.append((start, stop))
    return tuple(joined)


def _dropped(result: Identification) -> tuple[tuple[float, float], ...]:
    """Return the time ranges, s, of samples that belong to no row.

    These are dropped ends, masked and excluded samples, gaps, and segments that are too short.
    """
    time = _times(result.record)
    return tuple(
        (float(time[max(start - 1, 0)]), float(time[min(stop, len(time) - 1)]))
        for start, stop in runs(~result.data.sampling.used)
    )


def _gaps(record: Record) -> list[float]:
    """Return the time, s, in the middle of each gap between segments."""
    time = _times(record)
    return [float(time[start - 1] + time[start]) / 2 for start, _ in record.segments[1:]]


def plots_by_record(
    result: Identification, sweep: Sweep | None = None
) -> dict[int, dict[str, Plot | Missing]]:
    """Return figures by the number of the record, from 1, and by name.

    Figures of all records together have the number 0, and so has a single record. Names and titles
    of the figures of one of several records contain its number.

    Parameters
    ----------
    result : Identification
    sweep : Sweep, optional
        Sweep of the same records over the cut-off.
    """
    if not result.of_records:
        return {0: result_plots(result, sweep)}
    of_all = {"convergence": convergence_plot(result.preferred), **_over_cutoff(result, sweep)}
    found: dict[int, dict[str, Plot | Missing]] = {0: of_all}
    for i, (part, name) in enumerate(zip(result.parts, result.record_names, strict=True), 1):
        found[i] = {
            f"{key}-{i}": plot if isinstance(plot, Missing) else numbered(plot, i, name)
            for key, plot in result_plots(part).items()
            if key not in _OF_ALL
        }
    return found


def numbered(plot: Plot, number: int, name: str) -> Plot:
    """Return the plot of one of several records, with its number in name and title."""
    return replace(
        plot,
        name=f"{plot.name}-{number}",
        title=f"{plot.title}, record {number}",
        caption=f"Record {number}, {name}. {plot.caption}",
    )
