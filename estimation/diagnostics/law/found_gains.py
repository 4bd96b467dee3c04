"""A law some of whose gains a fit has found against the recorded control.

The control follows from reference and position exactly, so that it tells the gains far better than
a fit does, which finds them as unsurely as any parameter. The law is held against the control with
the gains that the control itself asks for; what was found must then be those, as surely as both are
known.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.regression import joint_p, wald
from axisid.estimation.thresholds import MAX_LAW_RESIDUAL, MAX_SCALE_ERROR, MIN_DISTANCE_FROM_NOISE
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .by_runs import GainsBeside
from .control_law import LawCheck, check_law, law_beside


@dataclass(frozen=True, slots=True)
class FoundGains:
    """Gains of a law that were found together with parameters.

    Attributes
    ----------
    names : tuple of str
    covariance : (k, k) array
        Of what was found; infinite variances of what is not known at all.
    freedom : float
        Degrees of freedom of that.
    """

    names: tuple[str, ...]
    covariance: Array
    freedom: float


def check_found_law(axis: GeneratedAxis, record: Record, found: FoundGains) -> LawCheck | Missing:
    """Check an axis's control law, some gains of which were found, against a record.

    Parameters
    ----------
    axis : GeneratedAxis
        Its law has the gains that were found.
    record : Record
    found : FoundGains
        None of its gains is taken as exact.

    Returns
    -------
    LawCheck or Missing
        Of the law with the values of those gains that the recorded control asks for. It fails where
        that law is not the control's, or where those values are not what was found.
    """
    law, first = axis.axis.control, check_law(axis, record)
    if law is None or not found.names or isinstance(first, Missing):
        return first
    if first.residual_percent is None:
        return first
    beside = law_beside(axis, law, record)
    best = beside.best(found.names)
    there = check_law(axis.with_gains(best.gains), record)
    if isinstance(there, Missing):
        return first
    if there.passed:
        return _beside_found(there, best, law, found)
    if first.passed:
        return first
    flipped = beside.flipped.best(found.names)
    if flipped.percent(flipped.point) < MAX_LAW_RESIDUAL.value:
        listed = " and ".join(f"{name} {flipped.gains[name]:.5g}" for name in found.names)
        said = (
            "the recorded control is not the law's by any gains: its sign is opposite to the "
            f"law's, with which it would be by {listed}; check the sign of the control or of the "
            "positions"
        )
        return replace(there, factors={}, meaning=said, remedy=None)
    return _not_even(there, axis, beside, record, found.names)


def _beside_found(
    there: LawCheck, best: GainsBeside, law: ControlLaw, found: FoundGains
) -> LawCheck:
    """The check of the law with the gains that the control asks for, held against those found."""
    asked, was = best.gains, np.array([law.gains[name] for name in found.names])
    off = np.array([asked[name] for name in found.names]) - was
    own = best.covariance(found.names)
    among = found.covariance + own * np.outer(was, was)
    apart = apart_in_deviations(off, among, found.freedom)
    large = bool(np.any(np.abs(off) > MAX_SCALE_ERROR.value * np.abs(was)))
    listed = " and ".join(f"{name} {asked[name]:.5g}" for name in found.names)
    if not (large and apart > MIN_DISTANCE_FROM_NOISE.value):
        return replace(
            there,
            meaning=f"{there.meaning} by {listed}, {apart:.2g} joint deviations from what the fit "
            "finds",
        )
    these = "that" if len(found.names) == 1 else "these"
    values = " and ".join(f"{name} {law.gains[name]:.5g}" for name in found.names)
    return replace(
        there,
        passed=False,
        found_apart=True,
        meaning=f"the recorded control is the law's by {listed}, and the fit finds {values}, "
        f"{apart:.2g} joint deviations away: what the model lacks moves them, or a delay that the "
        f"law does not declare; check those, or declare {these} and leave them held",
    )


def apart_in_deviations(off: Array, covariance: Array, freedom: float) -> float:
    """How far (k,) differences are from 0, as deviations of a normal one that is as unlikely.

    What has no chance at all is as far as the least one that a number can be, 37.
    """
    square, directions = wald(off, covariance)
    if not directions:
        return 0.0
    chance = joint_p(square, directions, freedom)
    return -float(ndtri(max(chance, float(np.finfo(float).tiny)) / 2))


def _not_even(
    there: LawCheck,
    axis: GeneratedAxis,
    beside: GainsBeside,
    record: Record,
    names: tuple[str, ...],
) -> LawCheck:
    """What is said of a law that gives the control by no values of its free gains."""
    law, listed = beside.along.law, " and ".join(names)
    held = [name for name in law.gains if name not in names]
    if held:
        asked = beside.best(tuple(law.gains)).gains
        whole = check_law(axis.with_gains(asked), record)
        if isinstance(whole, LawCheck) and whole.passed:
            off = [n for n in held if abs(asked[n] / law.gains[n] - 1) > MAX_SCALE_ERROR.value]
            said = " and ".join(f"{n} {asked[n]:.5g} for {law.gains[n]:.5g}" for n in off or held)
            return replace(
                there,
                meaning=f"no {listed} gives the recorded control, and with {said} the law would: "
                f"declare that, or let {' and '.join(off or held)} be free too",
            )
    return replace(there, meaning=f"with the {listed} that suit best, {there.meaning}")
