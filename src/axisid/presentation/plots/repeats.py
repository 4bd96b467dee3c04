"""The figure of what is left again each time that the reference repeats."""

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.moves import LackOfFit, lack_of_fit
from axisid.support.missing import Missing

from .estimate import left_unit
from .plot import TITLES, Panel, Plot, Series, broken, labelled

_GAP = 1.5  # rows
_WIDE = 2.0  # standard deviations of the mean


def repeats_plot(result: Identification, estimate: Estimate) -> Plot | Missing:
    """Mean residual of an estimate over a period of the reference, with what noise makes of it."""
    judged = estimate is result.preferred
    found = result.diagnosis.lack_of_fit if judged else lack_of_fit(estimate, result.data)
    if found is None:
        return Missing("the record's reference does not repeat, or is not in it")
    return mean_residual_plot(
        found, estimate.method, left_unit(estimate), estimate.row_period, left=estimate.form.left
    )


def mean_residual_plot(
    found: LackOfFit, method: str, unit: str, row_period: float, *, left: str
) -> Plot:
    """The same from what was found.

    Parameters
    ----------
    found : LackOfFit
    method : str
        Of the estimate.
    unit, left : str
        Of what is on the left of its regression; the unit is empty where it is not known.
    row_period : float
        Time from row to row, s.
    """
    reach = _WIDE * found.noise / np.sqrt(found.count)
    named = f" {unit}" if unit else ""
    when = "a period" if found.period is None else f"the period of {found.period:.4g} s"
    plot = Plot(
        name="repeats",
        title=TITLES["repeats"],
        caption=f"{method.upper()}: the mean over up to {found.times} repeats, less what the "
        f"filter itself leaves, where each phase of {when} is first. What stands out of the band, "
        f"where noise of {found.noise:.2g}{named} leaves 95 % of the means, is the model's: "
        f"{100 * max(found.share, 0.0):.0f} % of the power.",
        x_label="time [s]",
        panels=(
            Panel(
                label=labelled(f"mean residual of the {left}", unit),
                series=(
                    Series(label="mean residual", x=found.time, y=found.mean, tone="error"),
                    Series(
                        label="noise alone",
                        x=found.time,
                        y=np.zeros(len(found.time)),
                        low=-reach,
                        high=reach,
                        tone="other",
                    ),
                ),
            ),
        ),
    )
    apart = np.diff(found.time) > _GAP * row_period
    return broken(plot, list(found.time[:-1][apart] + row_period / 2))
