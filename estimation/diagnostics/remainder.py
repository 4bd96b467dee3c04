"""What residuals are made of, as checks: what the model lacks, and how much of them repeats."""

from collections.abc import Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels, passed
from axisid.estimation.diagnostics.loop import scale_remedy
from axisid.estimation.estimates import Estimate
from axisid.estimation.lacking import Lack, sentence
from axisid.estimation.moves import LackOfFit
from axisid.estimation.records import Record, advised_shift
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE, MIN_MODEL_SHARE
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_LESS = Remedy.of(
    "; empty such cells and read with ",
    Setting("resample", "auto"),
    ", or let such rows count for less, ",
    Setting("loss", "huber"),
)
_SAME_UNIT = 0.02  # distance of a factor from that of another unit, up to which it is that
# HAC deviations by those of noise alone; from there on they are too wide for it
_MIN_HAC_EXCESS = 1.5


def terms_check(
    found: Sequence[Lack], axis: GeneratedAxis, record: Record, levels: Levels = DEFAULT_LEVELS
) -> Check:
    """Whether the residuals hold a term that the model lacks, or a parameter that changes."""
    own = [lack for lack in found if not (lack.is_of_signal or lack.is_outlier)]
    said = _said(own, axis, record) or "nothing that was looked for is in the residuals"
    return _check("missing terms", own, levels, said)


def signals_check(
    found: Sequence[Lack] | Missing,
    axis: GeneratedAxis,
    record: Record,
    levels: Levels,
) -> Check | Missing | None:
    """Whether recorded signals are in time and of their size; nothing for an axis without any."""
    if not axis.axis.signals:
        return None
    if isinstance(found, Missing):
        return found
    own = [lack for lack in found if lack.is_of_signal]
    said = _said(own, axis, record) or (
        "the recorded signals are in time with the forces that they make, and of their size"
    )
    remedy = Remedy.of(": ", _remedy(axis, record, own[0])) if own else None
    return _check("recorded signals", own, levels, said, remedy)


def outliers_check(
    found: Sequence[Lack],
    axis: GeneratedAxis,
    record: Record,
    levels: Levels = DEFAULT_LEVELS,
    *,
    bounded: bool = False,
) -> Check:
    """Whether single samples of what was measured leave its course.

    They are no more than a note where the loss has bounded what they do.
    """
    own = [lack for lack in found if lack.is_outlier]
    said = _said(own, axis, record) or "no single sample leaves its course"
    remedy = _LESS if own and not bounded else None
    return _check("outliers", own, levels, said, remedy, matters=not bounded)


def _said(own: Sequence[Lack], axis: GeneratedAxis, record: Record) -> str:
    return "; ".join(sentence(lack, axis, record) for lack in own)


def _check(
    name: str,
    own: Sequence[Lack],
    levels: Levels,
    meaning: str,
    remedy: Remedy | None = None,
    *,
    matters: bool = True,
) -> Check:
    return Check(
        name=name,
        status=passed(not own, matters=matters),
        figure=100 * max((lack.own_share for lack in own), default=0.0),
        threshold=100 * levels.least_share,
        p_value=min((lack.p_value for lack in own), default=None),
        source="percent of the force, root mean square; fails where the residuals hold more of it "
        f"than those of twins (Hotelling's test, {100 * levels.level:g} % over all that is looked "
        f"for, by Holm's rule) and it is more than {100 * levels.least_share:g} % of the force "
        "beside what the parameters make of it, or moves one by more than its interval",
        meaning=meaning,
        remedy=remedy,
    )


def _remedy(axis: GeneratedAxis, record: Record, found: Lack) -> Remedy:
    value, deviation, name = found.values[0], found.deviation, found.parameter
    if found.kind == "late signal":
        return advised_shift(name, value, max(MIN_DISTANCE_FROM_NOISE.value * deviation, 0.5))
    column = record.provenance.columns.get(name, "NAME")
    (declared,) = (s for s in axis.axis.signals if s.name == name)
    vague = _SAME_UNIT + MIN_DISTANCE_FROM_NOISE.value * deviation / abs(value)
    if known := scale_remedy(name, column, str(declared.unit), 1 / value, vague):
        return known
    scaled = Setting("columns", f"{name}={column}:UNIT*{value:.4g}")
    return Remedy.of(
        "check its unit and its scale (",
        scaled,
        "), and what is declared as known of its force",
    )


def lack_of_fit_check(found: LackOfFit | None, preferred: Estimate) -> Check | None:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    if found is None:
        return None
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
    if ratios[0] < _MIN_HAC_EXCESS or ratios[-1] == np.inf:  # without noise there is no ratio
        return ""
    low, high = f"{ratios[0]:.2g}", f"{ratios[-1]:.2g}"
    times = low if low == high else f"{low} to {high}"
    return (
        f"; HAC deviations are {times} times those of that noise, and say nothing of how far the "
        "model's error moves the parameters"
    )
