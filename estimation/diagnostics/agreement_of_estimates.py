"""Whether other estimates, noise or weak instruments speak against the estimate that is judged.

The strength of instruments is told by the first-stage F, alone and conditional on the other
columns, and by Shea's partial R squared.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.estimation.choices import OPEN_LOOP_FIT, instruments_of
from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import factor
from axisid.estimation.thresholds import MAX_RELATIVE_DEVIATION, MIN_FIRST_STAGE_F
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    WORST_FIRST,
    Check,
    Levels,
    status_of,
    unless_faulty,
)
from axisid.support.arrays import Array, MaybeInfinite, MaybeNan
from axisid.support.errors import Missing, first_case, unless_missing

from .hausman import NOTICEABLE_SHIFT, HausmanTest, significant_differences

#: Of a logged position: fewer are no noise.
FEWEST_STEPS = 64  # in a motion: 32 moved a stiffness by 22 %, of which as much again told nothing
#: Between two methods of which estimates are compared, the one less the other.
LESS = " less "
SECOND_OPINION = f"idm-iv{LESS}didim"
LS_LESS_IV = f"idm-ls{LESS}idm-iv", f"ddm-ls{LESS}ddm-iv"
DDM_LESS_IDM = f"ddm-ls{LESS}idm-ls"


Compared = Mapping[str, Mapping[str, HausmanTest] | Missing]


def method_check(
    judged: Estimate,
    estimates: Mapping[str, Estimate],
    compared: Compared,
    steps: Mapping[str, float],
    levels: Levels = DEFAULT_LEVELS,
    *,
    law_passed: bool | None,
) -> Check | Missing:
    """Whether another estimate, or what noise is known to do, speaks against the judged one.

    Parameters
    ----------
    judged : Estimate
    estimates : mapping of str to Estimate
        By method.
    compared : mapping of str to mapping of str to HausmanTest, or Missing
        By parameter, of one estimate less another; by what is compared, see `SECOND_OPINION`.
    steps : mapping of str to float
        What the steps of a logged position move a judged least squares by, see
        `DiagnosticInputs.steps`.
    levels : Levels
    law_passed : bool or None
        Whether the recorded control is the declared law's; None where that cannot be checked.
    """
    made = (
        _by_difference(
            SECOND_OPINION,
            compared,
            estimates,
            levels,
            "idm-iv and didim, whose regressor has no noise and no filter's error, are one "
            "estimate but for chance",
            lambda moved, listed: (
                f"idm-iv differs from didim, {listed}: "
                f"{_which_to_believe(moved, estimates, law_passed)}"
            ),
        ),
        _by_difference(
            next((pair for pair in LS_LESS_IV if pair in compared), ""),
            compared,
            estimates,
            levels,
            "least squares and instruments are one estimate but for chance",
            lambda _, listed: f"least squares differs from the instruments, {listed}, by noise",
            matters=False,  # as another estimate is judged
        ),
        _least_squares_judged(judged, steps, levels),
    )
    if not (found := [each for each in made if isinstance(each, Check)]):
        why = (each for each in compared.values() if isinstance(each, Missing))
        return next(why, Missing(f"nothing is compared with {judged.method}"))
    worst = min(found, key=lambda each: (WORST_FIRST.index(each.status), -(each.figure or 0.0)))
    told = "; ".join(each.meaning for each in found if each.status == worst.status)
    return replace(
        worst, meaning=f"{judged.method} is judged: {told}" if worst.status == "pass" else told
    )


def _by_difference(
    pair: str,
    compared: Compared,
    estimates: Mapping[str, Estimate],
    levels: Levels,
    same: str,
    apart: Callable[[Mapping[str, HausmanTest], str], str],
    *,
    matters: bool = True,
) -> Check | Missing | None:
    """Two estimates against each other, where they are compared.

    What is said is `same`, or `apart` of what they part in and a list of it. It is no more than a
    note where it does not matter.
    """
    found = compared.get(pair)
    if found is None or isinstance(found, Missing):
        return found
    one, other = (estimates[method].parameters for method in pair.split(LESS))
    moved, is_large, listed = significant_differences(found, levels.level), False, []
    for name, each in moved.items():
        value, by = other[name], each.difference
        precise = one[name].relative_deviation_percent < MAX_RELATIVE_DEVIATION.value
        widest = max(float(np.ptp(of[name].interval)) for of in (one, other))
        least = max(widest / 2, levels.least_share * abs(one[name].value))
        is_large |= matters and precise and abs(by) > least
        percent = f"{100 * by / value.value:+.2g} %, " if value.value else ""
        listed.append(f"{name} by {by:+.2g} {value.unit} ({percent}{each.shift:.2g} deviations)")
    worst = max((moved or found).values(), key=lambda each: each.shift)
    return Check(
        name="method",
        threshold=NOTICEABLE_SHIFT,
        status="fail" if is_large else "note" if moved else "pass",
        meaning=apart(moved, ", ".join(listed)) if moved else same,
        figure=worst.shift,
        source="largest difference of two estimates in deviations of the other; counts where a HAC "
        "test of all differences at once (Hausman, Hotelling, the p-value) rejects at "
        f"{100 * levels.level:g} %; a failure where it is more than {100 * levels.least_share:g} % "
        "of the value and more than either 95 % interval allows for",
        p_value=worst.joint_p_value,
    )


def less_precise(moved: Mapping[str, HausmanTest], iv: Estimate, didim: Estimate) -> list[str]:
    """What DIDIM knows less of among the parameters that the two part in.

    In these instruments are to be believed though the control is the law's: they differ from DIDIM
    in what they know more of. The encoder's steps, or a force that the model lacks, move both.
    """
    return [
        name for name in moved if didim.parameters[name].deviation > iv.parameters[name].deviation
    ]


def _which_to_believe(
    moved: Mapping[str, HausmanTest], estimates: Mapping[str, Estimate], law_passed: bool | None
) -> str:
    """Which of the two a control law speaks for, on which DIDIM alone rests."""
    less_sure = less_precise(moved, estimates["idm-iv"], estimates["didim"])
    return first_case(
        (
            law_passed and less_sure,
            "the encoder's steps, or a force that the model lacks, move both, and didim is the "
            f"vaguer in {', '.join(less_sure)}, so the verdict is of the instruments",
        ),
        (
            law_passed,
            "the control is the declared law's, so believe didim; a coarse encoder or a filter "
            "that does not suit moves the instruments, a force that the model lacks moves both",
        ),
        (
            law_passed is None,
            "the control law could not be checked, on which didim rests, so believe the "
            "instruments",
        ),
        (
            True,
            "the control law is not the declared one, on which didim rests, so believe the "
            "instruments where units and columns are right",
        ),
    )


def _least_squares_judged(
    judged: Estimate, steps: Mapping[str, float], levels: Levels
) -> Check | None:
    """What noise and steps move a judged least squares by: by its twins, or by the steps alone."""
    values, bias = judged.parameters, judged.filter_bias
    moved = steps if bias is None else dict(zip(values, map(float, bias), strict=True))
    if judged.Z is not None or not moved:
        return None
    what, whose, source, told = first_case(
        (
            bias is None,
            (
                "the steps of the logged position move",
                "",
                "what as much noise again as the steps of the position make moves least squares "
                f"by, in deviations; a failure where it is more than {100 * levels.least_share:g} "
                "% of the value",
                "its intervals miss for it: log the position as finely as the drive measures it, "
                "record the reference, from which instruments are made, or lower the cut-off",
            ),
        ),
        (
            True,
            (
                "noise moves",
                ", as its twins tell",
                "bias of least squares, as its twins tell, in deviations",
                "its intervals are less that: identify by instruments "
                f"({instruments_of(judged.method)})",
            ),
        ),
    )
    shifts = {n: abs(by) / values[n].deviation for n, by in moved.items() if values[n].deviation}
    far = {n: moved[n] for n, shift in shifts.items() if shift > NOTICEABLE_SHIFT}
    by = (
        ", ".join(f"{n} by about {by:+.2g} {values[n].unit}" for n, by in far.items())
        if np.all(np.isfinite([*far.values()]))
        else f"by what none tells, as there are fewer than {FEWEST_STEPS} in the whole motion"
    )
    large = bias is None and any(
        abs(by) > levels.least_share * abs(values[n].value) for n, by in far.items()
    )
    return Check(
        name="method",
        threshold=NOTICEABLE_SHIFT,
        status="fail" if large else "note" if far else "pass",
        meaning=f"{what} least squares, {by}{whose}, and {told}"
        if far
        else f"{what} least squares by less than half a deviation{whose}",
        figure=max(shifts.values(), default=0.0),
        source=source,
    )


def forms_check(
    compared: Compared, estimates: Mapping[str, Estimate], levels: Levels = DEFAULT_LEVELS
) -> Check | Missing | None:
    """The two forms of least squares: noise alone parts them, each to another side of the truth.

    None where instruments tell what noise does, or one of the forms is not there.
    """
    check = _by_difference(
        DDM_LESS_IDM,
        compared,
        estimates,
        levels,
        "least squares of the inverse and of the direct model are one estimate but for chance",
        lambda _, listed: (
            f"ddm-ls differs from idm-ls, {listed}: noise of the acceleration makes an inertia by "
            "idm-ls too small, that of the force one by ddm-ls too large, and without instruments "
            "nothing tells which"
        ),
    )
    if not isinstance(check, Check):
        return check
    advice = (
        "; take a fit of the position under the recorded control, which no noise of a derivative "
        f"moves: {OPEN_LOOP_FIT}"
    ) * (check.status == "fail")
    return replace(check, name="inverse against direct", meaning=check.meaning + advice)


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentStrength:
    """How strongly the instruments move one column of the regressor.

    Attributes
    ----------
    r_squared : float
        Of the column's regression on the instruments.
    shea : float
        The same beyond what the other columns' regressions explain.
    f : float
        F statistic of the regression; infinite, or null, for an exact one.
    conditional_f : float
        Conditional on the other columns [SandersonWindmeijer2016]_, of what they leave of this one:
        instruments may explain each of two columns well and yet not tell them apart. Infinite, or
        null, where it is exact.
    """

    r_squared: MaybeNan
    shea: MaybeNan
    f: MaybeInfinite
    conditional_f: MaybeInfinite


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTests:
    """Instruments against the regressor.

    Attributes
    ----------
    columns : tuple of InstrumentStrength
    condition_number : float
        Of ``Z'X``, unit columns.
    """

    columns: tuple[InstrumentStrength, ...]
    condition_number: MaybeInfinite


@unless_missing
def strength_check(tests: InstrumentTests, judged: Estimate) -> Check:
    """The weakest column of the regressor of an instrumental estimate, or of one beside `judged`.

    Beside an estimate by output error, which rests on the loop's own rows, weak ones are a note.
    """
    j, f = min(enumerate(c.conditional_f for c in tests.columns), key=lambda each: each[1])
    strong = f >= MIN_FIRST_STAGE_F.value
    return Check(
        name="instrument strength",
        status=status_of(strong, matters=not judged.by_output_error),
        figure=f if np.isfinite(f) else None,
        threshold=MIN_FIRST_STAGE_F.value,
        source="first-stage F of 10, the rule of Staiger and Stock (1997); conditional on the "
        "other columns as in Sanderson and Windmeijer (2016)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else "the simulated loop hardly explains the column of "
        f"{judged.form.quantities[j].label}: its estimate by instruments cannot be believed",
    )


def tests_of_instruments(estimate: Estimate | None) -> InstrumentTests | Missing:
    """`instrument_tests` of an estimate's rows, weighted by their records, where they tell it."""
    if estimate is None or estimate.Z is None:
        return Missing("no method with instruments gave an estimate")
    X, Z = (estimate.weights[:, None] * each for each in (estimate.X, estimate.Z))
    return unless_faulty(
        partial(instrument_tests, X, Z, [q.label for q in estimate.form.quantities])
    )


@np.errstate(divide="ignore")
def instrument_tests(X: Array, Z: Array, names: Sequence[str]) -> InstrumentTests:
    """First stage of every column, as in linearmodels' diagnostics.

    Parameters
    ----------
    X, Z : (n, k) arrays
        Regressor and instruments.
    names : sequence of str
        Of the columns' parameters.

    Raises
    ------
    EstimationError
        Either has not full column rank, as where one of several records does not show what all do.
    """
    n, k = X.shape
    regressor, instruments = factor(X, names), factor(Z, names, "the simulated loop")
    basis = instruments.basis.astype(float)
    fitted = basis @ (basis.T @ X)
    seen = factor(fitted, names, "the instruments together with the record")
    plain, projected = (np.sum(each.inverse**2, axis=1) for each in (regressor, seen))
    explained, unseen = np.sum(fitted**2, axis=0), X - fitted
    unexplained = np.sum(unseen**2, axis=0)
    # Of each column what the others, by two-stage least squares, leave; they take k - 1 of the
    # k instruments.
    beside = unseen @ (seen.inverse @ seen.inverse.T / projected).astype(float)
    is_exact = unexplained <= (1e-9 * regressor.scale) ** 2
    columns = zip(
        explained / (explained + unexplained),
        np.minimum(plain / projected, 1.0),
        explained / k / (unexplained / (n - k)),
        1 / projected / (np.where(is_exact, 0.0, np.sum(beside**2, axis=0)) / (n - k)),
        strict=True,
    )
    return InstrumentTests(
        columns=tuple(
            InstrumentStrength(
                r_squared=float(r), shea=float(shea), f=float(f), conditional_f=float(c)
            )
            for r, shea, f, c in columns
        ),
        condition_number=float(
            np.linalg.cond((Z / np.linalg.norm(Z, axis=0)).T @ (X / regressor.scale))
        ),
    )
