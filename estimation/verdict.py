"""The verdict: what was checked, against what, and what it means for the user.

No check passes silently: one that could not be made says so. None is a universal gate; each names
where its threshold comes from.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from .alignment import Alignment
from .check import Check, passed
from .estimate import CURVED, Estimate
from .excitation import Excitation
from .instruments import Endogeneity, InstrumentTests
from .law_check import GOOD_RESIDUAL, LawCheck
from .motion_checks import conditioning, precision
from .residual_checks import residual_checks

_STRONG_F = 10.0
_COVERED = 3.0  # deviations
_SELF_TEST = 1e-6
_FOLLOWING = 100.0  # percent
_ALIGNED = 0.25  # samples


def verdict(
    estimates: Mapping[str, Estimate],
    judged: Estimate,
    *,
    law: LawCheck | str,
    instruments: InstrumentTests | None,
    tested: Endogeneity | None,
    moved: Sequence[Excitation],
    alignment: Alignment | str,
    hold: str,
) -> tuple[Check, ...]:
    """Hold what was measured of a result against thresholds; see `Diagnosis`."""
    ls, iv = estimates.get("idm-ls"), estimates.get("idm-iv")
    direct = estimates.get("ddm-iv")
    compared = _ls_against_iv(ls, iv, tested)
    return (
        _control_law(law),
        _strength(judged, instruments),
        compared,
        _self_test(iv, direct),
        conditioning(judged.X),
        precision(judged, moved),
        _delta_method(direct or estimates.get("ddm-ls")),
        _following(judged),
        *residual_checks(judged, judged.residual_tests),
        _missing_alignment(compared) or _alignment(judged, alignment, hold),
    )


def _control_law(law: LawCheck | str) -> Check:
    if isinstance(law, str):
        return Check.missing("control law", law)
    return Check(
        name="control law",
        status=passed(law.passed),
        figure=law.residual_percent,
        threshold=GOOD_RESIDUAL,
        source="residual in percent of the recorded control; 0.24 on the EMPS record",
        meaning=law.meaning,
    )


def _strength(iv: Estimate, tests: InstrumentTests | None) -> Check:
    if tests is None:
        return Check.missing("instrument strength", "no method with instruments was run")
    names = [q.expression or q.name for q in iv.form.quantities]
    weakest = min(range(len(names)), key=lambda j: tests.columns[j].f)
    f = tests.columns[weakest].f
    strong = f >= _STRONG_F
    return Check(
        name="instrument strength",
        status=passed(strong),
        figure=f if np.isfinite(f) else None,
        threshold=_STRONG_F,
        source="first-stage F of 10, the rule of Staiger and Stock (1997)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else f"the simulated loop hardly explains the column of {names[weakest]}: its estimate "
        "cannot be believed",
    )


def _ls_against_iv(ls: Estimate | None, iv: Estimate | None, tested: Endogeneity | None) -> Check:
    name = "least squares against instruments"
    if ls is None or iv is None:
        return Check.missing(name, "idm-ls and idm-iv were not both run")
    deviations = np.sqrt(np.diag(iv.covariance))
    apart = np.abs(ls.physical - iv.physical) / deviations
    biased = [q.name for q, a in zip(iv.quantities, apart, strict=True) if a > _COVERED]
    return Check(
        name=name,
        status=passed(not biased),
        figure=float(apart.max()),
        threshold=_COVERED,
        p_value=None if tested is None else tested.p_value,
        source="difference in i.i.d. deviations of the instrumental estimate, as in the paper; "
        "p-value: Durbin-Wu-Hausman in regression form, HAC, which noise in the regressor alone "
        "makes small",
        meaning=f"least squares is biased on {', '.join(biased)}: lower the cut-off, or believe "
        "the instruments"
        if biased
        else "least squares and instruments agree within their deviations",
    )


def _self_test(iv: Estimate | None, direct: Estimate | None) -> Check:
    if iv is None or direct is None:
        return Check.missing("self-test", "idm-iv and ddm-iv were not both run")
    scale = np.maximum(np.abs(iv.physical), np.sqrt(np.diag(iv.covariance)))
    apart = float(np.max(np.abs(iv.physical - direct.physical) / np.where(scale > 0, scale, 1.0)))
    same = apart <= _SELF_TEST
    return Check(
        name="self-test",
        status=passed(same),
        figure=apart,
        threshold=_SELF_TEST,
        source="algebraic identity of the two",
        meaning="idm-iv and ddm-iv are the same estimate"
        if same
        else "idm-iv and ddm-iv differ, which they cannot if the loop satisfies the model",
    )


def _delta_method(direct: Estimate | None) -> Check:
    if direct is None:
        return Check.missing("delta method", "no direct model was regressed")
    curvatures = direct.curvatures
    worst = float(curvatures.max())
    straight = worst <= CURVED
    bent = [n for n, c in zip(direct.parameters, curvatures, strict=True) if c > CURVED]
    return Check(
        name="delta method",
        status=passed(straight),
        figure=worst if np.isfinite(worst) else None,
        threshold=CURVED,
        source="second-order part of a mapped parameter's deviation against the first",
        meaning="the map to the physical parameters is straight within the uncertainty"
        if straight
        else f"the map from the direct model to {', '.join(bent)} bends within the uncertainty: "
        "take intervals from draws (--draws 10000, or propagate() in Python)",
    )


def _following(estimate: Estimate) -> Check:
    error = estimate.simulation_error_percent
    if error is None:
        return Check.missing("simulation", "the closed loop could not be simulated")
    good = error < _FOLLOWING
    return Check(
        name="simulation",
        status=passed(good),
        figure=error,
        threshold=_FOLLOWING,
        source="simulation error in percent of the left side; at 100 the loop says nothing of it",
        meaning="the simulated loop follows the record"
        if good
        else "the simulated loop does not follow the record; check the law, signs and units",
    )


def _missing_alignment(compared: Check) -> Check | None:
    if compared.status != "fail":
        return None
    return Check.missing("alignment", "noise biases least squares, by which the delay is measured")


def _alignment(judged: Estimate, profile: Alignment | str, hold: str) -> Check:
    if isinstance(profile, str):
        return Check.missing("alignment", profile)
    used = 0.5 if hold == "zoh" else 0.0
    apart = profile.best - used
    moved = ", ".join(
        f"{p.name} by {slope:+.2g} {p.unit}"
        for p, slope in zip(judged.quantities, profile.sensitivity, strict=True)
    )
    fits = (
        f"the force fits the motion best {profile.best:.2f} samples earlier than it is recorded; "
        f"hold {hold} takes it {used:g} samples earlier"
    )
    aligned = abs(apart) <= _ALIGNED
    return Check(
        name="alignment",
        status=passed(aligned),
        figure=apart,
        threshold=_ALIGNED,
        source="samples between the delay of least equation error and the one that is used; a "
        "drive that holds its force is half a sample late",
        meaning=fits if aligned else f"{fits}. A sample of delay moves {moved}",
    )
