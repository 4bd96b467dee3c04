"""What twins tell of the intervals of a study: of its first runs, for all of them.

Twins of each run, as `identify` draws them, would cost as many loops again. The runs differ in
their noise alone, so that their estimates have one bias, and deviations that lack as much.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.identification import identify
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .plan import MonteCarloPlan
from .runs import INTERVALS, BlockNumbers, Estimand, estimand_numbers
from .twins import twins

_RUNS = 16  # whose twins tell it
_OF_HAC = 2 + 3 * INTERVALS.index("hac")


#: Bias, and scales of the HAC deviation and of its interval, of what is estimated.
Calibrations = Mapping[Estimand, tuple[float, float, float]]


def study_calibrations(plan: MonteCarloPlan) -> Calibrations:
    """By twins of the first runs that have any; of nothing where none has."""
    shown: dict[Estimand, list[tuple[float, float, float]]] = {}
    first = twins(plan, range(min(_RUNS, plan.runs))) if plan.bootstrap else ()
    for _, record in first:
        if isinstance(record, Record):
            for estimand, of_one in _calibrations_of(plan, record).items():
                shown.setdefault(estimand, []).append(of_one)
    means = {estimand: np.mean(of_each, axis=0) for estimand, of_each in shown.items()}
    return {estimand: (float(b), float(sd), float(w)) for estimand, (b, sd, w) in means.items()}


def calibrated_runs(numbers: BlockNumbers, calibrations: Calibrations, judged: int) -> BlockNumbers:
    """The numbers of runs, calibrated from the first that has no twins of its own on."""
    changed, plain = numbers.numbers.copy(), numbers.runs >= judged
    for place, estimand in enumerate(numbers.estimands):
        if estimand in calibrations:
            bias, scale, width = calibrations[estimand]
            own = changed[plain, place]
            own[:, 1] = own[:, 0] - bias
            own[:, 3::3] -= bias
            own[:, 4::3] -= bias
            own[:, _OF_HAC] *= scale
            ends = own[:, _OF_HAC + 1 : _OF_HAC + 3]
            ends[:] = own[:, 1:2] + (ends - own[:, 1:2]) * width
            changed[plain, place] = own
    return replace(numbers, numbers=changed)


def _calibrations_of(
    plan: MonteCarloPlan, record: Record
) -> dict[Estimand, tuple[float, float, float]]:
    """Bias and scales of one run, without methods that have no twins."""
    made: dict[Estimand, tuple[float, float, float]] = {}
    for method in plan.regressions:
        try:
            with_twins, without = (
                identify(plan.axis, record, plan.prefilter, [method], **of)
                for of in ({**plan.settings, "bootstrap": n} for n in (plan.bootstrap, 0))
            )
        except AxisidError:
            continue
        if with_twins[method].filter_bias is None:
            continue
        plain = dict(estimand_numbers(without))
        for estimand, found in estimand_numbers(with_twins):
            made[estimand] = (found[0] - found[1], *_ratios(found, plain[estimand]))
    return made


def _ratios(found: Array, plain: Array) -> tuple[float, float]:
    """Of deviations, and of the widths of their intervals."""
    sizes = ((own[_OF_HAC], own[_OF_HAC + 2] - own[_OF_HAC + 1]) for own in (found, plain))
    (one, wide), (other, plain_wide) = sizes
    return (float(one / other), float(wide / plain_wide)) if other > 0 else (1.0, 1.0)
