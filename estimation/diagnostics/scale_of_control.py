"""Effect of a wrong scale of the recorded control on the parameters.

A control that is recorded too large makes the force too large by the same factor. The check of the
control law accepts a factor within 1 % of the declared one, which can move a parameter far beyond
its confidence interval. Where the record cannot tell a wrong scale from wrong gains of the law, a
wrong scale is assumed.
"""

from dataclasses import replace

import numpy as np

from axisid.estimation.estimation_problem import Problem
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
    per_share = _moves_per_share(case.problem, case.preferred.physical)
    deviations: dict[str, float] = {}
    for (name, value), move in zip(case.preferred.parameters.items(), per_share, strict=True):
        unsure = np.hypot(value.deviation, move * deviation)
        if value.deviation > 0 and np.isfinite(unsure):
            deviations[name] = float(abs(move * share) / unsure)
    if not deviations:
        return check
    name = max(deviations, key=lambda each: deviations[each])
    if deviations[name] <= MAX_LAW_MOVE.value:
        return check
    moved = share * per_share[list(case.preferred.parameters).index(name)]
    unit = case.preferred.parameters[name].unit
    return replace(
        check,
        status="fail",
        figure=deviations[name],
        threshold=MAX_LAW_MOVE.value,
        source=MAX_LAW_MOVE.source,
        meaning=f"{check.meaning}; but it may be recorded {1 + share:.5g} times as large as it is, "
        f"which moves {name} by {moved:+.2g} {unit} ({deviations[name]:.2g} standard errors). "
        "Check the scale of the control and the gains of the law",
    )


def _moves_per_share(problem: Problem, physical: Array) -> Array:
    """Return the change of each parameter for a control recorded twice as large, to first order.

    The force ``F = phi theta + c`` grows by F itself, and its known part c does not grow in the
    model, so that the parameters move by ``phi^+ (phi theta + c)``: by theta where no part of the
    force is known.
    """
    rows = problem.rows(problem.form(InverseForm).at(physical))
    force = rows.predicted(physical)
    return np.asarray(np.linalg.lstsq(rows.regressor, force, rcond=None)[0], dtype=float)
