"""Recorded signals beside the forces that they make, as a check."""

import math
from collections.abc import Sequence

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.lacking import Lack, SignalApart, is_named, of_force
from axisid.estimation.records import Record, advised_shift
from axisid.estimation.tables import label_unit
from axisid.estimation.thresholds.estimates import MIN_DISTANCE_FROM_NOISE
from axisid.estimation.thresholds.lacking import MAX_UNIT_DISTANCE, MIN_MISSING_FORCE
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

_NAME = "recorded signals"
_UNITS = ("bar", "mbar", "kPa", "MPa", "mV", "kV", "mA", "kN", "mm", "mm/s", "deg", "rpm", "min")


def signals_check(
    axis: GeneratedAxis,
    record: Record,
    found: Sequence[SignalApart] | Missing,
    lacking: Sequence[Lack] | Missing,
) -> Check | Missing | None:
    """Whether recorded signals are in time and of their size; nothing for an axis without any.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    found : sequence of SignalApart or Missing
    lacking : sequence of Lack or Missing
        What else the model lacks: what explains more of the residuals comes first.
    """
    if isinstance(found, Missing):
        return found if axis.axis.signals else None
    if not found:
        return None
    wrong = max((f for f in found if f.fault), key=lambda f: f.explained, default=None)
    if wrong is None:
        told = "; ".join(_right(each) for each in found)
        return _check(found, None, meaning=f"the signals are in time with their forces: {told}")
    share = f" ({of_force(wrong.share)})"
    others = () if isinstance(lacking, Missing) else [lack for lack in lacking if is_named(lack)]
    if any(lack.explained > wrong.explained for lack in others):
        meaning = f"{_said(wrong, record)}, unless the missing term makes it{share}"
        return _check(found, wrong, meaning=meaning, matters=False)
    meaning = f"{_said(wrong, record)}{share}: "
    return _check(found, wrong, meaning=meaning, remedy=_remedy(axis, record, wrong))


def _check(
    found: Sequence[SignalApart],
    wrong: SignalApart | None,
    *,
    meaning: str,
    remedy: Remedy | None = None,
    matters: bool = True,
) -> Check:
    return Check(
        name=_NAME,
        status=passed(wrong is None, matters=matters),
        figure=100 * max(each.share for each in found),
        threshold=100 * MIN_MISSING_FORCE.value,
        p_value=None if wrong is None else wrong.p_value,
        source="percent of the force that a signal moved in time, or times a factor, makes beyond "
        "the signal as it is recorded; fails where that takes 5 % of the residuals too, and chance "
        "would in less than 0.1 % (Wald's and score test, HAC, allowed for the delays that are "
        "tried)",
        meaning=meaning,
        remedy=remedy,
    )


def _right(found: SignalApart) -> str:
    """What is known of a signal with which nothing is wrong."""
    time = (
        "its time shows in nothing"
        if math.isnan(found.delay)
        else f"{found.delay:+.2g} +- {max(found.delay_deviation, 0.01):.1g} samples late"
    )
    size = (
        "its scale rests on its column and unit alone"
        if math.isnan(found.factor)
        else f"{found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} times"
    )
    return f"{found.name}, {time}, {size}"


def _said(found: SignalApart, record: Record) -> str:
    if found.fault == "factor":
        return (
            f"the model needs {found.factor:.4g} +- {found.factor_deviation:.1g} times the "
            f"recorded {found.name}"
        )
    way = "late" if found.delay > 0 else "early"
    seconds = 1e3 * abs(found.delay) * record.period
    return (
        f"the {found.name} is logged {abs(found.delay):.4g} +- "
        f"{max(found.delay_deviation, 0.01):.1g} samples ({seconds:.4g} ms) {way} beside the force "
        "that it makes"
    )


def _remedy(axis: GeneratedAxis, record: Record, found: SignalApart) -> Remedy:
    if found.fault == "delay":
        margin = max(MIN_DISTANCE_FROM_NOISE.value * found.delay_deviation, 0.5)
        return advised_shift(found.name, found.delay, margin)
    column = record.provenance.columns.get(found.name, "NAME")
    unit = _unit(axis, found)
    if unit:
        return Remedy.of("it is in ", Setting("columns", f"{found.name}={column}:{unit}"))
    scaled = Setting("columns", f"{found.name}={column}:UNIT*{found.factor:.4g}")
    return Remedy.of(
        "check its unit and its scale (",
        scaled,
        "), and what is declared as known of its force",
    )


def _unit(axis: GeneratedAxis, found: SignalApart) -> str:
    """The unit that the column would be in; empty for no usual one."""
    (declared,) = (s for s in axis.axis.signals if s.name == found.name)
    own = label_unit(str(declared.unit))
    vague = MAX_UNIT_DISTANCE.value + MIN_DISTANCE_FROM_NOISE.value * found.factor_deviation / abs(
        found.factor
    )
    for name in _UNITS:
        known = label_unit(name)
        if own is None or known is None or known[1] != own[1]:
            continue
        if abs(found.factor / (known[0] / own[0]) - 1) <= vague:
            return name
    return ""
