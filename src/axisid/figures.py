"""Figures. Matplotlib is imported here, and this module only where a figure is drawn."""

import os
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from axisid.estimation import Estimate, Sweep

_MEASURED, _RECONSTRUCTED, _ERROR = "#8a8f98", "#0b6bcb", "#c2410c"


def force_figure(
    estimate: Estimate, period: float, unit: str, title: str, path: Path, *, seconds: float = 3.0
) -> None:
    """Draw measured and reconstructed force and their difference, like the paper's figures 3 and 4.

    Parameters
    ----------
    estimate : Estimate
        Of an inverse model, whose left side is the force.
    period : float
        Sampling period of the record, s.
    unit : str
        Of the force.
    title : str
        Of the figure.
    path : Path
        Written whole or not at all; the suffix chooses the format.
    seconds : float
        How much of the record is shown, from its first row.
    """
    time = estimate.rows * period
    shown = time <= time[0] + seconds
    measured = estimate.y[shown]
    reconstructed = measured - estimate.residuals[shown]
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    upper.plot(time[shown], measured, color=_MEASURED, linewidth=2.4, label="measured")
    upper.plot(
        time[shown], reconstructed, color=_RECONSTRUCTED, linewidth=1.0, label="reconstructed"
    )
    lower.plot(time[shown], estimate.residuals[shown], color=_ERROR, linewidth=1.0, label="error")
    largest = 1.1 * max(abs(measured).max(), abs(reconstructed).max())
    for axes in (upper, lower):
        axes.set_ylim(-largest, largest)
        axes.set_ylabel(f"force [{unit}]")
        axes.grid(visible=True, color="#e3e5e8", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    upper.legend(loc="upper right", ncols=2, frameon=False)
    lower.legend(loc="upper right", frameon=False)
    lower.set_xlabel("time [s]")
    upper.set_title(f"{title}: equation error {estimate.equation_error_percent:.1f} %", loc="left")
    _save(figure, path)


def sweep_figure(result: Sweep, path: Path) -> None:
    """Draw every parameter over the cut-off: least squares and instruments, with 95 % bands.

    Parameters
    ----------
    result : Sweep
    path : Path
        Written whole or not at all; the suffix chooses the format.
    """
    quantities = result.results[0].axis.parameters
    styles = {
        "idm-ls": (_ERROR, "IDM-LS"),
        "idm-iv": (_RECONSTRUCTED, "IDM-IV"),
        "ddm-ls": (_MEASURED, "DDM-LS"),
    }
    figure = Figure(figsize=(8.0, 1.2 + 1.9 * len(quantities)), layout="constrained")
    rows = figure.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    for axes, quantity in zip(rows, quantities, strict=True):
        for method, (color, label) in styles.items():
            points = [
                (cutoff, estimate.parameters[quantity.name])
                for cutoff, estimate in zip(result.cutoffs, result.estimates(method), strict=True)
                if estimate is not None
            ]
            if not points:
                continue
            cutoffs = [cutoff for cutoff, _ in points]
            low, high = zip(*(value.interval for _, value in points), strict=True)
            axes.fill_between(cutoffs, low, high, color=color, alpha=0.15, linewidth=0)
            values = [value.value for _, value in points]
            axes.plot(cutoffs, values, "o-", color=color, markersize=3, linewidth=1.2, label=label)
        axes.axvline(result.recommended, color="#6b7280", linewidth=0.8, linestyle="--")
        axes.set_ylabel(f"{quantity.name} [{quantity.unit}]")
        axes.grid(visible=True, color="#e3e5e8", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[0].legend(loc="best", ncols=3, frameon=False)
    rows[0].set_title(f"recommended cut-off {result.recommended:g} Hz (dashed)", loc="left")
    rows[-1].set_xscale("log")
    first, last = result.cutoffs[0], result.cutoffs[-1]
    ticks = [m * 10.0**e for e in range(-2, 6) for m in (1, 2, 5) if first <= m * 10.0**e <= last]
    rows[-1].set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    rows[-1].set_xticks([], minor=True)
    rows[-1].set_xlabel("cut-off [Hz]")
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=path.suffix)
    os.close(handle)
    try:
        figure.savefig(temporary, dpi=150, metadata={"Software": "axisid"})
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
