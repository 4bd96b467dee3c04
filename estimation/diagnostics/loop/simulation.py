"""Whether the simulated loop follows the record, as a check."""

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.signals import rests_first
from axisid.estimation.thresholds import MAX_SIMULATION_ERROR
from axisid.support.missing import Missing
from axisid.support.remedy import Note

_MAX_CLOSE_SIMULATION_ERROR = 10.0  # %, below which nothing is said of the simulation

NAME = "simulation"


def following(preferred: Estimate, rest: float) -> Check | Missing:
    """The simulation error of an estimate; `rest` is the part of its samples at which it stands."""
    error, simulated = preferred.simulation_error_percent, preferred.simulated
    if isinstance(simulated, NotSimulated) and simulated.by_estimate:
        return Check(
            name=NAME,
            status="fail",
            source="an axis that was recorded can be simulated",
            meaning="the loop cannot be simulated with the estimate, as that of an axis that was "
            f"recorded can: {str(simulated).removesuffix('.')}",
        )
    if isinstance(simulated, NotSimulated):
        return simulated
    if error is None:
        return Missing("the closed loop could not be simulated")
    good = error < MAX_SIMULATION_ERROR.value
    close = error < _MAX_CLOSE_SIMULATION_ERROR
    said = Note("the simulated loop follows the record" + f" but for {error:.2g} %" * (not close))
    if not good:
        form, chains = preferred.form, preferred.inference.chains  # of one record
        units = form.axis.axis.coordinate.unit, form.axis.axis.drive.unit
        noise = "".join(f" ({chain.told(*units)})" for chain in chains[:1])
        said = Note.of(
            f"the simulated loop leaves {error:.3g} % of the {form.left} unexplained; ",
            rests_first(rest)
            or f"check the law, signs and units, or see whether the record is noise{noise}, or a "
            "motion that the model does not have",
        )
    return Check(
        name=NAME,
        status=passed(good),
        figure=error,
        threshold=MAX_SIMULATION_ERROR.value,
        source="simulation error in percent of the left side; at 50 the loop explains three "
        "quarters of its power, at 100 nothing",
        meaning=said.text,
        remedy=said.remedy,
    )
