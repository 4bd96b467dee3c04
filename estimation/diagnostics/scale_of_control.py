"""Effect of a wrong scale of the recorded control on the parameters.

A control that is recorded too large makes the force too large by the same factor. The check of the
control law accepts a factor within 1 % of the declared one, which can change a parameter by far
more than its confidence interval. Where the record cannot distinguish a wrong scale from wrong
gains of the law, a wrong scale is assumed.
"""

from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.findings import Finding
from axisid.estimation.regression import InverseForm
from axisid.estimation.thresholds import MAX_LAW_MOVE, MIN_DISTANCE_FROM_NOISE
from axisid.estimation.verdict_checks import Check
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .control_law import SCALE, LawAgreement, law_check
from .diagnostic_inputs import DiagnosticInputs


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlScaleMoves(Finding):
    """A parameter that is wrong if the recorded control has another scale.

    Attributes
    ----------
    finding : Finding
        Finding of the comparison with the declared law, which the control follows.
    scale : float
        Factor by which the recorded control may be too large.
    parameter : str
        Name of the parameter.
    change : float
        Change of the parameter by that factor, in `unit`.
    unit : str
        Unit of the parameter.
    standard_errors : float
        The change, in joint standard errors of the parameter and of the change.
    """

    finding: Finding
    scale: float
    parameter: str
    change: float
    unit: str
    standard_errors: float


def control_law_check(case: DiagnosticInputs) -> Check | Missing:
    """Return the check of the declared law against the recorded control.

    It fails where the control does not follow the law. It also fails where a wrong scale of the
    control, which the record does not exclude, changes a parameter too much. Missing where the law
    cannot be compared.
    """
    law = case.law
    check = case.if_used(law_check(law))
    if isinstance(check, Missing) or isinstance(law, Missing) or check.status == "fail":
        return check
    return _with_effect_of_scale(check, case, law)


def _with_effect_of_scale(check: Check, case: DiagnosticInputs, law: LawAgreement) -> Check:
    """Return the check of the law; failed if a wrong scale of the control matters.

    A wrong scale matters if it is significant and changes a parameter by more than `MAX_LAW_MOVE`
    standard errors. Otherwise the check is returned unchanged.

    Parameters
    ----------
    check : Check
        Check of the law, which has not failed.
    case : DiagnosticInputs
    law : LawAgreement
        Comparison of the law with the record.
    """
    # Scale of the control by the comparison, if it is a plausible explanation.
    by_scale = [each for each in law.plausible if each.kind[0] == SCALE]
    whole = case.whole or case
    joint = whole.problem.joint_form
    # An identified drive gain contains the scale, and is compared with the declared gain.
    absorbed = joint is not None and joint.gain is not None
    if not by_scale or absorbed or case.data.record.force is not None:
        return check
    share, deviation = by_scale[0].values[SCALE], by_scale[0].deviations[SCALE]
    if share < 0:
        # Noise and rounding in the inputs of the law make the control look too small. The relative
        # effect is at most the square of the part of the control that the law does not reproduce.
        share = min(share + (by_scale[0].left_percent / 100) ** 2, 0.0)
    if abs(share) <= MIN_DISTANCE_FROM_NOISE.value * deviation:
        return check
    # Change of each parameter by the scale, in standard errors of the parameter and of the change.
    judged = whole.preferred.parameters
    shifts: dict[str, float] = {}
    moves = dict(zip(judged, _moved_by_scale(case, share).tolist(), strict=True))
    for name, value in judged.items():
        standard_error = np.hypot(value.deviation, moves[name] * deviation / share)
        if value.deviation > 0 and np.isfinite(standard_error):
            shifts[name] = float(abs(moves[name]) / standard_error)
    worst = max(shifts, key=lambda name: shifts[name], default="")
    if not worst or shifts[worst] <= MAX_LAW_MOVE.value:
        return check
    return replace(
        check,
        status="fail",
        figure=shifts[worst],
        threshold=MAX_LAW_MOVE.value,
        source="largest change of a parameter if the recorded control has another scale, in "
        "standard errors of the parameter and of the change. The threshold is measured: the change "
        "is at most 1.2 standard errors on 120 correct twins with a fit of the position",
        finding=ControlScaleMoves(
            finding=check.finding,
            scale=float(1 + share),
            parameter=worst,
            change=moves[worst],
            unit=judged[worst].unit,
            standard_errors=shifts[worst],
        ),
    )


def _moved_by_scale(case: DiagnosticInputs, share: float) -> Array:
    """Return the change of each parameter, (p,), if the control is ``1 + share`` times too large.

    In the rows of this record, the force F of the recorded control u differs from that of
    ``u / (1 + share)``. The parameters of all records change by the pseudo-inverse of the regressor
    X times this difference, ``X^+ (F(u) - F(u / (1 + share)))``.
    """
    whole, data = case.whole or case, case.data
    form = whole.problem.form(InverseForm).at(whole.preferred.physical)
    regressor = whole.problem.rows(form).regressor
    scaled = data.with_columns(control=np.asarray(data.record.control) / (1 + share))
    apart = np.zeros(len(regressor))
    apart[whole.problem.spans[case.number]] = data.reduce(data.signals.force - scaled.signals.force)
    apart *= whole.problem.row_weights
    return np.asarray(np.linalg.lstsq(regressor, apart, rcond=None)[0], dtype=float)
