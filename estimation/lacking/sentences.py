"""What is said of something that a model lacks."""

import numpy as np

from axisid.modeling.declaration import Axis

from .search import Lack
from .terms import OF_KIND, said_of


def term_sentence(lack: Lack, axis: Axis) -> str:
    """Which term is missing, how large it is, and the element that declares it."""
    q, term = axis.coordinate, OF_KIND[lack.kind]
    values, deviations = np.array(lack.values), np.array(lack.deviations)
    size = float(np.linalg.norm(values)) if len(values) > 1 else float(values[0])
    deviation = float(np.linalg.norm(values * deviations) / abs(size))
    what, advice = said_of(term, lack.at, axis, size)
    unit = term.unit.format(force=q.force_unit, unit=q.unit)
    amount = f", {size:+.3g} +- {deviation:.1g} {unit}" if unit else ""
    return f"{what}{amount}: {advice} ({of_force(lack.share)})"


def of_force(share: float) -> str:
    """How much of the force something makes; a share beyond all of it says no more than that."""
    beyond = share > 1
    return "this is more than the force" if beyond else f"{100 * share:.2g} % of the force is this"


def change_sentence(lack: Lack, unit: str) -> str:
    """Which parameter changes, by how much and when."""
    by = f"{lack.values[0]:+.3g} +- {lack.deviations[0]:.1g} {unit}"
    share = f" ({100 * lack.values[0] / lack.before:+.2g} %)" if lack.before else ""
    if lack.kind == "drift":
        return (
            f"{lack.parameter} changes by {by}{share} over the record, little by little: record "
            "when the axis is warm, or identify parts of the record by themselves"
        )
    return (
        f"{lack.parameter} changes by {by}{share} at about {lack.at:.3g} s: identify what is "
        "before and after by itself, or find what was changed there"
    )


def is_named(lack: Lack) -> bool:
    """Whether it is a term, and no parameter that changes."""
    return not lack.parameter
