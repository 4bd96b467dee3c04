"""Figures of a fit of a simulated output."""

from axisid.estimation.fitting import OutputFit
from axisid.estimation.predictions import measured_output

from .plot import Panel, Plot, Series, labelled, line


def output_plot(fit: OutputFit, record: int = 0) -> Plot:
    """Recorded and simulated output of one record, from 0, and their difference."""
    own = fit.records[record]
    measured = measured_output(fit.output, fit.axis, own).values
    rows = fit.samples[record]
    time, errors = own.time[rows], fit.errors[record]
    recorded = measured[rows]
    each = fit.of_records[record]
    return Plot(
        name="output",
        title="Output, recorded and simulated",
        caption=f"The {fit.output} that is simulated with the fit leaves {each.error:.3g} "
        f"{fit.unit} (rms), {each.percent:.3g} % of the recorded one.",
        x_label="time [s]",
        panels=(
            Panel(
                label=labelled(fit.output, fit.unit),
                series=(
                    line("recorded", time, recorded, "measured"),
                    Series(label="simulated", x=time, y=recorded + errors, broad=True),
                ),
            ),
            Panel(
                label=labelled("difference", fit.unit), series=(line("", time, errors, "error"),)
            ),
        ),
    )
