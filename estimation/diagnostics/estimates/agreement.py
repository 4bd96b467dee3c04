"""Estimates against each other, against what was fixed, and against the delta method, as checks."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.choices.outputs import OPEN_LOOP_FIT
from axisid.estimation.estimates import (
    Estimate,
    Physical,
    Value,
    alike_corrected,
    physical_parameters,
)
from axisid.estimation.noise import Attenuation, NoiseBias
from axisid.estimation.thresholds import (
    CONTRADICTION_LEVEL,
    MAX_BIAS_DISTANCE,
    MAX_BIAS_IN_INTERVAL,
    MAX_IDENTITY_ERROR,
    MAX_UNSEEN_BIAS,
    NOTICEABLE_BIAS,
)
from axisid.modeling.declaration import known_text
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy

from .instruments import Endogeneity, biased_parameters

#: What tells which of the two forms is off, or that both are, where no instruments do.
_TOLD_BY_OPEN_LOOP = Remedy.of(
    "; take a fit of the position under the recorded control, which no noise of a derivative "
    "moves: ",
    OPEN_LOOP_FIT,
)


def ls_against_iv(
    ls: Estimate | None,
    iv: Estimate | None,
    endogeneity: Endogeneity | Missing,
    biases: Mapping[str, NoiseBias] | None = None,
    *,
    weak: bool,
    alone: bool = False,
) -> Check | Missing:
    """Whether noise has biased least squares; nothing is told where the instruments are weak.

    What it has moved is marked in its column, and a note where another estimate is judged. Where
    least squares is all that was asked for, `alone`, it is a failure.
    """
    if ls is None or iv is None:
        return Missing("idm-ls and idm-iv did not both give an estimate")
    if weak:
        return Missing("the instruments are too weak to tell")
    shifted = {name: bias for name, bias in (biases or {}).items() if bias.moved}
    missing = [name for name, bias in shifted.items() if bias.misses]
    far = biased_parameters(ls, iv, endogeneity)
    moved = [name for name in iv.parameters if name in far or name in shifted]
    figure, threshold = _bias_figure(ls, iv, far, [*shifted.values()])
    return Check(
        name="least squares against instruments",
        status=passed(not moved, matters=alone and bool(far or missing)),
        figure=figure,
        threshold=threshold,
        p_value=None if isinstance(endogeneity, Missing) else endogeneity.p_value,
        source="largest difference in i.i.d. deviations of the instrumental estimate, at most 3 as "
        "in the paper where it is more than 1 %; or where Durbin-Wu-Hausman (regression form, the "
        "p-value) rejects at 1 % and a parameter differs by more than 10 %, which is then the "
        "figure, or where a HAC Hausman test of the difference rejects at 1 % and the interval of "
        "least squares does not hold the instruments' value, then in deviations of least squares; "
        "a note where that holds it from half a deviation on, and where another method is judged",
        meaning=_biased(ls, iv, moved, [n for n in moved if n in shifted], missing, alone=alone)
        if moved
        else "least squares and instruments differ by less than the rules allow; a bias below "
        f"{_unseen(iv):.2g} % would not be seen{_rejected(endogeneity)}",
    )


def _bias_figure(
    ls: Estimate, iv: Estimate, far: Sequence[str], shifted: Sequence[NoiseBias]
) -> tuple[float, float]:
    """The figure of the rule that speaks, and what it is held against."""
    apart = _apart(ls, iv)
    distance = max(
        abs(each) / d if d > 0 else 0.0
        for each, d in zip(apart.values(), np.sqrt(np.diag(iv.covariances["iid"])), strict=True)
    )
    if shifted and not far:
        missing = any(bias.misses for bias in shifted)
        most = MAX_BIAS_IN_INTERVAL if missing else MAX_UNSEEN_BIAS
        return max(bias.shift for bias in shifted), most.value
    if not far or distance > MAX_BIAS_DISTANCE.value:
        return float(distance), MAX_BIAS_DISTANCE.value
    return max(abs(_percent(ls, iv)[n]) for n in far), 100 * NOTICEABLE_BIAS.value


def _apart(ls: Estimate, iv: Estimate) -> dict[str, float]:
    """Least squares less instruments, by parameter."""
    one, other = alike_corrected(ls, iv)
    return dict(zip(iv.parameters, map(float, one - other), strict=True))


def _percent(ls: Estimate, iv: Estimate) -> dict[str, float]:
    """The same in percent of the instruments' value; infinite for a value of 0."""
    _, other = alike_corrected(ls, iv)
    return {
        name: 100 * apart / value if value else float("inf")
        for (name, apart), value in zip(_apart(ls, iv).items(), map(float, other), strict=True)
    }


def _biased(
    ls: Estimate,
    iv: Estimate,
    moved: list[str],
    shifted: list[str],
    missing: list[str],
    *,
    alone: bool,
) -> str:
    """By how much least squares is off, and which of its intervals miss, or hold all the same."""
    percent = _percent(ls, iv)
    listed = ", ".join(
        f"{name} by {percent[name]:+.3g} %" if np.isfinite(percent[name]) else name
        for name in moved
    )
    held = [name for name in shifted if name not in missing]
    intervals = f"; its 95 % interval of {', '.join(missing)} misses for it" if missing else ""
    if held:
        whose = "that" if missing else "its 95 % interval"
        intervals += f"; {whose} of {', '.join(held)} holds the instruments' value all the same"
    return (
        f"least squares differs from the instruments, {listed}{intervals}: lower the cut-off, or "
        + (f"identify by instruments ({iv.method})" if alone else "believe the instruments")
    )


def forms_check(found: Attenuation, *, by_instruments: bool) -> Check:
    """Least squares of the inverse against the direct model: noise parts them, nothing else may."""
    same = found.identity_error <= MAX_IDENTITY_ERROR.value
    near = found.shift <= MAX_UNSEEN_BIAS.value or by_instruments
    wide = found.parted > NOTICEABLE_BIAS.value
    far = wide and found.shift > MAX_BIAS_DISTANCE.value and not by_instruments
    return Check(
        name="inverse against direct",
        status=passed(same and (near and not wide), matters=not same or far),
        figure=100 * found.parted if same else found.identity_error,
        threshold=100 * NOTICEABLE_BIAS.value if same else MAX_IDENTITY_ERROR.value,
        source="1 - r^2 in percent, r^2 the squared partial correlation of force and acceleration, "
        "which inertias of ddm-ls and idm-ls have as their quotient on one set of rows; without "
        "instruments a note where the two are more than half a deviation apart, and a failure from "
        "10 % and three deviations on",
        meaning=_forms_said(found, near=near, wide=wide, by_instruments=by_instruments)
        if same
        else "least squares of the two forms contradicts the correlation of its own rows, which "
        "no data can do: an internal fault, please report it",
        remedy=_TOLD_BY_OPEN_LOOP if same and far else None,
    )


def _forms_said(found: Attenuation, *, near: bool, wide: bool, by_instruments: bool) -> str:
    name = found.parameter
    apart = (
        f"{name} is {found.inverse:.5g} by idm-ls and {found.direct:.5g} by ddm-ls "
        f"(r^2 = {found.r_squared:.5f})"
    )
    if by_instruments and wide:
        return f"{apart}: noise parts the two; believe the instruments"
    if near:
        return f"{apart}: noise parts the two by {100 * found.parted:.2g} %"
    return (
        f"{apart}, {found.shift:.2g} deviations apart: noise of the acceleration makes the first "
        "too small, that of the force the second too large, and without instruments nothing tells "
        "which; the truth is between them where the two noises are independent, and the intervals "
        "do not hold this"
    )


def _rejected(endogeneity: Endogeneity | Missing) -> str:
    """What the test alone says; with little noise in the equation it rejects for any bias."""
    if isinstance(endogeneity, Missing) or endogeneity.p_value >= CONTRADICTION_LEVEL.value:
        return ""
    said = f"Durbin-Wu-Hausman rejects (p = {endogeneity.p_value:.1g})"
    return f". {said}: there is a bias, too small to matter"


def _unseen(iv: Estimate) -> float:
    """Percent of bias that both rules would let pass, on the parameter known best."""
    relative = min(v.sd / abs(v.value) for v in iv.parameters.values() if v.value)
    return 100 * min(MAX_BIAS_DISTANCE.value * relative, NOTICEABLE_BIAS.value)


def fixed_check(estimate: Estimate) -> Check | Missing | None:
    """Whether the record contradicts what was fixed; nothing if nothing could be asked."""
    physical = physical_parameters(estimate)
    if physical is None or not (physical.base.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine what was fixed, so that it cannot contradict it"
        return Missing(physical.undetermined[-1] if physical.undetermined else why)
    good = physical.p_value >= CONTRADICTION_LEVEL.value
    return Check(
        name="fixed values" if physical.base.known else "physical parameters",
        status=passed(good),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"chi-squared with {physical.dof} degrees of freedom, covariance of the "
        "estimate and declared deviations, less the bias of filter and noise; fails below 1 %",
        meaning="the record agrees with them" if good else _contradiction(physical, estimate),
    )


def _contradiction(physical: Physical, estimate: Estimate) -> str:
    """What was fixed beside what the record alone says of it, where it says anything."""
    alone = estimate.parameters
    sides = [
        f"{p.name} is fixed at {known_text(p)} {p.unit}"
        + (
            f", the record alone gives {alone[p.name].corrected:.4g} +- {_deviation(alone[p.name])}"
            if p.name in alone
            else ""
        )
        for p in physical.base.known
    ]
    what = f": {'; '.join(sides)}" if sides else ""
    return (
        f"no values of the parameters agree with the record{' and what was fixed' * bool(sides)} "
        f"(chi-squared {physical.statistic:.3g}, degrees of freedom {physical.dof}){what}. "
        f"Check what was fixed, the drive gain and the terms of the model{_unknown_bias(estimate)}"
    )


def _deviation(value: Value) -> str:
    return f"{np.hypot(value.deviation, value.sd_gain):.2g}"


def _unknown_bias(estimate: Estimate) -> str:
    if estimate.filter_bias is not None:
        return ""
    return "; its bias, which could do it too, is not known without a control law"
