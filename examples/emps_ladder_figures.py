"""The figures of docs/emps_ladder.md; `emps_ladder.py` draws them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from drawn_pages import figure_of, written
from emps_ladder_data import STEP, TURNS, Array, Data, Model, left
from emps_ladder_models import GAIN
from emps_ladder_tables import Scored
from matplotlib.figure import Figure
from scipy.signal import butter, sosfiltfilt

_COLORS = ("#0b6bcb", "#c2410c", "#15803d", "#7c3aed", "#a16207")
_GREY = "#8a8f98"
_EDGE = 30.0  # Hz, of the force that is shown
_STEADY, _MOVING = 0.05, 0.01  # m/s^2, m/s: where it is shown


def draw(
    data: Data,
    scores: Mapping[str, Mapping[str, Scored]],
    shown: Sequence[tuple[str, Model]],
    folder: Path,
) -> tuple[Path, ...]:
    """Draw every figure into a folder; `shown` are the models whose runs are drawn, with labels."""
    errors = {
        name: (
            [1e6 * of[name].error for of in scores.values()],
            [1e6 * float(np.sqrt(np.mean(np.square(of[name].fitted)))) for of in scores.values()],
        )
        for name in ("1 s", "5 s")
    }
    cases = [(label, m, scores[label]["whole"].values[0]) for label, m in shown]
    figures = {
        "emps_ladder": rungs([*scores], errors),
        "emps_whole": whole_record(data, cases),
        "emps_force": force_over_position(data),
    }
    return written(figures, folder)


def rungs(labels: Sequence[str], errors: Mapping[str, tuple[list[float], list[float]]]) -> Figure:
    """Held-out errors of the rungs, and those of what was fitted, um, by length of the windows."""
    figure, (axes,) = figure_of(1, 4.6)
    places = np.arange(len(labels))
    for (name, (held, fitted)), color in zip(errors.items(), _COLORS, strict=False):
        for values, style, words in ((held, "o-", "held out"), (fitted, "x:", "fitted")):
            axes.plot(values[:-1], places[:-1], style, color=color, label=f"{name}, {words}")
            axes.plot(values[-1:], places[-1:], style, color=color)  # no rung above that one
    axes.set_xscale("log")
    axes.set_yticks(places, labels, fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("open-loop error, rms [um]")
    axes.legend(frameon=False, fontsize=8)
    return figure


def whole_record(data: Data, cases: Sequence[tuple[str, Model, Mapping[str, float]]]) -> Figure:
    """What is left of the whole record in one window, over time."""
    figure, (axes,) = figure_of(1, 3.6)
    for (label, model, values), color in zip(cases, _COLORS, strict=False):
        record = data.record(model)
        errors = 1e3 * left(model, record, values, TURNS[-1])
        time = STEP * np.arange(len(errors))
        told = f"{label}: {np.sqrt(np.mean(errors**2)):.2f} mm rms"
        axes.plot(time[::10], errors[::10], color=color, linewidth=1.2, label=told)
    for turn in TURNS[1:-1]:
        axes.axvline(turn, color=_GREY, linewidth=0.6, linestyle=":")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("simulated less recorded [mm]")
    axes.legend(frameon=False, fontsize=8, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return figure


def steady_force(data: Data) -> tuple[Array, Array, Array, Array]:
    """Position, velocity and force that the published model leaves at even speed, and its time."""
    low = butter(4, _EDGE, fs=1 / STEP, output="sos")
    held = data.columns["vir"]
    force = sosfiltfilt(low, GAIN * (held + np.r_[held[0], held[:-1]]) / 2)
    q = sosfiltfilt(low, data.columns["qm"])
    v = np.gradient(q, STEP)
    a = np.gradient(v, STEP)
    moving = np.abs(v) > _MOVING
    moving[:100] = moving[-100:] = False
    columns = np.array([a, v, np.sign(v), np.ones_like(v)]).T
    theta = np.linalg.lstsq(columns[moving], force[moving], rcond=None)[0]
    even = moving & (np.abs(a) < _STEADY)
    return q[even], v[even], (force - columns @ theta)[even], STEP * np.flatnonzero(even)


def force_over_position(data: Data) -> Figure:
    """What the published model leaves of the force, over the position, cycle by cycle."""
    q, v, force, time = steady_force(data)
    figure, panels = figure_of(2, 5.4, sharex=True)
    for axes, sign, words in zip(panels, (1, -1), ("forward", "back"), strict=True):
        for k, color in enumerate(_COLORS[:4]):
            own = (np.sign(v) == sign) & (time >= TURNS[k]) & (time < TURNS[k + 1])
            axes.plot(1e3 * q[own], force[own], ".", ms=1.0, color=color, label=f"cycle {k + 1}")
        axes.set_ylabel("force left [N]")
        axes.set_title(words, loc="left", fontsize=10)
    panels[0].legend(frameon=False, fontsize=8, ncols=4, markerscale=6)
    panels[1].set_xlabel("position [mm]")
    return figure
