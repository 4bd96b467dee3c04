"""Whether the simulated loop does what was recorded, as a check."""

from .check import Check, passed
from .estimate import FOLLOWING, Estimate

NAME = "simulation"
_CLOSELY = 10.0  # percent
_CAUSES = (
    "check the law, signs and units, or see whether the record is noise, or a motion that the "
    "model does not have"
)
_MOSTLY = 0.3  # of the samples that the fit has


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


def rests_first(rest: float) -> str:
    """What to say of a fit that is mostly of an axis at rest; empty for another."""
    if rest <= _MOSTLY:
        return ""
    return (
        f"the axis rests in {100 * rest:.0f} % of the samples that the fit has, where sticking "
        "friction takes any force and no model gives it: leave the rests out (--reversals "
        "leave-out), then check the law, signs and units"
    )
