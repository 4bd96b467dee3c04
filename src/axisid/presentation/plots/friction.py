"""The friction curve as a figure."""

from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.studies import Friction, friction
from axisid.support.missing import Missing

from .plot import TITLES, Panel, Plot, Series, labelled, line

_NAME = "friction"


def friction_plot(result: Identification, estimate: Estimate) -> Plot | Missing:
    """The fitted law over the binned measurement."""
    found = friction(result, estimate)
    if isinstance(found, Missing):
        return found
    q = result.axis.axis.coordinate
    v, mean, spread = found.binned.T
    return Plot(
        name=_NAME,
        title=TITLES[_NAME],
        caption=f"The recorded force less the model's parts without velocity, by "
        f"{estimate.method.upper()}: its rows, their mean and standard deviation by bins of "
        "velocity, and the fitted law. Bins that leave the law together show friction that the "
        f"law does not have.{_without(found)}",
        x_label=labelled("velocity", f"{q.unit}/s"),
        panels=(
            Panel(
                label=labelled("friction", str(q.force_unit)),
                series=(
                    Series(
                        label="rows",
                        x=found.velocity,
                        y=found.force,
                        kind="points",
                        tone="measured",
                        broad=True,
                    ),
                    line("fitted law", *found.law.T),
                    Series(
                        label="mean and deviation by bin",
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


def _without(found: Friction) -> str:
    if not found.skipped:
        return ""
    return (
        f" Without {found.skipped} rows by the reversals, rests and ends that the fit leaves out."
    )
