"""Whether a parameter changes while the record runs, as a check."""

from collections.abc import Sequence

from axisid.estimation.estimates import Estimate
from axisid.estimation.thresholds.diagnostics import NEGLIGIBLE_FORCE
from axisid.support.missing import Missing

from .check import Check, passed
from .lacking import Lack
from .missing_terms import SOURCE

_NAME = "changes in time"


def changes_in_time(found: Sequence[Lack] | Missing, preferred: Estimate) -> Check | Missing:
    """Whether a parameter is another from some time on, or drifts over the record."""
    if isinstance(found, Missing):
        return found
    changes = [lack for lack in found if lack.parameter]
    return Check(
        name=_NAME,
        status=passed(not changes),
        figure=100 * max((lack.share for lack in changes), default=0.0),
        threshold=100 * NEGLIGIBLE_FORCE.value,
        p_value=min((lack.p_value for lack in changes), default=None),
        source=f"{SOURCE}; of a change, the largest of the statistics over all times (Andrews)",
        meaning="; ".join(_said(lack, preferred) for lack in changes)
        or "no parameter changes while the record runs",
    )


def _said(lack: Lack, preferred: Estimate) -> str:
    unit = next(q.unit for q in preferred.quantities if q.name == lack.parameter)
    by = f"{lack.values[0]:+.3g} +- {lack.deviations[0]:.1g} {unit}"
    share = f" ({100 * lack.values[0] / lack.before:+.2g} %)" if lack.before else ""
    if lack.kind == "drift":
        return (
            f"{lack.parameter} changes by {by}{share} over the record, little by little: record "
            "when the axis is warm, or identify parts of the record by themselves"
        )
    return (
        f"{lack.parameter} changes by {by}{share} at about {lack.at:.3g} s: identify what is "
        "before and after by itself, or find what was changed there"
    )
