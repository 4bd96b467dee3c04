"""Figures of a fit of a simulated output."""

from axisid.estimation.fitting import OutputFit
from axisid.estimation.predictions import measured_output

from .plot import Panel, Plot, Series, labelled, line


def output_plot(fit: OutputFit, record: int = 0) -> Plot:
    """Recorded and simulated outputs of one record, from 0, and their difference."""
    count = len(fit.outputs)
    of_record = fit.of_records[record * count : (record + 1) * count]
    left = " and ".join(f"{e.error:.3g} {e.unit} (rms), {e.percent:.3g} %" for e in of_record)
    return Plot(
        name="output",
        title="Output, recorded and simulated",
        caption=_caption(fit, left),
        x_label="time [s]",
        panels=tuple(panel for place in range(count) for panel in _panels(fit, record, place)),
    )


def _caption(fit: OutputFit, left: str) -> str:
    if len(fit.outputs) > 1:
        return f"Simulated with the fit, {fit.output} leave {left} of the recorded ones."
    return f"The {fit.output} that is simulated with the fit leaves {left} of the recorded one."


def _panels(fit: OutputFit, record: int, place: int) -> tuple[Panel, Panel]:
    """Of one output."""
    own, rows = fit.records[record], fit.samples[record]
    output, unit = fit.outputs[place], fit.units[place]
    recorded = measured_output(output, fit.axis, own).values[rows]
    time, errors = own.time[rows], fit.errors[record].reshape(len(rows), -1)[:, place]
    return (
        Panel(
            label=labelled(output, unit),
            series=(
                line("recorded", time, recorded, "measured"),
                Series(label="simulated", x=time, y=recorded + errors, broad=True),
            ),
        ),
        Panel(label=labelled("difference", unit), series=(line("", time, errors, "error"),)),
    )
