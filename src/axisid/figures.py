"""Figures. Matplotlib is imported here, and this module only where a figure is drawn."""

import os
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from axisid.estimation import Estimate

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
