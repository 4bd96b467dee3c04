"""Sentences of the checks that compare the reported estimate with others, and with noise."""

from collections.abc import Sequence

from axisid.estimation.choices import open_loop_fit
from axisid.estimation.diagnostics import (
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
from axisid.support.settings import setting

from .dispatch import sentence
from .words import listed, one_after_another


@sentence.register
def agreement_of_estimates(finding: AgreementOfEstimates) -> str:
    """Return the sentences of all comparisons; if all pass, the reported method comes first."""
    texts = [sentence(each) for each in finding.findings]
    if finding.all_pass:
        texts.insert(0, f"{finding.reported.upper()} is reported")
    return one_after_another(texts)


@sentence.register
def instruments_against_output_error(finding: InstrumentsAgainstOutputError) -> str:
    """Return the differences between IDM-IV and DIDIM, the reported one, and likely causes."""
    comparison = finding.comparison
    if not comparison.differences:
        return (
            f"{_agreement(comparison)}. The regressor of {comparison.second.upper()} has no noise "
            "and no error of the prefilter"
        )
    reported = f"{_disagreement(comparison)}. {finding.reported.upper()} is reported"
    if finding.law_passed and finding.less_precise:
        return (
            f"{reported} although the recorded control follows the declared law, because the "
            f"standard errors of DIDIM are larger for {listed(finding.less_precise)}. Likely "
            "causes: the steps of the encoder or an unmodelled force (affect both)"
        )
    if finding.law_passed:
        return (
            f"{reported}, because the recorded control follows the declared law. Likely causes: a "
            "coarse encoder or an unsuitable prefilter (affects IDM-IV), or an unmodelled force "
            "(affects both)"
        )
    if finding.law_passed is None:
        return (
            f"{reported}, because DIDIM relies on the declared control law, which could not be "
            "checked"
        )
    return (
        f"{reported}, because DIDIM relies on the declared control law, which the recorded control "
        "does not follow. Check the units and the columns of the log before you use IDM-IV"
    )


@sentence.register
def least_squares_against_instruments(finding: LeastSquaresAgainstInstruments) -> str:
    """Return the differences between least squares and IV, which noise causes."""
    comparison = finding.comparison
    if not comparison.differences:
        return _agreement(comparison)
    return _disagreement(comparison, " because of noise")


@sentence.register
def direct_against_inverse(finding: DirectAgainstInverse) -> str:
    """Return the differences between inverse and direct least squares, and their causes.

    Large differences come with the advice to fit the position instead.
    """
    comparison = finding.comparison
    if not comparison.differences:
        return _agreement(comparison)
    text = (
        f"{_disagreement(comparison)}. Noise of the acceleration makes the inertia by "
        f"{comparison.second.upper()} too small. Noise of the force makes the inertia by "
        f"{comparison.first.upper()} too large. Without instruments it is unknown which noise "
        "causes the difference"
    )
    if not comparison.is_large:
        return text
    return (
        f"{text}. Fit the position under the recorded control instead, which needs no noisy "
        f"derivatives: {open_loop_fit()}"
    )


@sentence.register
def noise_bias(finding: NoiseBias) -> str:
    """Return the bias of least squares by noise, and the method without this bias."""
    method = finding.method.upper()
    if not finding.biases:
        return (
            f"noise biases {method} by at most {finding.largest:.2g} standard errors (limit: "
            f"{finding.most:g}), as simulated replicas of the record show"
        )
    text = (
        f"noise biases {method}: {_biases(finding.biases)}, as simulated replicas of the record "
        "show. The confidence intervals are corrected for this bias. Identify by instruments"
    )
    if not finding.instruments:
        return text
    return f"{text} with {setting('methods', finding.instruments)}"


@sentence.register
def quantisation_bias(finding: QuantisationBias) -> str:
    """Return the bias of least squares by the steps of the position, and its remedies."""
    method = finding.method.upper()
    remedy = (
        "Log the position as finely as the drive measures it, record the reference for "
        "instruments, or lower the cut-off"
    )
    if finding.fewest_steps is not None:
        return (
            f"the steps of the logged position bias {method} by an unknown amount, because the "
            f"whole motion has fewer than {finding.fewest_steps} steps. The confidence intervals "
            f"do not include this bias. {remedy}"
        )
    if finding.biases:
        return (
            f"the steps of the logged position bias {method}: {_biases(finding.biases)}. The "
            f"confidence intervals do not include this bias. {remedy}"
        )
    return (
        f"the steps of the logged position bias {method} by at most {finding.largest or 0.0:.2g} "
        f"standard errors (limit: {finding.most:g})"
    )


@sentence.register
def weakest_instrument(finding: WeakestInstrument) -> str:
    """Return the strength of the weakest instrument; a weak one comes with a warning."""
    if not finding.is_strong:
        return (
            "the instruments are weak: the simulated loop hardly explains the column of "
            f"{finding.column}{_conditional_f(finding)}. Do not use the estimate of "
            f"{finding.column} by instruments"
        )
    if finding.conditional_f is None:
        return "the simulated loop explains every column of the regressor exactly"
    return (
        "the instruments are strong: the simulated loop explains every column of the regressor, "
        f"the column of {finding.column} least{_conditional_f(finding)}"
    )


def _conditional_f(finding: WeakestInstrument) -> str:
    """Return the F statistic of the weakest instrument in parentheses; empty without one."""
    if finding.conditional_f is None:
        return ""
    return (
        f" (conditional first-stage F = {finding.conditional_f:.3g}; at least "
        f"{finding.least_f:g} is needed)"
    )


def _agreement(comparison: EstimateComparison) -> str:
    """Return the statement that two methods agree, with their largest difference."""
    largest = comparison.largest
    return (
        f"{comparison.first.upper()} and {comparison.second.upper()} agree within chance: the "
        f"largest difference is {largest.standard_errors:.2g} standard errors ({largest.name}; "
        f"standard errors of {comparison.second.upper()})"
    )


def _disagreement(comparison: EstimateComparison, cause: str = "") -> str:
    """Return the statement that two methods disagree, with every significant difference.

    `cause` is a phrase that follows "disagree"; empty for none.
    """
    first, second = comparison.first.upper(), comparison.second.upper()
    differences = [_difference(each, second) for each in comparison.differences]
    return (
        f"{first} and {second} disagree{cause}. After their known bias is subtracted, {first} "
        f"minus {second} is {listed(differences)}"
    )


def _difference(difference: ParameterDifference, second: str) -> str:
    """Return the difference of one parameter between two estimates, absolute and relative.

    The relative difference is omitted if its percentage is None. `second` is the name of the method
    whose standard errors are used.
    """
    percent = "" if difference.percent is None else f"{difference.percent:+.2g} %, "
    size = f"{difference.difference:+.2g} {difference.unit}".rstrip()
    return (
        f"{size} for {difference.name} ({percent}{difference.standard_errors:.2g} standard errors "
        f"of {second})"
    )


def _biases(biases: Sequence[ParameterBias]) -> str:
    """Return the bias of each parameter, in its unit and in standard errors."""
    texts = []
    for each in biases:
        size = f"{each.bias:+.2g} {each.unit}".rstrip()
        texts.append(f"{each.name} by about {size} ({each.standard_errors:.2g} standard errors)")
    return listed(texts)
