"""Whether the axis moved, and the simulated loop with it, as checks."""

from axisid.estimation.estimates import FOLLOWING, Estimate
from axisid.estimation.signals import MOST_REST, rests_first

from .check import Check, passed

NAME = "simulation"
_CLOSELY = 10.0  # percent
_CAUSES = (
    "check the law, signs and units, or see whether the record is noise, or a motion that the "
    "model does not have"
)


def rest_check(rest: float, *, sticks: bool) -> Check:
    """Whether the fit has rests of an axis that sticks; `rest` is their part of its samples."""
    said = rests_first(rest) if sticks else ""
    return Check(
        name="rests",
        status=passed(not said),
        figure=100 * rest,
        threshold=100 * MOST_REST,
        source="percent of the samples that the fit has at which an axis with friction stands "
        "still; an eighth moves friction by a tenth, a third by most of it",
        meaning=said or "the fit is of an axis in motion",
    )


def following(judged: Estimate, rest: float) -> Check:
    """The simulation error of an estimate; `rest` is the part of its samples at which it stands."""
    error = judged.simulation_error_percent
    if error is None and judged.not_simulated:
        return Check(
            name=NAME,
            status="fail",
            source="an axis that was recorded can be simulated",
            meaning="the loop cannot be simulated with the estimate, as that of an axis that was "
            f"recorded can: {judged.not_simulated.removesuffix('.')}",
        )
    if error is None:
        return Check.missing(NAME, "the closed loop could not be simulated")
    good = error < FOLLOWING
    return Check(
        name=NAME,
        status=passed(good),
        figure=error,
        threshold=FOLLOWING,
        source="simulation error in percent of the left side; at 50 the loop explains three "
        "quarters of its power, at 100 nothing",
        meaning=_followed(error)
        if good
        else f"the simulated loop leaves {error:.3g} % of the {judged.form.left} unexplained; "
        f"{rests_first(rest) or _CAUSES}",
    )


def _followed(error: float) -> str:
    if error < _CLOSELY:
        return "the simulated loop follows the record"
    return f"the simulated loop follows the record but for {error:.2g} %"
