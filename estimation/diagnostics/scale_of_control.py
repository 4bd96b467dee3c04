"""What the scale of the recorded control moves, where the control law shows that it is off.

A control that is recorded too large makes all parameters of the force too large by as much. The
check of the control law passes a factor that is within 1 % of the declared one. That may be far
beyond the interval of a parameter, and where the record cannot tell whether the scale or the gains
of the law are off, the scale counts.
"""

from dataclasses import replace

import numpy as np

from axisid.estimation.verdict_checks import Check
from axisid.support.errors import Missing

from .control_law import SCALE, LawAgreement, law_check
from .diagnostic_inputs import DiagnosticInputs

# Deviations, that of the scale included. Fits allow as much: at most 1.2 on 120 right twins.
_MAX_MOVE = 2.0


def control_law_check(case: DiagnosticInputs) -> Check | Missing:
    """The declared law against the recorded control, by its residual and by what it moves."""
    law = case.law
    check = case.if_used(law_check(law))
    if isinstance(check, Missing) or isinstance(law, Missing) or check.status == "fail":
        return check
    moved = _moved_by_scale(case, law)
    if moved is None:
        return check
    return replace(check, status="fail", meaning=f"{check.meaning}; but {moved}")


def _moved_by_scale(case: DiagnosticInputs, law: LawAgreement) -> str | None:
    """The parameter that the control's scale moves furthest, in words, if that is too far."""
    if case.data.record.force is not None:
        return None
    shown = [each for each in law.plausible if each.kind[0] == SCALE]
    if not shown:
        return None
    share, deviation = shown[0].values[SCALE], shown[0].deviations[SCALE]
    axis = case.data.axis
    linear = {
        p.name for p, bends in zip(axis.axis.parameters, axis.nonlinear, strict=True) if not bends
    }
    found: dict[str, float] = {}
    for name, value in case.preferred.parameters.items():
        if name in linear and value.deviation > 0:
            unsure = np.hypot(value.deviation, value.corrected * deviation)
            if np.isfinite(unsure):
                found[name] = abs(float(value.corrected * share / unsure))
    name = max(found, key=lambda each: found[each], default="")
    if not name or found[name] <= _MAX_MOVE:
        return None
    return (
        f"it may be recorded {1 + share:.5g} times as large as it is, which moves {name} by "
        f"{100 * abs(share):.2g} % ({found[name]:.2g} deviations). Check the scale of the control "
        "and the gains of the law"
    )
