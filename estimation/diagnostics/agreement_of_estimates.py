"""Checks of the reported estimate: other estimates, noise, and the strength of the instruments.

The strength of instruments is measured by the first-stage F, alone and conditional on the other
columns, and by Shea's partial R squared.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.estimation.choices import instruments_of
from axisid.estimation.estimates import Estimate
from axisid.estimation.findings import Finding
from axisid.estimation.regression import factor
from axisid.estimation.thresholds import MAX_RELATIVE_DEVIATION, MIN_FIRST_STAGE_F
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    WORST_FIRST,
    Check,
    Levels,
    Status,
    status_of,
    unless_faulty,
)
from axisid.support.arrays import Array, MaybeInfinite, MaybeNan
from axisid.support.missing import Missing, unless_missing

from .agreement_findings import (
    AgreementOfEstimates,
    DirectAgainstInverse,
    EstimateComparison,
    InstrumentsAgainstOutputError,
    LeastSquaresAgainstInstruments,
    NoiseBias,
    ParameterBias,
    ParameterDifference,
    QuantisationBias,
    WeakestInstrument,
)
from .hausman import NOTICEABLE_SHIFT, HausmanTest, significant_differences

#: Fewest steps of a logged position in a motion for which rounding acts as noise: with 32 steps the
#: bias of a stiffness was 22 %, and added noise of the same size did not show it.
FEWEST_STEPS = 64
#: Text between the names of two methods in the name of a pair: the first minus the second.
LESS = " less "
#: Names of the pairs of methods whose estimates are compared.
SECOND_OPINION = f"idm-iv{LESS}didim"
LS_LESS_IV = f"idm-ls{LESS}idm-iv", f"ddm-ls{LESS}ddm-iv"
DDM_LESS_IDM = f"ddm-ls{LESS}idm-ls"


#: Tests of the difference between two estimates, by parameter, or the reason why there are none; by
#: the pair of methods, such as `SECOND_OPINION`.
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
    """Return the check of the reported estimate against other estimates, and of its bias by noise.

    Up to three checks are made: IDM-IV against DIDIM, least squares against instruments, and the
    bias of reported least squares. The one with the worst status is returned, with the findings of
    all checks of this status. Missing, with the reason, where none can be made.

    Parameters
    ----------
    judged : Estimate
        The reported estimate.
    estimates : mapping of str to Estimate
        Estimates by method.
    compared : mapping of str to mapping of str to HausmanTest, or Missing
        Tests by parameter, of one estimate minus another; by the pair of methods, see
        `SECOND_OPINION`.
    steps : mapping of str to float
        Bias of the reported least-squares estimate by the steps of a logged position, by
        parameter; empty where there is none, see `DiagnosticInputs.steps`.
    levels : Levels
    law_passed : bool or None
        Whether the recorded control follows the declared law; None where that cannot be checked.
    """
    made = (
        _second_opinion_check(compared, estimates, levels, law_passed),
        _instruments_check(compared, estimates, levels),
        _bias_check(judged, steps, levels),
    )
    found = [each for each in made if isinstance(each, Check)]
    if not found:
        reasons = (each for each in compared.values() if isinstance(each, Missing))
        method = judged.method.upper()
        return next(reasons, Missing(f"there is no other estimate to compare {method} with"))
    worst = min(found, key=lambda each: (WORST_FIRST.index(each.status), -(each.figure or 0.0)))
    agreement = AgreementOfEstimates(
        reported=judged.method,
        findings=tuple(each.finding for each in found if each.status == worst.status),
        all_pass=worst.status == "pass",
    )
    return replace(worst, finding=agreement)


def _second_opinion_check(
    compared: Compared,
    estimates: Mapping[str, Estimate],
    levels: Levels,
    law_passed: bool | None,
) -> Check | None:
    """Return the check of IDM-IV against DIDIM, which relies on the declared control law.

    None where the two are not compared.
    """
    comparison = _comparison_of(SECOND_OPINION, compared, estimates, levels)
    if comparison is None:
        return None
    names = [each.name for each in comparison.differences]
    less_sure = less_precise(names, estimates["idm-iv"], estimates["didim"])
    finding = InstrumentsAgainstOutputError(
        comparison=comparison,
        reported="didim" if law_passed and not less_sure else "idm-iv",
        law_passed=law_passed,
        less_precise=tuple(less_sure),
    )
    return _check_of(comparison, finding, levels)


def _instruments_check(
    compared: Compared, estimates: Mapping[str, Estimate], levels: Levels
) -> Check | None:
    """Return the check of least squares against instruments; None where they are not compared.

    It is at most a note, because the reported estimate is then not that of least squares.
    """
    for pair in LS_LESS_IV:
        if pair in compared:
            comparison = _comparison_of(pair, compared, estimates, levels)
            if comparison is None:
                return None
            finding = LeastSquaresAgainstInstruments(comparison=comparison)
            return _check_of(comparison, finding, levels, matters=False)
    return None


def _comparison_of(
    pair: str, compared: Compared, estimates: Mapping[str, Estimate], levels: Levels
) -> EstimateComparison | None:
    """Return the differences between the estimates of a pair of methods, with their significance.

    None where the two are not compared.
    """
    tests = compared.get(pair)
    if tests is None or isinstance(tests, Missing):
        return None
    first, second = pair.split(LESS)
    significant = significant_differences(tests, levels.level)
    shown = significant or tests
    largest = max(shown, key=lambda name: shown[name].shift)
    differences, is_large = list[ParameterDifference](), False
    for name, test in significant.items():
        differences.append(_difference(name, test, estimates[second]))
        if _is_large(name, test.difference, estimates[first], estimates[second], levels):
            is_large = True
    return EstimateComparison(
        first=first,
        second=second,
        differences=tuple(differences),
        largest=_difference(largest, shown[largest], estimates[second]),
        p_value=float(shown[largest].joint_p_value),
        is_large=is_large,
    )


def _difference(name: str, test: HausmanTest, other: Estimate) -> ParameterDifference:
    """Return the finding of a difference from the estimate `other`, in percent of which it is."""
    value = other.parameters[name]
    percent = float(100 * test.difference / value.value) if value.value else None
    return ParameterDifference(
        name=name,
        difference=float(test.difference),
        unit=str(value.unit),
        percent=percent,
        standard_errors=float(test.shift),
    )


def _is_large(name: str, difference: float, one: Estimate, other: Estimate, levels: Levels) -> bool:
    """Return True for a difference that is large for the parameter.

    It is larger than the half widths of both 95 % intervals and than `levels.least_share` of the
    value, and the parameter is precise in the estimate `one`.
    """
    values = one.parameters[name], other.parameters[name]
    if not values[0].relative_deviation_percent < MAX_RELATIVE_DEVIATION.value:
        return False
    widest = max(float(np.ptp(each.interval)) for each in values)
    return abs(difference) > max(widest / 2, levels.least_share * abs(values[0].value))


def _check_of(
    comparison: EstimateComparison,
    finding: Finding,
    levels: Levels,
    *,
    name: str = "method",
    matters: bool = True,
) -> Check:
    """Return the check of two estimates.

    It passes without significant differences, and fails where one of them is large. Otherwise, and
    always if `matters` is False, significant differences are a note.

    Parameters
    ----------
    comparison : EstimateComparison
        Differences between the two estimates.
    finding : Finding
        Finding of the check, which contains the comparison.
    levels : Levels
    name : str
        Name of the check.
    matters : bool
        Whether large differences fail the check.
    """
    status: Status = "pass"
    if comparison.differences:
        status = "fail" if matters and comparison.is_large else "note"
    return Check(
        name=name,
        threshold=NOTICEABLE_SHIFT,
        status=status,
        finding=finding,
        figure=comparison.largest.standard_errors,
        source=f"largest difference of a parameter between {comparison.first.upper()} and "
        f"{comparison.second.upper()}, in standard errors of {comparison.second.upper()}. The "
        "estimates differ significantly if a HAC test of all differences at once (Hausman's test "
        f"with Hotelling's distribution) rejects equality at {100 * levels.level:g} %. A "
        "significant difference above the threshold is a note. The check fails if the difference "
        f"is also (1) more than {100 * levels.least_share:g} % of the value and (2) larger than "
        "half the width of both 95 % intervals",
        p_value=comparison.p_value,
    )


def less_precise(moved: Iterable[str], iv: Estimate, didim: Estimate) -> list[str]:
    """Return the parameters with a larger standard error by DIDIM than by IDM-IV.

    For these parameters, IDM-IV is the better estimate although the control follows the declared
    law. Encoder steps, or an unmodelled force, bias both methods.

    Parameters
    ----------
    moved : iterable of str
        Parameters in which the two estimates differ significantly.
    iv, didim : Estimate
        Estimates by IDM-IV and by DIDIM.
    """
    return [
        name for name in moved if didim.parameters[name].deviation > iv.parameters[name].deviation
    ]


def _bias_check(judged: Estimate, steps: Mapping[str, float], levels: Levels) -> Check | None:
    """Return the check of a reported least-squares estimate for bias.

    If simulated replicas give the bias by noise, that bias is checked, otherwise the bias by the
    steps of a logged position. None for an estimate with instruments, and where neither is known.
    """
    if judged.Z is not None:
        return None
    if judged.filter_bias is not None:
        return _noise_check(judged, judged.filter_bias)
    if steps:
        return _quantisation_check(judged, steps, levels)
    return None


def _noise_check(judged: Estimate, bias: Array) -> Check | None:
    """Return the check for bias by noise, which simulated replicas show; None without parameters.

    The check is at most a note, because the intervals of the estimate are corrected for the bias.

    Parameters
    ----------
    judged : Estimate
        Reported least-squares estimate.
    bias : (p,) array
        Bias of each of its parameters.
    """
    by_parameter = dict(zip(judged.parameters, map(float, bias), strict=True))
    if not by_parameter:
        return None
    biases = _biases(judged, by_parameter)
    noticeable = _noticeable(biases)
    largest = max((each.standard_errors for each in biases), default=0.0)
    return Check(
        name="method",
        threshold=NOTICEABLE_SHIFT,
        status="note" if noticeable else "pass",
        finding=NoiseBias(
            method=judged.method,
            biases=noticeable,
            largest=largest,
            most=NOTICEABLE_SHIFT,
            instruments=instruments_of(judged.method),
        ),
        figure=largest,
        source="largest bias of a parameter by least squares, in standard errors of the estimate, "
        "found with simulated replicas of the record",
    )


def _quantisation_check(judged: Estimate, steps: Mapping[str, float], levels: Levels) -> Check:
    """Return the check for bias by the steps of the logged position.

    It fails where a bias is more than `levels.least_share` of the value.

    Parameters
    ----------
    judged : Estimate
        Reported least-squares estimate.
    steps : mapping of str to float
        Bias by parameter; infinite where the position has too few steps to calculate the bias.
    levels : Levels
    """
    biases = _biases(judged, steps)
    noticeable = _noticeable(biases)
    largest = max((each.standard_errors for each in biases), default=0.0)
    is_unknown = not all(np.isfinite(each.bias) for each in noticeable)
    status: Status = "note" if noticeable else "pass"
    for each in noticeable:
        if abs(each.bias) > levels.least_share * abs(judged.parameters[each.name].value):
            status = "fail"
    return Check(
        name="method",
        threshold=NOTICEABLE_SHIFT,
        status=status,
        finding=QuantisationBias(
            method=judged.method,
            biases=() if is_unknown else noticeable,
            largest=None if is_unknown else largest,
            most=NOTICEABLE_SHIFT,
            fewest_steps=FEWEST_STEPS if is_unknown else None,
        ),
        figure=largest,
        source="largest change of a parameter by least squares, in standard errors, when noise of "
        "the same size as the rounding of the position is added to the position. Beyond the "
        "threshold, the check is a note. The check fails where the change is also more than "
        f"{100 * levels.least_share:g} % of the value",
    )


def _biases(judged: Estimate, by_parameter: Mapping[str, float]) -> tuple[ParameterBias, ...]:
    """Return the bias of each parameter with a standard error, as findings.

    `by_parameter` has the bias by the name of the parameter, in its unit.
    """
    found = list[ParameterBias]()
    for name, bias in by_parameter.items():
        value = judged.parameters[name]
        if value.deviation:
            found.append(
                ParameterBias(
                    name=name,
                    bias=float(bias),
                    unit=str(value.unit),
                    standard_errors=float(abs(bias) / value.deviation),
                )
            )
    return tuple(found)


def _noticeable(biases: Sequence[ParameterBias]) -> tuple[ParameterBias, ...]:
    """Return the biases of more than `NOTICEABLE_SHIFT` standard errors."""
    return tuple(each for each in biases if each.standard_errors > NOTICEABLE_SHIFT)


def forms_check(
    compared: Compared, estimates: Mapping[str, Estimate], levels: Levels = DEFAULT_LEVELS
) -> Check | Missing | None:
    """Return the check of least squares of the direct model against that of the inverse model.

    Noise biases the two in different ways. None where they are not compared: there are instruments,
    or one of the two estimates is missing. Missing, with the reason, where they cannot be compared.
    """
    tests = compared.get(DDM_LESS_IDM)
    if isinstance(tests, Missing):
        return tests
    comparison = _comparison_of(DDM_LESS_IDM, compared, estimates, levels)
    if comparison is None:
        return None
    finding = DirectAgainstInverse(comparison=comparison)
    return _check_of(comparison, finding, levels, name="inverse against direct")


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentStrength:
    """Strength of the instruments for one column of the regressor.

    Attributes
    ----------
    r_squared : float
        R squared of the regression of the column on the instruments.
    shea : float
        Shea's partial R squared: R squared of the part that the other columns do not explain.
    f : float
        F statistic of the regression; infinite, or null, for an exact regression.
    conditional_f : float
        F statistic conditional on the other columns [SandersonWindmeijer2016]_, for the part of
        this column that the others do not explain. The instruments may explain two columns well
        and still not distinguish them. Infinite, or null, for an exact regression.
    """

    r_squared: MaybeNan
    shea: MaybeNan
    f: MaybeInfinite
    conditional_f: MaybeInfinite


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTests:
    """Tests of the instruments against the regressor.

    Attributes
    ----------
    columns : tuple of InstrumentStrength
        Strength for each column of the regressor, in order.
    condition_number : float
        Condition number of ``Z'X``, with columns of norm 1.
    """

    columns: tuple[InstrumentStrength, ...]
    condition_number: MaybeInfinite


@unless_missing
def strength_check(tests: InstrumentTests, judged: Estimate) -> Check:
    """Return the check of the column of the regressor that the instruments explain least.

    Weak instruments are a note for an output-error estimate, which uses only the rows of the
    simulated loop.
    """
    statistics = [column.conditional_f for column in tests.columns]
    weakest = min(range(len(statistics)), key=lambda j: statistics[j])
    f = statistics[weakest]
    figure = float(f) if np.isfinite(f) else None
    strong = bool(f >= MIN_FIRST_STAGE_F.value)
    return Check(
        name="instrument strength",
        status=status_of(strong, matters=not judged.by_output_error),
        figure=figure,
        threshold=MIN_FIRST_STAGE_F.value,
        source="smallest first-stage F statistic of a column of the regressor, conditional on the "
        "other columns as in Sanderson and Windmeijer (2016). The instruments are weak below 10, "
        "the rule of Staiger and Stock (1997)",
        finding=WeakestInstrument(
            column=judged.form.quantities[weakest].label,
            conditional_f=figure,
            least_f=MIN_FIRST_STAGE_F.value,
            is_strong=strong,
        ),
    )


def tests_of_instruments(estimate: Estimate | None) -> InstrumentTests | Missing:
    """Return the tests of an estimate's instruments, or the reason why there are none.

    The rows are weighted as in the estimate, by the noise of their records. `estimate` is None
    where no method with instruments gave an estimate.
    """
    if estimate is None or estimate.Z is None:
        return Missing("no method with instruments gave an estimate")
    X, Z = (estimate.weights[:, None] * each for each in (estimate.X, estimate.Z))
    return unless_faulty(
        partial(instrument_tests, X, Z, [q.label for q in estimate.form.quantities])
    )


@np.errstate(divide="ignore")
def instrument_tests(X: Array, Z: Array, names: Sequence[str]) -> InstrumentTests:
    """Return first-stage statistics of every column of the regressor.

    Each column is regressed on the instruments. R squared and F are those of this regression.
    Shea's R squared and the conditional F apply to the part of the column that the other columns do
    not explain. The package linearmodels gives the same numbers.

    Parameters
    ----------
    X, Z : (n, k) arrays
        Regressor and instruments.
    names : sequence of str
        Names of the parameters of the columns.

    Raises
    ------
    EstimationError
        The regressor or the instruments do not have full column rank, as where one of several
        records does not identify a parameter that all records together identify.
    """
    n, k = X.shape
    regressor, instruments = factor(X, names), factor(Z, names, "the simulated loop")
    # First stage: the part of each column in the span of the instruments, and its residual.
    basis = instruments.basis.astype(float)
    fitted = basis @ (basis.T @ X)
    residuals = X - fitted
    explained, unexplained = np.sum(fitted**2, axis=0), np.sum(residuals**2, axis=0)
    # Diagonals of (X'X)^-1 and of the same inverse for the fitted columns.
    fitted_factor = factor(fitted, names, "the instruments together with the record")
    inverse, fitted_inverse = (
        np.sum(each.inverse**2, axis=1) for each in (regressor, fitted_factor)
    )
    # Residual of each column on the others, by two-stage least squares with k - 1 of the k
    # instruments.
    on_others = (fitted_factor.inverse @ fitted_factor.inverse.T / fitted_inverse).astype(float)
    unexplained_by_others = np.sum((residuals @ on_others) ** 2, axis=0)
    is_exact = unexplained <= (1e-9 * regressor.scale) ** 2
    # The statistics of each column.
    columns = zip(
        explained / (explained + unexplained),
        np.minimum(inverse / fitted_inverse, 1.0),
        explained / k / (unexplained / (n - k)),
        1 / fitted_inverse / (np.where(is_exact, 0.0, unexplained_by_others) / (n - k)),
        strict=True,
    )
    strengths = list[InstrumentStrength]()
    for r_squared, shea, f, conditional_f in columns:
        strengths.append(
            InstrumentStrength(
                r_squared=float(r_squared),
                shea=float(shea),
                f=float(f),
                conditional_f=float(conditional_f),
            )
        )
    unit_instruments = Z / np.linalg.norm(Z, axis=0)
    return InstrumentTests(
        columns=tuple(strengths),
        condition_number=float(np.linalg.cond(unit_instruments.T @ (X / regressor.scale))),
    )
