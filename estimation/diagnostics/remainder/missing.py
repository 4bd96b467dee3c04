"""What the model lacks, as checks: each term comes with the element that declares it."""

from collections.abc import Sequence
from dataclasses import replace

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels, passed
from axisid.estimation.diagnostics.loop import likely_unit
from axisid.estimation.lacking import Lack, sentence
from axisid.estimation.records import Record, advised_shift
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_LESS = Remedy.of(
    "; empty such cells and read with ",
    Setting("resample", "auto"),
    ", or let such rows count for less, ",
    Setting("loss", "huber"),
)
_SAME_UNIT = 0.02  # distance of a factor from that of another unit, up to which it is that


def terms_check(
    found: Sequence[Lack], axis: GeneratedAxis, record: Record, levels: Levels = DEFAULT_LEVELS
) -> Check:
    """Whether the residuals hold a term that the model lacks, or a parameter that changes."""
    own = [lack for lack in found if not (lack.is_of_signal or lack.is_outlier)]
    said = "; ".join(sentence(lack, axis, record) for lack in own)
    said = said or "nothing that was looked for is in the residuals"
    return _check("missing terms", own, levels, said)


def signals_check(
    found: Sequence[Lack] | Missing,
    axis: GeneratedAxis,
    record: Record,
    levels: Levels,
) -> Check | Missing | None:
    """Whether recorded signals are in time and of their size; nothing for an axis without any."""
    if not axis.axis.signals or isinstance(found, Missing):
        return found if axis.axis.signals and isinstance(found, Missing) else None
    own = [lack for lack in found if lack.is_of_signal]
    if not own:
        said = "the recorded signals are in time with the forces that they make, and of their size"
        return _check("recorded signals", own, levels, said)
    said = "; ".join(sentence(lack, axis, record) for lack in own)
    return _check("recorded signals", own, levels, f"{said}: ", _remedy(axis, record, own[0]))


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
    said = "; ".join(sentence(lack, axis, record) for lack in own)
    check = _check("outliers", own, levels, said or "no single sample leaves its course", _LESS)
    if not own:
        return replace(check, remedy=None)
    return replace(check, status="note", remedy=None) if bounded else check


def _check(
    name: str, own: Sequence[Lack], levels: Levels, meaning: str, remedy: Remedy | None = None
) -> Check:
    return Check(
        name=name,
        status=passed(not own),
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
    unit = likely_unit(str(declared.unit), 1 / value, vague)
    if unit:
        return Remedy.of("it is in ", Setting("columns", f"{name}={column}:{unit}"))
    scaled = Setting("columns", f"{name}={column}:UNIT*{value:.4g}")
    return Remedy.of(
        "check its unit and its scale (",
        scaled,
        "), and what is declared as known of its force",
    )
