"""The verdict: what was checked, against what, and what it means for the user.

No check passes silently: one that could not be made says so. None is a universal gate; each names
where its threshold comes from.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.estimates import CURVED, Estimate
from axisid.estimation.signals import rests_first

from .alignment import Alignment
from .check import Check, passed
from .control_law import GOOD_RESIDUAL, LawCheck
from .excitation import Excitation
from .filter_bias import filter_bias
from .instruments import (
    COVERED,
    NOTICED,
    SIGNIFICANT,
    STRONG_F,
    Endogeneity,
    InstrumentTests,
    biased_parameters,
)
from .motion import conditioning, precision, within_bounds
from .residuals import residual_checks
from .simulation import following, rest_check

_SELF_TEST = 1e-6
_ALIGNED = 0.35  # samples; what rounding by the filter may look like is up to 0.15
_TOLD = 0.5  # samples, one deviation


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
    reversals: str | None,
    rest: float,
) -> tuple[Check, ...]:
    """Hold what was measured of a result against thresholds; see `Diagnosis`."""
    ls, iv = estimates.get("idm-ls"), estimates.get("idm-iv")
    direct = estimates.get("ddm-iv")
    strength = _strength(judged, instruments)
    compared = _ls_against_iv(ls, iv, tested, strength)
    return (
        _control_law(law),
        strength,
        compared,
        _self_test(iv, direct),
        conditioning(judged.X),
        precision(judged, moved),
        within_bounds(judged, rests_first(rest)),
        _delta_method(direct or estimates.get("ddm-ls")),
        rest_check(rest, sticks=judged.form.axis.has_direction),
        following(judged, rest),
        *residual_checks(judged, judged.residual_tests),
        filter_bias(judged, reversals),
        _alignment(judged, alignment, hold, strength),
    )


def _control_law(law: LawCheck | str) -> Check:
    if isinstance(law, str):
        return Check.missing("control law", law)
    return Check(
        name="control law",
        status=passed(law.passed),
        figure=law.residual_percent,
        threshold=GOOD_RESIDUAL,
        source="residual in percent of the recorded control, 0.24 on the EMPS record; fails too "
        "where a factor is off 1 by more than 1 % and three deviations, for a delay, and for a "
        "sampling period that is more than 0.05 % from the law's",
        meaning=law.meaning,
    )


def _strength(iv: Estimate, tests: InstrumentTests | None) -> Check:
    if tests is None:
        return Check.missing("instrument strength", "no method with instruments gave an estimate")
    names = [q.expression or q.name for q in iv.form.quantities]
    weakest = min(range(len(names)), key=lambda j: tests.columns[j].conditional_f)
    f = tests.weakest
    strong = f >= STRONG_F
    return Check(
        name="instrument strength",
        status=passed(strong),
        figure=f if np.isfinite(f) else None,
        threshold=STRONG_F,
        source="first-stage F of 10, the rule of Staiger and Stock (1997); conditional on the "
        "other columns as in Sanderson and Windmeijer (2016)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else f"the simulated loop hardly explains the column of {names[weakest]}: its estimate "
        "cannot be believed",
    )


def _ls_against_iv(
    ls: Estimate | None, iv: Estimate | None, tested: Endogeneity | None, strength: Check
) -> Check:
    name = "least squares against instruments"
    if ls is None or iv is None:
        return Check.missing(name, "idm-ls and idm-iv did not both give an estimate")
    if strength.status == "fail":
        return Check.missing(name, "the instruments are too weak to tell")
    apart = np.abs(ls.physical - iv.physical) / np.sqrt(np.diag(iv.covariance))
    biased, by_rule = biased_parameters(ls, iv, tested), bool(apart.max() > COVERED)
    percent = np.array(
        [100 * abs(ls.parameters[n].value / iv.parameters[n].value - 1) for n in biased] or [0.0]
    )
    moved = ", ".join(
        f"{name} by {100 * (low.value / high.value - 1):+.3g} %"
        for name, low, high in ((n, ls.parameters[n], iv.parameters[n]) for n in biased)
    )
    return Check(
        name=name,
        status=passed(not biased),
        figure=float(apart.max()) if by_rule or not biased else float(percent.max()),
        threshold=COVERED if by_rule or not biased else 100 * NOTICED,
        p_value=None if tested is None else tested.p_value,
        source="largest difference in i.i.d. deviations of the instrumental estimate, at most 3 as "
        "in the paper; fails too where Durbin-Wu-Hausman (regression form, the p-value) "
        "rejects at 1 % and a parameter differs by more than 10 %, which is then the figure",
        meaning=f"least squares differs from the instruments, {moved}: lower the cut-off, or "
        "believe the instruments"
        if biased
        else "least squares and instruments differ by less than the rules allow; a bias below "
        f"{_unseen(iv):.2g} % would not be seen{_rejected(tested)}",
    )


def _rejected(tested: Endogeneity | None) -> str:
    """What the test alone says; with little noise in the equation it rejects for any bias."""
    if tested is None or tested.p_value >= SIGNIFICANT:
        return ""
    said = f"Durbin-Wu-Hausman rejects (p = {tested.p_value:.1g})"
    return f". {said}: there is a bias, too small to matter"


def _unseen(iv: Estimate) -> float:
    """Percent of bias that both rules would let pass, on the parameter known best."""
    relative = min(v.sd / abs(v.value) for v in iv.parameters.values() if v.value)
    return 100 * min(COVERED * relative, NOTICED)


def _self_test(iv: Estimate | None, direct: Estimate | None) -> Check:
    if iv is None or direct is None:
        return Check.missing("self-test", "idm-iv and ddm-iv did not both give an estimate")
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


def _alignment(judged: Estimate, profile: Alignment | str, hold: str, strength: Check) -> Check:
    if isinstance(profile, str):
        return Check.missing("alignment", profile)
    if strength.status == "fail":
        return Check.missing("alignment", "the instruments are too weak to measure a delay")
    used = 0.5 if hold == "zoh" else 0.0
    apart = profile.best - used
    if profile.deviation > _TOLD:
        return Check.missing(
            "alignment",
            f"the record tells the force's delay to +-{profile.deviation:.2g} samples only, which "
            "is no more than a guess",
        )
    moved = ", ".join(
        f"{p.name} by {slope:+.2g} {p.unit}"
        for p, slope in zip(judged.quantities, profile.sensitivity, strict=True)
    )
    by_ls = "" if profile.by_instruments else " (by least squares, which noise may bias)"
    fits = (
        f"the force fits the motion best {_delay(profile)} earlier than it is recorded; "
        f"hold {hold} takes it {used:g} samples earlier{by_ls}"
    )
    aligned = abs(apart) <= max(_ALIGNED, 2 * profile.deviation) and not profile.at_the_end
    return Check(
        name="alignment",
        status=passed(aligned),
        figure=apart,
        threshold=_ALIGNED,
        source="samples between the delay of least equation error and the one that is used, unless "
        "two deviations of it are more; a drive that holds its force is half a sample late",
        meaning=fits
        if aligned
        else f"{fits}.{_other_hold(profile, hold)} A sample of delay moves {moved}",
    )


def _other_hold(profile: Alignment, hold: str) -> str:
    """The other hold, where the delay is its own."""
    other, own = ("zoh", 0.5) if hold == "raw" else ("raw", 0.0)
    return f" Try --hold {other}." if abs(profile.best - own) <= _ALIGNED else ""


def _delay(profile: Alignment) -> str:
    if profile.at_the_end:
        return f"{profile.best:g} samples, the end of the range that was tried, or more"
    return f"{profile.best:.2f} +- {profile.deviation:.2g} samples"
