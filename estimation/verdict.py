"""The verdict: what was checked, against what, and what it means for the user.

No check passes silently: one that could not be made says so. None is a universal gate; each names
where its threshold comes from.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from axisid.codegen import GeneratedAxis

from .alignment import profile_alignment
from .covariance import Hac
from .diagnostics import endogeneity, instrument_strength, residual_tests
from .errors import DataError, EstimationError
from .estimate import Estimate
from .law_check import GOOD_RESIDUAL, LawCheck
from .prefilter import Prefilter
from .record import Record

_STRONG_F = 10.0
_MOST_CONDITION = 100.0
_MOST_RELATIVE_SD = 30.0  # percent
_COVERED = 3.0  # deviations
_SIGNIFICANT = 0.05
_SELF_TEST = 1e-6
_FOLLOWING = 100.0  # percent
_ALIGNED = 0.25  # samples


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One check of a result.

    Attributes
    ----------
    name : str
    status : {"pass", "fail", "not evaluated"}
    meaning : str
        One sentence for the user.
    figure : float or None
        What was measured.
    threshold : float or None
        What it is held against.
    p_value : float or None
    source : str
        Where the threshold comes from.
    """

    name: str
    status: Literal["pass", "fail", "not evaluated"]
    meaning: str
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""


def verdict(
    axis: GeneratedAxis,
    record: Record,
    prefilter: Prefilter,
    estimates: Mapping[str, Estimate],
    law: LawCheck | str,
) -> tuple[Check, ...]:
    """Check a result; each method is checked where it was run."""
    ls, iv = estimates.get("idm-ls"), estimates.get("idm-iv")
    direct = estimates.get("ddm-iv")
    shown = iv or direct or ls or next(iter(estimates.values()))
    compared = _ls_against_iv(ls, iv)
    return (
        _control_law(law),
        _strength(iv or direct),
        compared,
        _self_test(iv, direct),
        _excitation(shown),
        _precision(axis, shown),
        _following(shown),
        _autocorrelation(shown),
        _alignment(axis, record, prefilter, compared),
    )


def _missing(name: str, why: str) -> Check:
    return Check(name=name, status="not evaluated", meaning=why)


def _control_law(law: LawCheck | str) -> Check:
    if isinstance(law, str):
        return _missing("control law", law)
    return Check(
        name="control law",
        status="pass" if law.passed else "fail",
        figure=law.residual_percent,
        threshold=GOOD_RESIDUAL,
        source="residual in percent of the recorded control; 0.24 on the EMPS record",
        meaning=law.meaning,
    )


def _strength(iv: Estimate | None) -> Check:
    if iv is None or iv.Z is None:
        return _missing("instrument strength", "no method with instruments was run")
    strengths = instrument_strength(iv.X, iv.Z)
    names = [q.expression or q.name for q in iv.ddm_quantities or iv.quantities]
    weakest = min(range(len(names)), key=lambda j: strengths[j].f)
    f = strengths[weakest].f
    strong = f >= _STRONG_F
    return Check(
        name="instrument strength",
        status="pass" if strong else "fail",
        figure=f if np.isfinite(f) else None,
        threshold=_STRONG_F,
        source="first-stage F of 10, the rule of Staiger and Stock (1997)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else f"the simulated loop hardly explains the column of {names[weakest]}: its estimate "
        "cannot be believed",
    )


def _ls_against_iv(ls: Estimate | None, iv: Estimate | None) -> Check:
    name = "least squares against instruments"
    if ls is None or iv is None or iv.Z is None:
        return _missing(name, "idm-ls and idm-iv were not both run")
    deviations = np.sqrt(np.diag(iv.covariance))
    apart = np.abs(ls.physical - iv.physical) / deviations
    test = endogeneity(iv.X @ iv.physical + iv.residuals, iv.X, iv.Z, Hac())
    biased = [q.name for q, a in zip(iv.quantities, apart, strict=True) if a > _COVERED]
    return Check(
        name=name,
        status="fail" if biased else "pass",
        figure=float(apart.max()),
        threshold=_COVERED,
        p_value=test.p_value,
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
        return _missing("self-test", "idm-iv and ddm-iv were not both run")
    scale = np.maximum(np.abs(iv.physical), np.sqrt(np.diag(iv.covariance)))
    apart = float(np.max(np.abs(iv.physical - direct.physical) / np.where(scale > 0, scale, 1.0)))
    same = apart <= _SELF_TEST
    return Check(
        name="self-test",
        status="pass" if same else "fail",
        figure=apart,
        threshold=_SELF_TEST,
        source="algebraic identity of the two",
        meaning="idm-iv and ddm-iv are the same estimate"
        if same
        else "idm-iv and ddm-iv differ, which they cannot if the loop satisfies the model",
    )


def _excitation(estimate: Estimate) -> Check:
    condition = float(np.linalg.cond(estimate.X / np.linalg.norm(estimate.X, axis=0)))
    excited = condition <= _MOST_CONDITION
    return Check(
        name="excitation",
        status="pass" if excited else "fail",
        figure=condition,
        threshold=_MOST_CONDITION,
        source="condition number of unit columns below 100, common for exciting trajectories",
        meaning="the motion tells the parameters apart"
        if excited
        else "the motion hardly tells some parameters apart; record reversals, several speeds and "
        "acceleration",
    )


def _precision(axis: GeneratedAxis, estimate: Estimate) -> Check:
    relative = {n: v.relative_sd_hac_percent for n, v in estimate.parameters.items()}
    vague = [name for name, percent in relative.items() if percent > _MOST_RELATIVE_SD]
    worst = max(relative.values())
    return Check(
        name="precision",
        status="fail" if vague else "pass",
        figure=worst if np.isfinite(worst) else None,
        threshold=_MOST_RELATIVE_SD,
        source="relative HAC deviation in percent",
        meaning=f"{', '.join(vague)} of axis {axis.axis.name!r} is not identified by this record: "
        "its deviation is of the size of its value"
        if vague
        else "every parameter stands well above its deviation",
    )


def _following(estimate: Estimate) -> Check:
    error = estimate.simulation_error_percent
    if error is None:
        return _missing("simulation", "the closed loop could not be simulated")
    good = error < _FOLLOWING
    return Check(
        name="simulation",
        status="pass" if good else "fail",
        figure=error,
        threshold=_FOLLOWING,
        source="simulation error in percent of the left side; at 100 the loop says nothing of it",
        meaning="the simulated loop follows the record"
        if good
        else "the simulated loop does not follow the record; check the law, signs and units",
    )


def _autocorrelation(estimate: Estimate) -> Check:
    tests = residual_tests(estimate.residuals, estimate.X if estimate.Z is None else estimate.Z)
    independent = tests.ljung_box_p >= _SIGNIFICANT
    return Check(
        name="independent residuals",
        status="pass" if independent else "fail",
        figure=tests.durbin_watson,
        threshold=2.0,
        p_value=tests.ljung_box_p,
        source="Durbin-Watson, 2 for independent neighbours; p-value: Ljung-Box at 5 %",
        meaning="the residuals look independent"
        if independent
        else "the residuals are autocorrelated: believe the HAC deviations, not the i.i.d. ones",
    )


def _alignment(axis: GeneratedAxis, record: Record, prefilter: Prefilter, compared: Check) -> Check:
    if compared.status == "fail":
        return _missing("alignment", "noise biases least squares, by which the delay is measured")
    try:
        profile = profile_alignment(axis, record, prefilter)
    except (DataError, EstimationError) as error:
        return _missing("alignment", str(error))
    used = 0.5 if prefilter.hold == "zoh" else 0.0
    apart = profile.best - used
    moved = ", ".join(
        f"{p.name} by {slope:+.2g} {p.unit}"
        for p, slope in zip(axis.parameters, profile.sensitivity, strict=True)
    )
    fits = (
        f"the force fits the motion best {profile.best:.2f} samples earlier than it is recorded; "
        f"hold {prefilter.hold} takes it {used:g} samples earlier"
    )
    aligned = abs(apart) <= _ALIGNED
    return Check(
        name="alignment",
        status="pass" if aligned else "fail",
        figure=apart,
        threshold=_ALIGNED,
        source="samples between the delay of least equation error and the one that is used; a "
        "drive that holds its force is half a sample late",
        meaning=fits if aligned else f"{fits}. A sample of delay moves {moved}",
    )
