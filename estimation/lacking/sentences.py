"""What is said of something that a model lacks."""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.records.columns import expected_units

from .hypotheses import GAIN
from .search import Lack
from .terms import TERMS, said_of


def sentence(lack: Lack, axis: GeneratedAxis, record: Record) -> str:
    """What is missing, changes or is logged wrongly, how much of it, and what to do about it."""
    if lack.is_of_signal:
        return _signal(lack, record.period)
    size, deviation, unit = amount(lack, axis)
    if lack.is_outlier:
        sample, part = int(lack.at), of_force(lack.share)
        return (
            f"the {lack.parameter} leaves its course by {size:+.3g} +- {deviation:.1g} {unit} at "
            f"sample {sample + 1}, {record.time[sample] - record.time[0]:.6g} s after the first "
            f"({part})"
        )
    if not lack.parameter:
        what, advice = said_of(TERMS[lack.kind], lack.at, axis.axis, size)
        told = f", {size:+.3g} +- {deviation:.1g} {unit}" if unit else ""
        return f"{what}{told}: {advice} ({of_force(lack.share)})"
    if lack.kind == "held":
        by = f"{abs(size):.3g} +- {deviation:.1g} {unit}".rstrip()
        return f"another {lack.parameter} than was given, {by} {'more' if size > 0 else 'less'}"
    share = f" ({100 * size / lack.before:+.2g} %)" if lack.before else ""
    by = f"{size:+.3g} +- {deviation:.1g} {unit}".rstrip() + share
    if lack.kind == "drift":
        return (
            f"{lack.parameter} changes with time, by {by} over the record, little by little: "
            "record when the axis is warm, or identify parts of the record by themselves"
        )
    return (
        f"{lack.parameter} changes by {by} from about {lack.at:.3g} s on: identify what is before "
        "and after by itself, or find what was changed there"
    )


def amount(lack: Lack, axis: GeneratedAxis) -> tuple[float, float, str]:
    """How much of it there is, its deviation, and their unit."""
    values, deviation = np.array(lack.values), lack.deviation
    size = float(np.linalg.norm(values)) if len(values) > 1 else float(values[0])
    if lack.is_outlier:
        return size, deviation, expected_units(lack.parameter, axis.axis)[0]
    if lack.parameter:
        units = {q.name: str(q.unit) for q in axis.parameters} | {GAIN: "times"}
        return size, deviation, units.get(lack.parameter, "")
    q, unit = axis.axis.coordinate, TERMS[lack.kind].unit
    return size, deviation, unit.format(force=q.force_unit, unit=q.unit)


def of_force(share: float) -> str:
    """How much of the force something makes; a share beyond all of it says no more than that."""
    beyond = share > 1
    return "this is more than the force" if beyond else f"{100 * share:.2g} % of the force is this"


def _signal(lack: Lack, period: float) -> str:
    """How late or how much too small a recorded signal is, beside the force that it makes."""
    value, deviation = lack.values[0], lack.deviation
    if lack.kind == "scaled signal":
        said = f"the model needs {value:.4g} +- {deviation:.1g} times the recorded {lack.parameter}"
    else:
        way = "late" if value > 0 else "early"
        said = (
            f"the {lack.parameter} is logged {abs(value):.4g} +- {max(deviation, 0.01):.1g} "
            f"samples ({1e3 * abs(value) * period:.4g} ms) {way} beside the force that it makes"
        )
    return f"{said} ({of_force(lack.share)})"
