"""Whether a fit is to be believed."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.estimation.checks import Check, made, status_of
from axisid.estimation.choices import POSITION
from axisid.estimation.diagnostics import NOMINAL_VALUES, repeated_check
from axisid.estimation.diagnostics.law import LawCheck, law_check
from axisid.estimation.parameters import START
from axisid.estimation.searches import MOST_STEPS
from axisid.estimation.thresholds import NOTICEABLE_BIAS
from axisid.support.errors import Missing

from .checks_of_fit import (
    bounds_check,
    joined_check,
    known_check,
    missing_terms_check,
    nominal_values_check,
    none_shown_check,
    one_end_check,
    precise_check,
    records_alike_check,
    rests_check,
    rows_check,
    shown_check,
    simulation_check,
    windows_check,
)
from .result import OutputFit
from .spread import MIN_MOVED_BY_START

_MAX_LAW_SHIFT = 2.0  # deviations, by a control law that is not the declared one
_MAX_LAW_SENSITIVITY = 5.0  # % by 1 % of a term of the law; beyond, the law must be exact
_MAX_APART = 0.5  # of the searches end higher than the best
_SAME_END = 1e-3  # of the least cost, by which another search that ended there may be higher
_MIN_MOVED_BY_NOISE = 1.0  # deviations by noise in the loop, which is taken off

_FACTORS = "law's factors"


def judged(of: OutputFit) -> tuple[Check, ...]:
    """The checks, in the order in which they are told."""
    found = (made(name, partial(check, of)) for name, check in _CHECKS.items())
    return tuple(check for check in found if check is not None)


def _law(of: OutputFit) -> Check | Missing:
    """What the declared law is against the recorded control.

    What factors of the law tell counts once, by what they move the parameters by.
    """
    found = law_check(of.law)
    if isinstance(found, Check) and _is_law_nearly_right(of):
        return replace(found, status="note")
    return found


def _is_law_nearly_right(of: OutputFit) -> bool:
    """Whether factors explain a control that is not the law's, and move nothing by much.

    Nor would the scale of the recorded control, from which the law does not tell factors.
    """
    law = of.law
    if not isinstance(law, LawCheck) or not isinstance(of.law_shift, tuple):
        return False
    most = np.maximum(NOTICEABLE_BIAS.value * np.abs(of.physical), of.deviations)
    near = (np.abs(of.law_shift[0]) <= most) | of.of_start
    small = all(abs(each - 1) <= NOTICEABLE_BIAS.value for each in law.factors.values())
    return not law.passed and law.is_told_by_factors and small and bool(near.all())


def _moved(of: OutputFit) -> Check | Missing | None:
    """What the law as it is in the record moves the parameters by."""
    if of.law_shift is None or isinstance(of.law_shift, Missing):
        return of.law_shift
    moved, sure = of.law_shift
    with np.errstate(divide="ignore", invalid="ignore"):
        claimed = np.nan_to_num(np.abs(moved) / of.deviations, posinf=np.inf)
        far = np.nan_to_num(np.abs(moved) / np.hypot(of.deviations, sure), posinf=np.inf)
    counted = (of.deviations > 0) & ~of.of_start  # a record's own start is no property
    claimed, far = (np.where(counted, each, 0.0) for each in (claimed, far))
    beyond, nearly_right = bool(np.any(far > _MAX_LAW_SHIFT)), _is_law_nearly_right(of)
    worst = int(np.argmax(np.where(far > _MAX_LAW_SHIFT, claimed, 0.0) if beyond else far))
    name, value = of.names[worst], of.physical[worst]
    share = 100 * abs(moved[worst] / value) if value else np.inf
    said = (
        f"the law as its control is recorded, in place of the declared one, moves {name} by "
        f"{share:.2g} % ({far[worst]:.2g} deviations)"
    )
    if beyond or nearly_right:
        instead = ", follow the control" if of.outputs == (POSITION,) else ""
        said += (
            f": correct the gains of the declared law, free them{instead}, or identify by "
            "instruments, which ask for no exact law"
        )
    return Check(
        name=_FACTORS,
        status=status_of(not (beyond or nearly_right)),
        figure=float(far[worst]),
        threshold=_MAX_LAW_SHIFT,
        source="measured: at most 1.2 on 120 right twins whose position is followed, 120 with kp "
        "1 % wrong; fails too where the law is off by factors that move no "
        f"parameter by more than {100 * NOTICEABLE_BIAS.value:g} % of it, for which the check of "
        "the law is a note",
        meaning=said,
    )


def _sensitive(of: OutputFit) -> Check | None:
    """How exact the law has to be."""
    if not of.law_moves:
        return None
    sizes = np.abs(of.physical)
    # A gain that is found is what the law's error is told by.
    found = np.isin(of.names, of.found_gains.names)
    counted = (sizes > 0) & ~of.of_start & ~found
    sizes = np.where(counted, sizes, np.inf)
    shares = {name: 100 * np.abs(move) / sizes for name, move in of.law_moves.items()}
    term = max(shares, key=lambda name: float(shares[name].max()))
    j = int(np.argmax(shares[term]))
    share = float(shares[term][j])
    said = f"a law whose {term} is 1 % other than declared moves {of.names[j]} by {share:.2g} %"
    if share > _MAX_LAW_SENSITIVITY:
        exact = "the law must be exact" if of.outputs == (POSITION,) else "the law must be right"
        moved = abs(float(of.law_moves[term][j]))
        if 0 < of.deviations[j] < moved:
            enough = float(f"{of.deviations[j] / moved:.2g}")
            said += f", and {enough:g} % by its whole deviation, which supposes the declared law"
        said += f": {exact}, or the numbers are its error"
    return Check(
        name="exact law",
        status=status_of(share <= _MAX_LAW_SENSITIVITY, matters=False),
        figure=share,
        threshold=_MAX_LAW_SENSITIVITY,
        source="measured: 0.4 where the control is followed, 43 where the position is",
        meaning=said,
    )


def _ended(of: OutputFit) -> Check:
    best, said = of.best, f"the search stands still after {len(of.best.steps)} steps"
    if not best.converged:
        said = (
            f"the search still moves after {MOST_STEPS} steps; start elsewhere, or leave out what "
            "the record does not show"
        )
    if best.lost:
        said += f"; {best.lost} parameter sets on the way could not be simulated: {best.why_lost}"
    return Check(
        name="convergence",
        status=status_of(best.converged),
        figure=float(len(best.steps)),
        threshold=float(MOST_STEPS),
        meaning=said,
    )


def _shaken(of: OutputFit) -> Check | Missing | None:
    """What noise in the loop moved, and is taken off."""
    moved = of.moved
    if moved is None:
        return None
    if isinstance(moved, Missing):
        return Missing(f"what noise makes of the parameters is not known: {moved.reason}")
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.nan_to_num(np.abs(moved) / of.deviations, posinf=0.0)
    worst = int(np.argmax(far))
    if far[worst] <= _MIN_MOVED_BY_NOISE:
        return None
    value, by = of.physical[worst], float(moved[worst])
    share = f" ({100 * by / abs(value):+.2g} %)" if value else ""
    return Check(
        name="noise in the loop",
        status="note",
        figure=float(far[worst]),
        threshold=_MIN_MOVED_BY_NOISE,
        source="chosen",
        meaning=f"simulated loops with the record's noise moved {of.names[worst]} by "
        f"{far[worst]:.2g} deviations{share}, which is taken off, and the others alike",
    )


def _begun(of: OutputFit) -> Check | None:
    """What the first positions and velocities, as the records have them, leave open."""
    moved, far = of.by_start
    if not far.any():
        return None
    worst = int(np.argmax(far))
    value, by = of.physical[worst], abs(float(moved[worst]))
    share = f"by {100 * by / abs(value):.2g} %" if by < abs(value) else "by more than it is"
    return Check(
        name="start of the loop",
        status="note",
        figure=float(far[worst]),
        threshold=MIN_MOVED_BY_START,
        source="measured: of twins cut 0.1 s long from a move 80 % of intervals hold without, "
        "100 % with",
        meaning=(
            "the record begins in motion, and the loop where its first samples say; with "
            f"another start {of.names[worst]} would move {share}, which its deviation counts; "
            f'find the start with the parameters by free="{START}".'
        ),
    )


def _starts(of: OutputFit) -> Check | None:
    if len(of.searches) < 2:
        return None
    alike = sum(each.cost <= of.best.cost * (1 + _SAME_END) for each in of.searches)
    share = 1 - alike / len(of.searches)
    return Check(
        name="starts",
        status=status_of(share <= _MAX_APART, matters=False),
        figure=share,
        threshold=_MAX_APART,
        source="chosen: the lowest end is then found by few",
        meaning=f"{alike} of {len(of.searches)} searches ended here, the others higher",
    )


#: By name, in the order in which they are told.
_CHECKS: dict[str, Callable[[OutputFit], Check | Missing | None]] = {
    "control law": _law,
    "windows": windows_check,
    _FACTORS: _moved,
    "exact law": _sensitive,
    "simulation": simulation_check,
    "missing terms": missing_terms_check,
    "outliers": partial(joined_check, "outliers"),
    "what was known": known_check,
    "rows": rows_check,
    "samples near rests": rests_check,
    "repeated records": lambda of: repeated_check(of.records),
    "records alike": records_alike_check,
    "convergence": _ended,
    "parameters shown": shown_check,
    "any parameter shown": none_shown_check,
    "one end": one_end_check,
    "precision": precise_check,
    "bounds": bounds_check,
    NOMINAL_VALUES: nominal_values_check,
    "starts": _starts,
    "start of the loop": _begun,
    "noise in the loop": _shaken,
}
