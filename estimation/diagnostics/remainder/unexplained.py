"""What the residuals are made of where they are no noise.

A constant force, a term that is missing, a parameter that changes: each comes with what to do about
it, as the element to declare.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr, stdtrit

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.estimates import Estimate
from axisid.estimation.lacking import Lack, change_sentence, is_named, term_sentence
from axisid.estimation.moves import LackOfFit
from axisid.estimation.regression import factor, instrumental_variables, least_squares
from axisid.estimation.signals import drive_force
from axisid.estimation.thresholds.diagnostics import (
    NEGLIGIBLE_FORCE,
    SAME_CONSTANT,
)
from axisid.estimation.thresholds.estimates import MIN_DISTANCE_FROM_NOISE
from axisid.estimation.thresholds.lacking import MIN_MISSING_FORCE
from axisid.estimation.thresholds.moves import MIN_HAC_EXCESS, MIN_MODEL_SHARE
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

_CONSTANT = "constant force"
_TERMS, _CHANGES = "missing terms", "changes in time"
_TOLD = (
    "percent of the force, root mean square; fails where Wald's test tells it from zero among all "
    "that is looked for (a false-discovery rate of 0.1 %, Benjamini-Yekutieli), the score test at "
    "1 % too, and it takes 5 % or more of the residuals' power"
)


def constant_check(
    preferred: Estimate,
    weights: Array,
    law: LawCheck | Missing,
    lacking: Sequence[Lack] | Missing,
) -> Check | Missing:
    """Whether a constant force is left in the residuals.

    Parameters
    ----------
    preferred : Estimate
    weights : (n,) array
        Of its rows: what a constant force of 1 makes of them.
    law : LawCheck or Missing
    lacking : sequence of Lack or Missing
        What the model lacks besides: a term of another kind has a mean, and is told of by itself.
    """
    if preferred.ddm_quantities:
        return Missing("the rows of a direct model are accelerations")
    found = _constant(preferred, weights)
    # Nothing beside terms that make a constant themselves.
    force, deviation, needed = found or (0.0, 0.0, 0.0)
    unit = preferred.form.axis.axis.coordinate.force_unit
    size = abs(force) * float(np.linalg.norm(weights)) / float(np.linalg.norm(preferred.y))
    good = abs(force) <= needed * deviation or size <= NEGLIGIBLE_FORCE.value
    terms = () if isinstance(lacking, Missing) else [lack for lack in lacking if is_named(lack)]
    said = f"{force:.3g} +- {deviation:.1g} {unit}"
    return Check(
        name=_CONSTANT,
        status=passed(good, matters=not terms),
        figure=100 * size,
        threshold=100 * NEGLIGIBLE_FORCE.value,
        source="percent of the force that a constant beside the model's terms would be, estimated "
        "as they are; fails where it is three of its deviations too, or as rare by Student's "
        "distribution with fewer degrees of freedom, unless a missing term is named",
        meaning="no constant force is left in the residuals"
        if good
        else f"a constant force of {said} is left in the residuals: "
        + ("the missing term may make it" if terms else _whose(preferred, force, law)),
    )


def terms_check(found: Sequence[Lack] | Missing, preferred: Estimate) -> Check | Missing:
    """Whether the residuals hold a term that an element declares."""
    if isinstance(found, Missing):
        return found
    terms, axis = [lack for lack in found if is_named(lack)], preferred.form.axis.axis
    return _lacking(
        _TERMS,
        terms,
        "; ".join(term_sentence(lack, axis) for lack in terms)
        or "no named term of friction, drag or position stands out of the residuals",
        _TOLD,
    )


def changes_check(found: Sequence[Lack] | Missing, preferred: Estimate) -> Check | Missing:
    """Whether a parameter is another from some time on, or drifts over the record."""
    if isinstance(found, Missing):
        return found
    changes = [lack for lack in found if lack.parameter]
    units = {q.name: q.unit for q in preferred.quantities}
    return _lacking(
        _CHANGES,
        changes,
        "; ".join(change_sentence(lack, units[lack.parameter]) for lack in changes)
        or "no parameter changes while the record runs",
        f"{_TOLD}; of a change, the largest of the statistics over all times (Andrews)",
    )


def _lacking(name: str, found: Sequence[Lack], meaning: str, source: str) -> Check:
    return Check(
        name=name,
        status=passed(not found),
        figure=100 * max((lack.share for lack in found), default=0.0),
        threshold=100 * MIN_MISSING_FORCE.value,
        p_value=min((lack.p_value for lack in found), default=None),
        source=source,
        meaning=meaning,
    )


def lack_of_fit_check(found: LackOfFit, preferred: Estimate) -> Check:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    unit = left_unit(preferred)
    noise = f"{found.noise:.2g} {unit} is noise"
    return Check(
        name="lack of fit",
        status=passed(not found.is_mostly_model, matters=False),
        figure=100 * found.share,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="percent of the residuals' power that is left again where the reference repeats, "
        "from the products of residuals of different repeats; it counts where noise "
        "repeats as much but for a chance of 1e-3 (HAC over the phases), and where it goes on from "
        "row to row",
        meaning=f"{100 * found.share:.0f} % of what the model leaves is the model: "
        f"{found.repeated:.2g} {unit} ({100 * found.repeated / found.left:.2g} % of the "
        f"{preferred.form.left}) {_again(found)}, {noise}{_too_wide(found)}"
        if found.is_mostly_model
        else f"{found.repeated:.2g} {unit} of what the model leaves {_again(found)} but jumps from "
        f"row to row, as the steps of an encoder do, {noise}"
        if found.is_there and not found.is_smooth
        else f"most of what the model leaves is noise: {found.repeated:.2g} {unit} "
        f"{_again(found)}, {noise}"
        if found.is_there
        else f"what the model leaves is noise: nothing of it {_again(found)}, {noise}",
    )


def left_unit(estimate: Estimate) -> str:
    """Unit of the regression's left side."""
    coordinate = estimate.form.axis.axis.coordinate
    unit = coordinate.acceleration_unit if estimate.is_direct else coordinate.force_unit
    return str(unit)


def _again(found: LackOfFit) -> str:
    """When what is left is left again."""
    if found.period is None:
        return "repeats wherever a move does"
    return f"repeats every {found.period:.4g} s"


def _too_wide(found: LackOfFit) -> str:
    """What HAC deviations are in those of the noise; nothing where they are about the same."""
    ratios = sorted(found.hac_excess.values())
    if ratios[0] < MIN_HAC_EXCESS.value or ratios[-1] == np.inf:  # without noise there is no ratio
        return ""
    low, high = f"{ratios[0]:.2g}", f"{ratios[-1]:.2g}"
    times = low if low == high else f"{low} to {high}"
    return (
        f"; HAC deviations are {times} times those of that noise, and say nothing of how far the "
        "model's error moves the parameters"
    )


def _constant(preferred: Estimate, weights: Array) -> tuple[float, float, float] | None:
    """A constant force, its deviation, and how many of them tell it from none; None for nothing.

    It is estimated beside the parameters. In sluggish noise few rows are told apart, and three of
    their deviations are no rare thing.
    """
    y = preferred.residuals + preferred.X @ preferred.theta
    names = [*(q.name for q in preferred.quantities), _CONSTANT]
    try:
        columns = np.column_stack([preferred.X, weights])
        regressor = factor(columns, names, neighbours=preferred.neighbours)
        if preferred.Z is None:
            solution = least_squares(y, regressor)
        else:
            instruments = factor(
                np.column_stack([preferred.Z, weights]), names, "the simulated loop"
            )
            solution = instrumental_variables(y, regressor, instruments)
    except EstimationError:
        return None
    model = preferred.covariance_model
    deviation = float(np.sqrt(model.matrix(solution)[-1, -1]))
    rare = float(ndtr(MIN_DISTANCE_FROM_NOISE.value))
    needed = float(stdtrit(model.freedom(solution)[-1], rare))
    return float(solution.theta[-1]), deviation, needed


def _whose(preferred: Estimate, force: float, law: LawCheck | Missing) -> str:
    """Where a constant comes from, and what to do."""
    recorded = None if isinstance(law, Missing) else law.constant
    if recorded is not None and _is_made_of(preferred.form.axis, recorded, force):
        return (
            f"it is in the recorded control ({recorded:.3g}) and not in the law, so the converter "
            "that records it is off; take that off the control"
        )
    return (
        f"declare an offset (offset(F0), F0 about {force:.3g}), or what depends on the position "
        "and has such a mean; or check the zero of what records the force"
    )


def _is_made_of(axis: GeneratedAxis, control: float, force: float) -> bool:
    """Whether a constant force is about what the drive makes of a constant control."""
    recorded = [np.ones(1) for _ in axis.axis.signals]
    made = drive_force(axis, np.array([control]), np.zeros(1), np.zeros(1), recorded)[0]
    return bool(abs(made - force) < SAME_CONSTANT.value * abs(force))
