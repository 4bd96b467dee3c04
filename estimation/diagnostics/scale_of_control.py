"""Effect of a wrong scale of the recorded control on the parameters.

A control that is recorded too large makes the force too large by the same factor. The check of the
control law accepts a factor within 1 % of the declared one, which can move a parameter far beyond
its confidence interval. Where the record cannot tell a wrong scale from wrong gains of the law, a
wrong scale is assumed.
"""

from dataclasses import replace

import numpy as np

from axisid.estimation.regression import InverseForm
from axisid.estimation.thresholds import MAX_LAW_MOVE
from axisid.estimation.verdict_checks import Check
from axisid.support.arrays import Array
from axisid.support.errors import Missing

from .control_law import SCALE, LawAgreement, law_check
from .diagnostic_inputs import DiagnosticInputs


def control_law_check(case: DiagnosticInputs) -> Check | Missing:
    """Compare the declared law with the recorded control, by residual and effect of its scale."""
    law = case.law
    check = case.if_used(law_check(law))
    if isinstance(check, Missing) or isinstance(law, Missing) or check.status == "fail":
        return check
    return _with_effect_of_scale(check, case, law)


def _with_effect_of_scale(check: Check, case: DiagnosticInputs, law: LawAgreement) -> Check:
    """Fail a passed check where the control's scale moves a parameter too far."""
    shown = [each for each in law.plausible if each.kind[0] == SCALE]
    if not shown or case.data.record.force is not None:
        return check
    share, deviation = shown[0].values[SCALE], shown[0].deviations[SCALE]
    # Noise and rounding in what the law reads make the control look smaller than the law's, by as
    # much at most as the square of the part that the law does not reproduce.
    dilution = (shown[0].left_percent / 100) ** 2
    certain = max(abs(share) - dilution, 0.0) / abs(share)
    moves = _moved_by_scale(case, share)
    shifts: dict[str, float] = {}
    for (name, value), move in zip(case.preferred.parameters.items(), moves, strict=True):
        unsure = np.hypot(value.deviation, move * deviation / share)
        if value.deviation > 0 and np.isfinite(unsure):
            shifts[name] = float(certain * abs(move) / unsure)
    worst = max(shifts, key=lambda name: shifts[name], default="")
    if not worst or shifts[worst] <= MAX_LAW_MOVE.value:
        return check
    move = moves[[*case.preferred.parameters].index(worst)]
    unit = case.preferred.parameters[worst].unit
    return replace(
        check,
        status="fail",
        figure=shifts[worst],
        threshold=MAX_LAW_MOVE.value,
        source=MAX_LAW_MOVE.source,
        meaning=f"{check.meaning}; but it may be recorded {1 + share:.5g} times as large as it is, "
        f"which moves {worst} by {move:+.2g} {unit} ({shifts[worst]:.2g} standard errors). Check "
        "the scale of the control and the gains of the law",
    )


def _moved_by_scale(case: DiagnosticInputs, share: float) -> Array:
    """Return the change of each parameter, (p,), where the control is 1 + share times too large.

    The force F of the recorded control u and that of ``u / (1 + share)`` differ by what the drive
    makes of the difference, and the parameters by ``X^+ (F(u) - F(u / (1 + share)))``.
    """
    data, control = case.data, case.data.acting_control
    form = case.problem.form(InverseForm).at(case.preferred.physical)
    regressor = case.problem.rows(form).regressor
    if control is None:
        return np.zeros(regressor.shape[1])
    lost = data.reduce(data.force_by(control / (1 + share) - control))
    return np.asarray(np.linalg.lstsq(regressor, -lost, rcond=None)[0], dtype=float)
