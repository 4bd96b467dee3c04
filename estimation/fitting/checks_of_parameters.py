"""Checks of what a fit says: what of it the outputs show, and how surely."""

import math
import re

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check, status_of
from axisid.estimation.diagnostics import held_check, nominal_check, precision_check
from axisid.estimation.estimates import student_interval
from axisid.estimation.thresholds import (
    MAX_FAR,
    MAX_RELATIVE_DEVIATION,
    MIN_DISTANCE_FROM_NOISE,
    MIN_FAR,
    MIN_SHOWN,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)

from .result import OutputFit

_SURE = 1e-2  # of a variance: the least by which what was known is moved


def known_check(of: OutputFit) -> Check | None:
    """What was known before against what the records tell."""
    if not of.prior:
        return None
    far = {name: _from_known(of, name) for name in of.prior}
    worst, most = max(far, key=lambda name: far[name]), MIN_DISTANCE_FROM_NOISE.value
    good = far[worst] <= most
    mean, sd = of.prior[worst]
    known, record = f"what was known of {worst}, {mean:.6g} +- {sd:.2g},", "the record"
    if worst in of.without_prior:
        value, deviation = of.without_prior[worst]
        record = f"what the record alone says, {value:.6g} +- {deviation:.2g},"
    said = f"{known} and {record} are {far[worst]:.2g} deviations apart"
    return Check(
        name="what was known",
        status=status_of(good),
        figure=far[worst],
        threshold=most,
        source=MIN_DISTANCE_FROM_NOISE.source,
        meaning=said + ("" if good else ": they contradict each other; one is wrong, or the model"),
    )


def _from_known(of: OutputFit, name: str) -> float:
    """How far a parameter is from what was known of it before, in deviations."""
    mean, sd = of.prior[name]
    if name in of.without_prior:
        value, deviation = of.without_prior[name]
        return abs(value - mean) / math.hypot(sd, deviation)
    place = of.names.index(name)
    both = math.sqrt(max(sd**2 - float(of.deviations[place]) ** 2, _SURE * sd**2))
    return abs(float(of.physical[place]) - mean) / both


def shown_check(of: OutputFit) -> Check:
    """Whether the outputs show every parameter."""
    several = len(of.outputs) > 1
    said = f"the {' and '.join(of.outputs)} show{'' if several else 's'} every parameter"
    unseen = [*of.unseen, *_unnamed(of)]
    if unseen:
        no = "do not" if several else "does not"
        said = (
            f"the {' and '.join(of.outputs)} {no} show {'; nor '.join(unseen)}; hold one with fix "
            f"{unseen[0].split()[0]}=VALUE, or record another motion."
        )
    return Check(
        name="parameters shown",
        status=status_of(not unseen),
        threshold=MIN_SHOWN.value,
        source=MIN_SHOWN.source,
        meaning=said,
    )


def _unnamed(of: OutputFit) -> list[str]:
    """Parameters of infinite deviation that are in none of the directions that are not shown."""
    named = set(re.findall(r"\w+", " ".join(of.unseen)))
    lost = [name for name, d in zip(of.names, of.deviations, strict=True) if np.isinf(d)]
    return [f"{name} at all" for name in lost if name not in named]


def none_shown_check(of: OutputFit) -> Check | None:
    """Whether the outputs show none of the parameters that are searched."""
    if not np.isinf(of.deviations).any():
        return None
    chosen, most = _searched(of), MAX_RELATIVE_DEVIATION.value
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = 100 * of.deviations / np.abs(of.physical)
    if np.any((percent <= most)[chosen]):
        return None
    return Check(
        name="any parameter shown",
        status="fail",
        threshold=most,
        source="deviation in percent of the value",
        meaning=f"the {' and '.join(of.outputs)} show{'s' * (len(of.outputs) == 1)} no "
        f"parameter to {most:g} % of it: the numbers are where the search ended, no more",
    )


def one_end_check(of: OutputFit) -> Check | None:
    """Whether the search passed a place as good as its end, which is claimed to be far from it."""
    found = of.elsewhere
    if found is None:
        return None
    order = [int(j) for j in np.argsort(-found.away) if found.away[j] > MIN_FAR.value]
    values = (f"{of.names[j]} {found.physical[j]:.4g} {of.quantities[j].unit}" for j in order)
    listed = ", ".join(map(str.rstrip, values))
    outputs = f"{' and '.join(of.outputs)} leave{'s' * (len(of.outputs) == 1)}"
    return Check(
        name="one end",
        status="fail",
        figure=found.by_errors,
        threshold=MAX_FAR.value,
        source=MAX_FAR.source,
        meaning=(
            f"the errors are as small at {listed}: {found.away[order[0]]:.2g} of the "
            f"deviations away, and {found.by_errors:.2g} by the errors. The {outputs} these "
            "open along a valley, and the deviations are those of one place in it; hold one "
            f"with fix {of.names[order[0]]}=VALUE, or follow another output."
        ),
    )


def _searched(of: OutputFit) -> NDArray[np.bool_]:
    """Parameters of the model, the law and the drive that were searched and are at no bound."""
    return np.asarray((of.deviations > 0) & ~of.of_start)


def precise_check(of: OutputFit) -> Check | None:
    """Every parameter that is searched, and shown, against its own deviation."""
    slopes, weights = of.best.slopes.jacobian, of.weighing.weights
    parts = np.abs(weights[:, None] * slopes * of.physical)
    whole, peak = (
        np.divide(x, x.max() or 1.0) for x in (np.linalg.norm(parts, axis=0), parts.max(axis=0))
    )
    chosen = (of.deviations > 0) & np.isfinite(of.deviations) & ~of.of_start
    if not chosen.any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(chosen, of.deviations / np.abs(of.physical), 0.0)
        times, percent = 1 + 2 * relative, 100 * relative  # of what it may be, by what it is
        small = (whole * times < NEGLIGIBLE_FORCE.value) & (
            peak * times < NEGLIGIBLE_PEAK_FORCE.value
        )
    vague = percent > MAX_RELATIVE_DEVIATION.value
    told = dict(zip(of.names, map(float, percent), strict=True))
    unclear, minor = (
        [of.names[int(j)] for j in np.flatnonzero(x)] for x in (vague & ~small, vague & small)
    )
    return precision_check(
        max(told.values()),
        [
            f"{name} is not identified by what is followed: its deviation is {told[name]:.3g} % of "
            "it"
            for name in unclear
        ],
        minor,
        "largest part that a parameter has of the output",
        "relative deviation in percent; a parameter that changes the output by less than 1 % of "
        "what the largest does, deviation included, may be as vague as it is",
    )


def bounds_check(of: OutputFit) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound."""
    if of.held:
        return held_check(of.held)
    return Check(name="bounds", status="pass", meaning="no parameter is driven to a bound")


def nominal_values_check(of: OutputFit) -> Check | None:
    """Values of another order of size than declared."""
    declared = {p.name: p for p in of.axes[0].axis.parameters}
    rows = zip(of.names, of.physical, of.deviations, strict=True)
    return nominal_check(
        (declared[name], value, student_interval(value, deviation, np.inf))
        for name, value, deviation in rows
        if name in declared
    )
