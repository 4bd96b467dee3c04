"""The figures of docs/dfki_pendulum.md; `dfki_pendulum_study.py` draws them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from dfki_pendulum import axis, drive_law
from dfki_pendulum_data import (
    DOCUMENTED,
    PUBLISHED,
    Data,
    authors_recipe,
    columns_by_hand,
    prefilter,
)
from dfki_pendulum_study import shown
from dfki_pendulum_twins import DELAYS, delay_profile, twin_delays
from drawn_pages import figure_of, written
from matplotlib.figure import Figure

from axisid import Identification, simulate
from axisid.estimation.signals import SampledFilter

_GREY, _BLUE, _RED, _GREEN = "#8a8f98", "#0b6bcb", "#c2410c", "#15803d"
_SMOOTH = 5.0  # Hz, of the torques that are compared


def draw(
    data: Data, results: Sequence[Identification], twins: Sequence[Data], folder: Path
) -> tuple[Path, ...]:
    """Draw every figure into a folder."""
    figures = {
        "dfki_torque": _torque(data, results),
        "dfki_sweep": _sweep(data, results),
        "dfki_delay": _delay(data, twins),
        "dfki_motion": _motion(data, results),
    }
    return written(figures, folder)


def _torque(data: Data, results: Sequence[Identification]) -> Figure:
    """As recorded, and low-passed beside what two estimates reconstruct on two records."""
    figure, (raw, *compared) = figure_of(3, 7.5)
    raw.plot(data.run.time, np.asarray(data.run.control), color=_GREY, linewidth=0.6)
    raw.set_title("identification run: torque as recorded", loc="left", fontsize=10)
    estimate = shown(results)["idm-iv"].physical
    for axes, name in zip(compared, ("identification run", "direct collocation"), strict=True):
        record = data.records[name]
        settings = prefilter(record, _SMOOTH)
        regressor, torque = columns_by_hand(record, settings)
        time = SampledFilter(settings, record.period).rows(len(record)) * record.period
        axes.plot(time, torque, color=_GREY, linewidth=2.6, label="recorded")
        axes.plot(time, regressor @ estimate, color=_BLUE, linewidth=1.3, label="IDM-IV")
        axes.plot(time, regressor @ PUBLISHED, color=_RED, linewidth=1.3, label="published values")
        axes.set_title(f"{name}: low-passed at {_SMOOTH:g} Hz", loc="left", fontsize=10)
    compared[0].set_ylim(-2.3, 3.0)
    compared[0].legend(loc="upper right", ncols=3, frameon=False, fontsize=9)
    for axes in (raw, *compared):
        axes.set_ylabel("torque [N m]")
        axes.set_xlim(0, 4)
    compared[-1].set_xlabel("time [s]")
    return figure


def _sweep(data: Data, results: Sequence[Identification]) -> Figure:
    """J and mc over the cut-off by three methods, with 95 % bands."""
    figure, panels = figure_of(2, 7.0, sharex=True)
    styles = {"idm-ls": (_RED, "IDM-LS"), "ddm-ls": (_GREY, "DDM-LS"), "idm-iv": (_BLUE, "IDM-IV")}
    edges = np.array([0.02, 0.033, 0.05, 0.075, 0.1, 0.15, 0.2])
    velocity = data.velocity["identification run"]
    recipe = np.array([authors_recipe(data.run, velocity, edge)[0] for edge in edges])
    units, tops = ("kg m^2", "kg m"), (0.42, 0.9)
    for i, (axes, name) in enumerate(zip(panels, ("J", "mc"), strict=True)):
        for method, (color, label) in styles.items():
            # Beyond 20 Hz the direct model's inertia passes through infinity.
            highest = 20.0 if method == "ddm-ls" else 60.0
            kept = [r for r in results if r.prefilter.cutoff <= highest and method in r.estimates]
            cutoffs = [r.prefilter.cutoff for r in kept]
            values = [r[method].parameters[name] for r in kept]
            low, high = zip(*(v.interval for v in values), strict=True)
            axes.fill_between(cutoffs, low, high, color=color, alpha=0.14, linewidth=0)
            middle = [v.value for v in values]
            axes.plot(
                cutoffs, middle, "o-", color=color, markersize=3.5, linewidth=1.3, label=label
            )
        hertz = edges * 0.5 / data.run.period
        axes.plot(hertz, recipe[:, i], "x", color="black", label="authors' recipe, its edge moved")
        axes.axhline(DOCUMENTED[name], color=_GREEN, linewidth=1.2, label="documented masses")
        axes.axhline(PUBLISHED[i], color="black", linewidth=1.0, linestyle="--", label="published")
        axes.set_ylim(-0.1 * tops[i] - 0.01, tops[i])
        axes.set_ylabel(f"{name} [{units[i]}]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    panels[1].set_xscale("log")
    panels[1].set_xticks([3, 5, 8, 15, 30, 60], ["3", "5", "8", "15", "30", "60"])
    panels[1].set_xticks([], minor=True)
    panels[1].set_xlabel("cut-off [Hz]")
    return figure


def _delay(data: Data, twins: Sequence[Data]) -> Figure:
    """Equation error over the delay of the torque, of records and of twins without any."""
    figure, panels = figure_of(2, 5.6, sharex=True)
    colors = dict(zip(data.records, (_RED, _BLUE, _GREEN), strict=True))
    for axes, cutoff in zip(panels, (_SMOOTH, 15.0), strict=True):
        _, profiles = twin_delays(twins, cutoff)
        for i, profile in enumerate(profiles):
            label = "twins of the run, no delay" if i == 0 else None
            relative = profile / profile.min()
            axes.plot(1e3 * DELAYS, relative, color="#c9ccd1", linewidth=0.9, label=label)
        for name, record in data.records.items():
            errors, _ = delay_profile(record, cutoff, DELAYS)
            best = int(errors.argmin())
            axes.plot(1e3 * DELAYS, errors / errors.min(), color=colors[name], label=name)
            axes.plot(1e3 * DELAYS[best], 1.0, "o", color=colors[name], markersize=5)
        axes.set_ylabel("equation error / its least")
        axes.set_ylim(0.98, 1.8)
        axes.set_title(f"low-passed at {cutoff:g} Hz", loc="left", fontsize=10)
    panels[1].legend(loc="upper center", frameon=False, fontsize=9)
    panels[1].set_xlabel("torque taken earlier by [ms]")
    return figure


def _motion(data: Data, results: Sequence[Identification]) -> Figure:
    """Recorded and simulated motion, and what the loop leaves of the reference."""
    figure, (motion, error, close) = figure_of(3, 8.0)
    run, reference = data.run, np.asarray(data.run.reference)
    estimate, start = shown(results)["idm-iv"].physical, float(data.run.position[0])
    motion.plot(
        run.time, reference, color="black", linewidth=0.9, linestyle="--", label="reference"
    )
    motion.plot(run.time, run.position, color=_GREY, linewidth=2.2, label="recorded")
    recorded = 1e3 * (reference - run.position)
    close.plot(run.time, recorded, ".-", color=_GREY, linewidth=1.2, label="recorded")
    error.plot(run.time, recorded, color=_GREY, linewidth=0.8, label="recorded")
    for p, d, color in ((50.0, 4.0, _BLUE), (25.0, 2.0, _GREEN), (100.0, 8.0, _RED)):
        assumed = replace(axis, control=drive_law(p, d))
        loop = simulate(assumed, estimate, reference, run.period, start=start)
        left, label = 1e3 * (reference - loop.position), f"simulated, {p:g} / {d:g}"
        error.plot(run.time, left, color=color, linewidth=1.3, label=label)
        if p == 50.0:
            motion.plot(run.time, loop.position, color=color, linewidth=1.0, label=label)
            close.plot(run.time, left, color=color, linewidth=1.3, label=label)
    close.set_xlim(1.8, 2.2)
    motion.set_ylabel("position [rad]")
    for axes in (error, close):
        axes.set_ylabel("reference - position [mrad]")
    close.set_title("the same, close up: the position shakes at 55 Hz", loc="left", fontsize=10)
    motion.legend(loc="upper left", frameon=False, fontsize=9)
    error.legend(loc="upper right", ncols=4, frameon=False, fontsize=8)
    error.set_ylim(-80, 125)
    close.set_ylim(-60, 20)
    close.set_xlabel("time [s]")
    return figure
